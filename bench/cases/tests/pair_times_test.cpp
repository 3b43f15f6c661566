// How long each muscle took with each bone, where muscles are told apart.
#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/tests/bar_and_ball.hpp"

namespace musclebench {
namespace {

using namespace bar_and_ball;

struct Detection {
  std::vector<Contact> contacts;
  std::vector<Nanoseconds> times_ns;
};

bool is_same(const Contact& a, const Contact& b) {
  return a.node == b.node && a.bone == b.bone && a.depth_m == b.depth_m && a.normal == b.normal;
}

class PairTimes : public testing::Test {
 protected:
  /// Of nodes that lie 1 mm lower than at rest, after one detection that fills caches.
  Detection detect(const std::string& backend, const std::vector<std::string>& options, bool told_apart,
                   std::span<const int> nodes, int threads = 1) {
    const BackendEntry& entry = find_backend(backend);
    const Parameters parameters(entry.parameters, {}, "test");
    const auto made = make_backend(m_scene, entry, parameters, choose_collider_backends(options, m_scene, entry));
    if (told_apart) made->tell_apart(m_scene.bodies());
    made->build(m_scene.bones, m_scene.muscle_mesh, threads);
    const std::vector<RigidMotion> poses(m_scene.bones.size());
    std::vector<Vec3> positions = m_scene.muscle_mesh.vertices;
    Detection found;
    for (int step = 0; step < 2; ++step) {
      for (Vec3& position : positions) position.z() -= 0.0005;
      made->update(poses, positions);
      made->detect(positions, nodes, found.contacts);
    }
    found.times_ns.assign(made->pair_times().begin(), made->pair_times().end());
    return found;
  }

  std::vector<int> all_nodes() const {
    std::vector<int> nodes(m_scene.muscle_mesh.vertices.size());
    std::iota(nodes.begin(), nodes.end(), 0);
    return nodes;
  }

  const Scene m_scene = read_scene(request(both()));
};

TEST_F(PairTimes, AreThereForEveryPairAndChangeNoContact) {
  for (const BackendEntry& entry : backend_registry()) {
    for (const int threads : {1, 2}) {
      const Detection plain = detect(entry.name, {}, false, all_nodes(), threads);
      const Detection timed = detect(entry.name, {}, true, all_nodes(), threads);
      EXPECT_TRUE(std::ranges::equal(timed.contacts, plain.contacts, is_same)) << entry.name;
      EXPECT_TRUE(plain.times_ns.empty()) << entry.name;
      if (!entry.make(Parameters(entry.parameters, {}, "test"))->capabilities().times_pairs) {
        EXPECT_TRUE(timed.times_ns.empty()) << entry.name;
        continue;
      }
      ASSERT_EQ(timed.times_ns.size(), 4U) << entry.name;
      EXPECT_TRUE(std::ranges::all_of(timed.times_ns, [](Nanoseconds ns) { return ns >= 0; })) << entry.name;
      if (!plain.contacts.empty()) {
        EXPECT_GT(timed.times_ns[bar_on_plate], 0) << entry.name;
      }
    }
  }
}

TEST_F(PairTimes, BelongToTheMuscleThatIsAskedAbout) {
  const Body& ball = m_scene.muscles[1].body;
  std::vector<int> nodes(static_cast<std::size_t>(ball.last_node - ball.first_node));
  std::iota(nodes.begin(), nodes.end(), ball.first_node);
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{}, {"ball/plate=brute_force"}, {"lid=brute_force"}, {"bar/lid=sdf:cells=16"}}) {
    const std::vector<Nanoseconds> times_ns = detect("bvh", options, true, nodes).times_ns;
    ASSERT_EQ(times_ns.size(), 4U);
    EXPECT_EQ(times_ns[bar_on_plate], 0);
    EXPECT_EQ(times_ns[bar_at_lid], 0);
    EXPECT_GT(times_ns[ball_on_plate], 0);
  }
  EXPECT_GT(detect("bvh", {"ball/lid=brute_force"}, true, nodes).times_ns[ball_at_lid], 0);
  EXPECT_GT(detect("brute_force", {}, true, nodes).times_ns[ball_at_lid], 0);
}

TEST_F(PairTimes, OfBackendsByPairAreThoseOfEach) {
  // All triangles of the plate for each node take far longer than a tree or what a cache answers.
  for (const std::size_t slow : {bar_on_plate, ball_on_plate}) {
    const std::string option = slow == bar_on_plate ? "bar/plate=brute_force" : "ball/plate=brute_force";
    const std::vector<Nanoseconds> times_ns = detect("bvh", {option}, true, all_nodes()).times_ns;
    ASSERT_EQ(times_ns.size(), 4U);
    EXPECT_EQ(std::ranges::max_element(times_ns) - times_ns.begin(), static_cast<std::ptrdiff_t>(slow));
  }
}

}  // namespace
}  // namespace musclebench

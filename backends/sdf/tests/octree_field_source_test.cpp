#include "backends/sdf/octree_field_source.hpp"

#include <filesystem>
#include <numeric>

#include <gtest/gtest.h>

#include "backends/sdf/files/kept_fields.hpp"
#include "backends/sdf/sdf_backend.hpp"
#include "core/base/input_error.hpp"
#include "core/base/random_numbers.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/mesh/shapes.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

using Given = std::map<std::string, ParameterValue>;

std::unique_ptr<CollisionBackend> make_adaptive(Given given = {}) {
  given.emplace("max_error_mm", 0.5);
  return make_sdf_backend(Parameters(sdf_parameters(), given, "test"));
}

const std::vector<Bone>& bones() {
  static const std::vector<Bone> made{{"ball", {make_sphere(0.1, 3), true, {}}},
                                      {"box/of 2", {make_box({0.05, 0.1, 0.05}, 3), true, {}}}};
  return made;
}

std::vector<Vec3> scattered_points(RandomNumbers& random, int count) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = random.share();
    const double y = random.share();
    points.push_back(0.3 * (Vec3(x, y, random.share()) - Vec3::Constant(0.5)));
  }
  return points;
}

std::vector<Contact> contacts_of(CollisionBackend& backend, const std::vector<RigidMotion>& poses,
                                 const std::vector<Vec3>& positions) {
  std::vector<int> nodes(positions.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<Contact> contacts;
  backend.update(poses, positions);
  backend.detect(positions, nodes, contacts);
  return contacts;
}

TEST(OctreeFieldSource, FindsDepthAndNormalInMovedBones) {
  const auto backend = make_adaptive();
  backend->build(bones(), {}, 2);
  RandomNumbers random(1);
  const std::vector<Vec3> positions = scattered_points(random, 3000);
  const std::vector<RigidMotion> poses{RigidMotion::about_axis(Vec3(1, 2, 2) / 3, {0.1, 0, 0}, 1),
                                       RigidMotion::about_axis(Vec3(2, 1, 2) / 3, {0, 0.05, 0}, 0.5)};
  std::vector<std::vector<bool>> found(2, std::vector<bool>(positions.size(), false));
  int near = 0;
  const SignedSurface surfaces[]{SignedSurface(bones()[0].surface), SignedSurface(bones()[1].surface)};
  for (const Contact& contact : contacts_of(*backend, poses, positions)) {
    const auto bone = static_cast<std::size_t>(contact.bone);
    const auto node = static_cast<std::size_t>(contact.node);
    found[bone][node] = true;
    const Vec3 at = poses[bone].apply_inverse(positions[node]);
    const SignedPoint exact = surfaces[bone].locate(at);
    EXPECT_NEAR(contact.normal.norm(), 1, 1e-12);
    EXPECT_NEAR(contact.depth_m, -exact.signed_distance_m(), 2e-3 + 0.3 * exact.closest.distance_m);
    if (exact.closest.distance_m < 1.5e-3) {
      EXPECT_NEAR(contact.depth_m, -exact.signed_distance_m(), 2e-3);
      near += contact.normal.dot(poses[bone].apply_to_direction(surfaces[bone].outward(at, exact))) > 0.95 ? 1 : 0;
    }
  }
  EXPECT_GT(near, 20);
  for (std::size_t bone = 0; bone < 2; ++bone) {
    const AnswerBound bound = backend->answer_bound(static_cast<int>(bone));
    for (std::size_t node = 0; node < positions.size(); ++node) {
      const double exact = surfaces[bone].locate(poses[bone].apply_inverse(positions[node])).signed_distance_m();
      EXPECT_TRUE(found[bone][node] || exact >= -std::min(2e-3, bound.missed_depth_m)) << exact;
      EXPECT_TRUE(!found[bone][node] || exact <= std::min(2e-3, bound.false_distance_m)) << exact;
    }
  }
}

TEST(OctreeFieldSource, CacheAndThreadsChangeNoContact) {
  const auto made = [](const std::string& cache, int threads) {
    auto backend = make_adaptive({{"clearance_cache", cache}});
    backend->build(bones(), {}, threads);
    return backend;
  };
  const auto plain = made("off", 1);
  std::vector<std::unique_ptr<CollisionBackend>> others;
  others.push_back(made("on", 1));
  others.push_back(made("off", 3));
  others.push_back(made("on", 3));
  constexpr int nodes = 3000;  // several shares
  RandomNumbers random(7);
  std::vector<Vec3> positions = scattered_points(random, nodes);
  std::size_t met = 0;
  for (int step = 0; step < 40; ++step) {
    const std::vector<RigidMotion> poses{RigidMotion::about_axis(Vec3::UnitX(), Vec3::Zero(), 0.01 * step),
                                         RigidMotion::about_axis(Vec3::UnitZ(), {0.1, 0, 0}, -0.02 * step)};
    const std::vector<Vec3> shifts = scattered_points(random, nodes);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      positions[i] += (i % 10 == 0 ? 0.5 : 0.005) * shifts[i];
    }
    const std::vector<Contact> expected = contacts_of(*plain, poses, positions);
    met += expected.size();
    for (const auto& backend : others) {
      const std::vector<Contact> found = contacts_of(*backend, poses, positions);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        ASSERT_EQ(found[i].node, expected[i].node);
        ASSERT_EQ(found[i].bone, expected[i].bone);
        ASSERT_EQ(found[i].depth_m, expected[i].depth_m);
        ASSERT_EQ(found[i].normal, expected[i].normal);
      }
    }
  }
  EXPECT_GT(met, 10000U);
}

TEST(OctreeFieldSource, FindsItsFieldsAgain) {
  const TemporaryFolder folder;
  const Given given{{"structures", folder.path().string()}};
  for (const bool again : {false, true}) {
    const auto backend = make_adaptive(given);
    backend->build(bones(), {}, 1);
    EXPECT_EQ(backend->structure_origin().is_from_file, again);
    EXPECT_GT(backend->structure_bytes(), 1000U);
  }
  EXPECT_TRUE(
      std::filesystem::exists(folder / content_address("0.5mm", surface_digest(bones().front().surface), "octree")));
}

TEST(OctreeFieldSource, RefusesCellsOfOneSizeBesideAnError) {
  EXPECT_THROW(make_adaptive({{"cell_size_m", 0.01}}), InputError);
  EXPECT_THROW(make_adaptive({{"discregrid", std::string("here")}}), InputError);
}

}  // namespace
}  // namespace musclebench

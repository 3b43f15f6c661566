#include "core/clearance/point_backend.hpp"

#include <atomic>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/random_points.hpp"

namespace musclebench {
namespace {

/// Queries of the structures of a test.
struct Log {
  std::atomic<int> queried = 0;
  std::atomic<int> batches = 0;
  std::atomic<int> resets = 0;
  bool had_clearances = false;
};

/// The ball of radius 1 about the origin; gives every free node its distance as clearance.
class BallStructure final : public BoneStructure {
 public:
  BallStructure(Log& log, bool from_file) : m_log(log), m_from_file(from_file) {}

  [[nodiscard]] AnswerBound answer_bound() const override { return {0.5, 0.25}; }
  [[nodiscard]] std::size_t bytes() const override { return 100; }
  [[nodiscard]] double step_m() const override { return 0.125; }
  [[nodiscard]] std::optional<StructureError> error() const override {
    return m_from_file ? std::optional(StructureError{"", 100, 1, 0.5, 0.25}) : std::nullopt;
  }
  [[nodiscard]] StructureOrigin origin() const override {
    return m_from_file ? StructureOrigin{true, 7} : StructureOrigin{};
  }
  void reset_nodes(std::size_t /*nodes*/) override { ++m_log.resets; }

  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) override {
    ++m_log.batches;
    m_log.queried += static_cast<int>(batch.nodes.size());
    if (batch.clearances != nullptr) m_log.had_clearances = true;
    for (const int node : batch.nodes) {
      const Vec3 point = batch.pose.apply_inverse(batch.positions[static_cast<std::size_t>(node)]);
      const double distance_m = point.norm() - 1;
      if (distance_m < 0) {
        contacts.push_back({node, batch.bone, -distance_m, batch.pose.apply_to_direction(point.normalized())});
      } else if (batch.clearances != nullptr) {
        batch.clearances->store(batch.bone, node, point, distance_m);
      }
    }
  }

 private:
  Log& m_log;
  bool m_from_file;
};

class PointBackendTest : public testing::Test {
 protected:
  std::unique_ptr<CollisionBackend> made(PointMethod method, std::vector<bool> from_file = {false, false},
                                         int threads = 1) {
    method.build = [this, from_file, next = std::size_t{0}](const Bone& /*bone*/, int /*threads*/,
                                                            const ShareReport& report) mutable {
      if (report) report(0.5);
      return std::make_unique<BallStructure>(m_log, from_file[next++]);
    };
    auto backend = make_point_backend(std::move(method));
    if (m_expect_right_untouched) backend->expect_within({unbounded_box(), Eigen::AlignedBox3d()});
    backend->report_build_to([this](double share) { m_shares.push_back(share); });
    backend->build(m_bones, m_muscle, threads);
    return backend;
  }

  /// Two bones: about the origin, and moved by 1 along x.
  std::vector<Contact> contacts(CollisionBackend& backend, const std::vector<Vec3>& positions) {
    const std::vector<RigidMotion> poses = {RigidMotion{}, RigidMotion{Mat3::Identity(), Vec3::UnitX()}};
    std::vector<int> nodes(positions.size());
    std::iota(nodes.begin(), nodes.end(), 0);
    std::vector<Contact> found;
    backend.update(poses, positions);
    backend.detect(positions, nodes, found);
    return found;
  }

  Log m_log;
  bool m_expect_right_untouched = false;
  std::vector<double> m_shares;
  TriangleMesh m_muscle = make_box(Vec3(1, 1, 1), 1);
  std::vector<Bone> m_bones = {{"left", {make_sphere(1, 1), true, {}}}, {"right", {make_sphere(1, 1), true, {}}}};
};

TEST_F(PointBackendTest, ContactsAreOrderedAndTheSameForAnyNumberOfThreads) {
  const std::vector<Vec3> positions = random_points(2, 101);
  const std::vector<Contact> alone = contacts(*made({.nodes_a_batch = 8}), positions);
  EXPECT_EQ(m_log.batches, 2);
  ASSERT_GT(alone.size(), 5U);
  for (std::size_t i = 1; i < alone.size(); ++i) {
    EXPECT_LT(std::pair(alone[i - 1].bone, alone[i - 1].node), std::pair(alone[i].bone, alone[i].node));
  }
  for (const int threads : {2, 3}) {
    m_log.batches = 0;
    const std::vector<Contact> together = contacts(*made({.nodes_a_batch = 8}, {false, false}, threads), positions);
    EXPECT_EQ(m_log.batches, 2 * 13);
    ASSERT_EQ(together.size(), alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(together[i].node, alone[i].node);
      EXPECT_EQ(together[i].bone, alone[i].bone);
      EXPECT_EQ(together[i].depth_m, alone[i].depth_m);
      EXPECT_EQ(together[i].normal, alone[i].normal);
    }
  }
}

TEST_F(PointBackendTest, WithACacheOnlyThoseAreAskedThatMayHaveCome) {
  const auto backend = made({.capabilities = {.has_cache = true}});
  std::vector<Vec3> positions = random_points(2, 101);
  const std::size_t found = contacts(*backend, positions).size();
  EXPECT_EQ(m_log.queried, 2 * 101);
  m_log.queried = 0;
  EXPECT_EQ(contacts(*backend, positions).size(), found);
  EXPECT_EQ(m_log.queried, static_cast<int>(found)) << "those in contact have no clearance";
  m_log.queried = 0;
  m_log.resets = 0;
  positions.emplace_back(3, 3, 3);
  contacts(*backend, positions);
  EXPECT_EQ(m_log.queried, 2 * 102) << "another muscle: nothing is known of it";
  EXPECT_EQ(m_log.resets, 2);
}

TEST_F(PointBackendTest, WhereAQueryIsCheapAFewNodesAreAskedAboutWithoutTheCache) {
  const auto backend = made({.capabilities = {.has_cache = true}, .asks_few_without_cache = true});
  const std::vector<Vec3> positions = random_points(2, 100);
  const std::size_t found = contacts(*backend, positions).size();
  EXPECT_TRUE(m_log.had_clearances);
  m_log.queried = 0;
  EXPECT_EQ(contacts(*backend, positions).size(), found);
  EXPECT_EQ(m_log.queried, static_cast<int>(found)) << "all nodes: by the cache";
  std::vector<int> few(24);
  std::iota(few.begin(), few.end(), 0);
  std::vector<Contact> of_few;
  m_log.queried = 0;
  m_log.had_clearances = false;
  backend->detect(positions, few, of_few);
  EXPECT_EQ(m_log.queried, 2 * 24);
  EXPECT_FALSE(m_log.had_clearances);
  few.push_back(24);
  m_log.queried = 0;
  backend->detect(positions, few, of_few);
  EXPECT_LT(m_log.queried, 2 * 25) << "a quarter of all is swept";
}

TEST_F(PointBackendTest, OverAnOpenBoneThereIsACacheOnlyWhereDistancesAreSigned) {
  m_bones[1].surface.mesh.triangles.pop_back();
  contacts(*made({.capabilities = {.has_cache = true}, .cache_needs_closed_bones = true}), random_points(2, 5));
  EXPECT_FALSE(m_log.had_clearances);
  contacts(*made({.capabilities = {.has_cache = true}}), random_points(2, 5));
  EXPECT_TRUE(m_log.had_clearances);
  m_log.had_clearances = false;
  m_bones[1] = m_bones[0];
  contacts(*made({.capabilities = {.has_cache = true}, .cache_needs_closed_bones = true}), random_points(2, 5));
  EXPECT_TRUE(m_log.had_clearances);
}

TEST_F(PointBackendTest, OverAPrunedBoneNothingIsBuiltAndNothingIsAskedUntilANodeIsNear) {
  const auto reach_m = [](const Bone& /*bone*/) { return 0.0; };
  const std::vector<Vec3> apart = {Vec3(-0.5, 0, 0), Vec3(-2, 0, 0), Vec3(-3, 0, 0)};
  const std::vector<Vec3> near = {Vec3(-0.5, 0, 0), Vec3(-2, 0, 0), Vec3(1.5, 0, 0)};
  for (const bool has_cache : {false, true}) {
    m_expect_right_untouched = true;
    const auto backend = made({.capabilities = {.has_cache = has_cache}, .contact_reach_m = reach_m}, {true, true});
    EXPECT_TRUE(backend->structure_origin().is_from_file) << "what there is";
    const std::size_t bytes = backend->structure_bytes();
    m_log.queried = 0;
    EXPECT_EQ(contacts(*backend, apart).size(), 1U);
    EXPECT_EQ(m_log.queried, 3) << "of the left bone";
    m_log.queried = 0;
    m_log.resets = 0;
    EXPECT_EQ(contacts(*backend, near).size(), 2U);
    EXPECT_EQ(m_log.queried, has_cache ? 5 : 6) << "all of the right bone";
    EXPECT_EQ(m_log.resets, has_cache ? 1 : 0);
    m_expect_right_untouched = false;
    const auto whole = made({.capabilities = {.has_cache = has_cache}, .contact_reach_m = reach_m}, {true, true});
    EXPECT_LT(bytes, whole->structure_bytes());
    contacts(*whole, near);
    EXPECT_EQ(backend->structure_bytes(), whole->structure_bytes());
  }
}

TEST_F(PointBackendTest, TellsWhatItsStructuresTell) {
  const auto both = made({}, {true, true});
  EXPECT_TRUE(both->structure_origin().is_from_file);
  EXPECT_EQ(both->structure_origin().kept_build_ns, 14);
  EXPECT_EQ(both->structure_bytes(), 200U);
  EXPECT_EQ(both->step_m(1), 0.125);
  EXPECT_EQ(both->answer_bound(0).missed_depth_m, 0.5);
  EXPECT_EQ(m_shares, (std::vector{0.25, 0.75}));
  const auto one = made({}, {false, true});
  EXPECT_FALSE(one->structure_origin().is_from_file);
  EXPECT_FALSE(one->structure_origin().kept_build_ns) << "only one of them was loaded";
  ASSERT_EQ(one->structure_errors().size(), 1U);
  EXPECT_EQ(one->structure_errors()[0].bone, "right");
  EXPECT_FALSE(made({}, {false, false})->structure_origin().is_from_file);
}

}  // namespace
}  // namespace musclebench

#include "core/measure/stuck_nodes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "core/contact/response.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

constexpr double floor_m = 1e-6;

/// Answers as voxels of edge 0.01 do that hold a bone which fills z < 0: all of the layer above it, too.
class CoarseCells final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {.depth = false}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {0, cell_m}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }
  [[nodiscard]] double step_m(int /*bone*/) const override { return cell_m; }

 private:
  static constexpr double cell_m = 0.01;
  void do_build() override {}
  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    for (const int node : nodes) {
      if (poses()[0].apply_inverse(positions[static_cast<std::size_t>(node)]).z() < cell_m) {
        contacts.push_back({node, 0, 0, Vec3::Zero()});
      }
    }
  }
};

/// Nodes that the loop wants to move from `start` to `wanted`, while the bone goes along with `motion`.
int stuck_after_response(const std::vector<Vec3>& start, const std::vector<Vec3>& wanted, const RigidMotion& motion,
                         const std::vector<int>& really_inside = {}) {
  const std::vector<Bone> bones{bone_of({})};
  const TriangleMesh muscle{start, {}};
  CoarseCells backend;
  backend.build(bones, muscle, 1);
  LastDetection detection;
  detection.substep_start = start;
  detection.positions = wanted;
  detection.previous_bone_poses = {RigidMotion{}};
  detection.bone_poses = {motion};
  backend.update(detection.bone_poses, wanted);
  backend.detect(wanted, all_nodes(wanted.size()), detection.contacts);
  std::vector<Vec3> after = wanted;
  Response(ResponseKind::backtrack)
      .resolve(backend, {detection.substep_start, detection.previous_bone_poses, detection.bone_poses},
               detection.contacts, after);
  std::vector<Contact> truth;
  for (const int node : really_inside) truth.push_back({node, 0, 1e-3, Vec3::UnitZ()});
  return count_stuck_nodes(detection, truth, after, floor_m);
}

TEST(StuckNodes, ACellHoldsANodeThatIsFree) {
  EXPECT_EQ(stuck_after_response({{0, 0, 0.005}}, {{0.003, 0, 0.005}}, {}), 1);
}

TEST(StuckNodes, TheSameWhereTheBoneMoves) {
  const RigidMotion motion = some_motion();
  EXPECT_EQ(stuck_after_response({{0, 0, 0.005}}, {motion.apply({0.003, 0, 0.005})}, motion), 1);
  // The node that only goes along with its bone is held against nothing.
  EXPECT_EQ(stuck_after_response({{0, 0, 0.005}}, {motion.apply({0, 0, 0.005})}, motion), 0);
}

TEST(StuckNodes, AFreeNodeIsNot) { EXPECT_EQ(stuck_after_response({{0, 0, 0.02}}, {{0.003, 0, 0.02}}, {}), 0); }

TEST(StuckNodes, ANodeThatGetsOutIsNot) { EXPECT_EQ(stuck_after_response({{0, 0, 0.005}}, {{0, 0, 0.02}}, {}), 0); }

TEST(StuckNodes, ANodeThatIsReallyInsideIsNot) {
  EXPECT_EQ(stuck_after_response({{0, 0, 0.005}}, {{0.003, 0, -0.001}}, {}, {0}), 0);
}

TEST(StuckNodes, ANodeThatWantsNothingIsNot) {
  EXPECT_EQ(stuck_after_response({{0, 0, 0.005}}, {{0.5 * floor_m, 0, 0.005}}, {}), 0);
}

TEST(StuckNodes, CountsNodesNotContacts) {
  LastDetection detection;
  detection.substep_start = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  detection.positions = {Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitX()};
  detection.previous_bone_poses.resize(2);
  detection.bone_poses.resize(2);
  detection.contacts = {{0, 0}, {1, 0}, {2, 0}, {0, 1}};
  // Nine tenths are the limit: the first is stuck in two bones, the second just so, the third not.
  const std::vector<Vec3> after{Vec3::Zero(), 0.099 * Vec3::UnitX(), 0.101 * Vec3::UnitX()};
  EXPECT_EQ(count_stuck_nodes(detection, {}, after, floor_m), 2);
}

TEST(StuckNodes, BeforeAnyDetectionThereAreNone) { EXPECT_EQ(count_stuck_nodes({}, {}, {}, floor_m), 0); }

}  // namespace
}  // namespace musclebench

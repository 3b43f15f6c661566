#include "backends/fcl/surface_collider.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "backends/fcl/tests/intersecting_triangles.hpp"
#include "core/base/input_error.hpp"
#include "core/geometry/shapes.hpp"

namespace musclebench {
namespace {

constexpr int steps = 5;
constexpr BroadPhase managers[] = {BroadPhase::dynamic_aabb_tree, BroadPhase::sweep_and_prune};

Bone make_bone(const char* name, TriangleMesh mesh) {
  Bone bone;
  bone.name = name;
  bone.surface = {std::move(mesh), true, {}};
  return bone;
}

/// A sphere that bends, twists, grows and shrinks between a box and a ball that turn and wander, far from the origin.
struct Scene {
  std::vector<Bone> bones = {make_bone("box", make_box({0.03, 0.04, 0.05}, 5)),
                             make_bone("ball", make_sphere(0.04, 3))};
  TriangleMesh muscle = make_sphere(0.05, 3);

  static Vec3 place() { return {0.4, -0.3, 1.1}; }

  std::vector<RigidMotion> poses(int step) const {
    const double s = step;
    const auto box = RigidMotion::about_axis(Vec3(1, 2, -1).normalized(), Vec3(0.01, 0, 0.02), 0.31 * s + 0.2);
    const auto ball = RigidMotion::about_axis(Vec3(-2, 1, 3).normalized(), Vec3(0, 0.02, 0), -0.47 * s);
    const RigidMotion box_place{Mat3::Identity(), place() + Vec3(0.06 - 0.004 * s, 0.003 * s, 0.01)};
    const RigidMotion ball_place{Mat3::Identity(), place() + Vec3(-0.07, 0.002, 0.0015 * s)};
    return {box_place * box, ball_place * ball};
  }

  std::vector<Vec3> positions(int step) const {
    const double s = step;
    std::vector<Vec3> moved;
    for (const Vec3& rest : muscle.vertices) {
      // Grows at both ends, then at one, then shrinks: what a broad phase must follow.
      const Vec3 scaled = rest.cwiseProduct(Vec3(1 + 0.15 * std::sin(s), 1 + 0.05 * s, 1 - 0.04 * s));
      const double twist = 12 * rest.z() * std::sin(0.9 * s);
      const Mat3 turn = Eigen::AngleAxisd(twist + 0.3 * s, Vec3::UnitZ()).toRotationMatrix();
      const double ripple = 0.002 * std::sin(150 * rest.x() + s) * std::cos(130 * rest.y() - s);
      moved.push_back(place() + turn * scaled + ripple * rest.normalized() + Vec3(0, 0.001 * s * s, 0));
    }
    return moved;
  }
};

struct Truth {
  std::vector<std::array<PairSet, 2>> of_step;
};

const Truth& truth() {
  static const Truth pairs = [] {
    const Scene scene;
    Truth all;
    for (int step = 0; step < steps; ++step) {
      const auto poses = scene.poses(step);
      const auto positions = scene.positions(step);
      all.of_step.emplace_back();
      for (std::size_t bone = 0; bone < 2; ++bone) {
        all.of_step.back()[bone] =
            intersecting_pairs(positions, scene.muscle.triangles, scene.bones[bone].surface.mesh, poses[bone]);
      }
    }
    return all;
  }();
  return pairs;
}

PairSet as_set(const std::vector<TrianglePair>& pairs) {
  PairSet set;
  for (const TrianglePair& pair : pairs) {
    set.emplace(pair.muscle_triangle, pair.bone_triangle);
  }
  return set;
}

class EveryUpdate : public testing::TestWithParam<std::tuple<std::string, TreeUpdate, VertexUpdate>> {
 protected:
  static ColliderOptions options(BroadPhase broad_phase) {
    const auto& [volume, tree, vertices] = GetParam();
    return {volume, broad_phase, tree, vertices};
  }
  static bool is_refused() {
    return std::get<std::string>(GetParam()) == "RSS" && std::get<TreeUpdate>(GetParam()) == TreeUpdate::refit;
  }
  static std::unique_ptr<SurfaceCollider> make(const Scene& scene, BroadPhase broad_phase) {
    return make_surface_collider(options(broad_phase), scene.bones, scene.muscle.vertices, scene.muscle.triangles);
  }
};

TEST_P(EveryUpdate, FindsThePairsOfBruteForce) {
  const Scene scene;
  if (is_refused()) {
    EXPECT_THROW(make(scene, managers[0]), InputError);
    return;
  }
  for (const BroadPhase manager : managers) {
    SCOPED_TRACE(manager == managers[0] ? "tree" : "sweep");
    const auto collider = make(scene, manager);
    std::vector<std::vector<TrianglePair>> pairs;
    for (int step = 0; step < steps; ++step) {
      collider->update(scene.poses(step), scene.positions(step));
      collider->collide(pairs);
      ASSERT_EQ(pairs.size(), 2U);
      for (std::size_t bone = 0; bone < 2; ++bone) {
        const PairSet& expected = truth().of_step[static_cast<std::size_t>(step)][bone];
        EXPECT_GT(expected.size(), 50U) << "the scene must collide, step " << step << " bone " << bone;
        EXPECT_EQ(as_set(pairs[bone]), expected) << "step " << step << " bone " << bone;
        EXPECT_EQ(pairs[bone].size(), expected.size()) << "a pair came twice, step " << step << " bone " << bone;
      }
    }
  }
}

TEST_P(EveryUpdate, SurvivesTrianglesThatCollapse) {
  if (is_refused()) {
    return;
  }
  const Scene scene;
  const auto collider = make(scene, BroadPhase::dynamic_aabb_tree);
  std::vector<std::vector<TrianglePair>> pairs;
  for (int step = 0; step < 2; ++step) {
    const auto poses = scene.poses(step);
    std::vector<Vec3> positions = scene.positions(step);
    std::set<int> flat;
    for (std::size_t t = 0; t < scene.muscle.triangles.size(); t += 40) {
      const Triangle& corners = scene.muscle.triangles[t];
      positions[static_cast<std::size_t>(corners[1])] = positions[static_cast<std::size_t>(corners[0])];
    }
    for (std::size_t t = 0; t < scene.muscle.triangles.size(); ++t) {
      const Triangle& corners = scene.muscle.triangles[t];
      const Vec3& a = positions[static_cast<std::size_t>(corners[0])];
      const Vec3& b = positions[static_cast<std::size_t>(corners[1])];
      const Vec3& c = positions[static_cast<std::size_t>(corners[2])];
      if ((b - a).cross(c - a).squaredNorm() == 0) {
        flat.insert(static_cast<int>(t));
      }
    }
    EXPECT_GT(flat.size(), 20U);
    collider->update(poses, positions);
    collider->collide(pairs);
    for (std::size_t bone = 0; bone < 2; ++bone) {
      PairSet found;
      for (const TrianglePair& pair : pairs[bone]) {
        if (!flat.contains(pair.muscle_triangle)) {
          found.emplace(pair.muscle_triangle, pair.bone_triangle);
        }
      }
      PairSet expected =
          intersecting_pairs(positions, scene.muscle.triangles, scene.bones[bone].surface.mesh, poses[bone]);
      std::erase_if(expected, [&](const auto& pair) { return flat.contains(pair.first); });
      EXPECT_EQ(found, expected) << "step " << step << " bone " << bone;
    }
  }
}

std::string name_of(const testing::TestParamInfo<EveryUpdate::ParamType>& info) {
  const auto& [volume, tree, vertices] = info.param;
  const std::string trees[] = {"refit", "topdown", "rebuild"};
  return volume + "_" + trees[static_cast<int>(tree)] + (vertices == VertexUpdate::replace ? "_replace" : "_update");
}

INSTANTIATE_TEST_SUITE_P(AllOptions, EveryUpdate,
                         testing::Combine(testing::ValuesIn(bounding_volumes()),
                                          testing::Values(TreeUpdate::refit, TreeUpdate::refit_top_down,
                                                          TreeUpdate::rebuild),
                                          testing::Values(VertexUpdate::replace, VertexUpdate::update)),
                         name_of);

class EveryManager : public testing::TestWithParam<BroadPhase> {};

TEST_P(EveryManager, FollowsABoxThatGrowsAtOneEndOrBoth) {
  const std::vector<Bone> bones = {make_bone("ball", make_sphere(0.04, 2))};
  const TriangleMesh muscle = make_sphere(0.05, 2);
  ColliderOptions options;
  options.broad_phase = GetParam();
  const auto collider = make_surface_collider(options, bones, muscle.vertices, muscle.triangles);
  const std::vector<RigidMotion> apart = {{Mat3::Identity(), Vec3(0.1, 0.001, 0.002)}};
  std::vector<std::vector<TrianglePair>> pairs;
  const auto pairs_after_stretch = [&](double at_lower_end, double at_upper_end) {
    std::vector<Vec3> positions = muscle.vertices;
    for (Vec3& position : positions) {
      position.x() *= position.x() < 0 ? at_lower_end : at_upper_end;
    }
    collider->update(apart, positions);
    collider->collide(pairs);
    EXPECT_EQ(as_set(pairs[0]), intersecting_pairs(positions, muscle.triangles, bones[0].surface.mesh, apart[0]));
    return pairs[0].size();
  };
  EXPECT_EQ(pairs_after_stretch(1, 1), 0U);
  EXPECT_GT(pairs_after_stretch(1, 1.4), 0U);  // upper end alone
  EXPECT_EQ(pairs_after_stretch(1, 1), 0U);
  EXPECT_GT(pairs_after_stretch(1.5, 1.5), 0U);  // both ends, several times
  EXPECT_GT(pairs_after_stretch(1.6, 1.6), 0U);
  EXPECT_EQ(pairs_after_stretch(0.9, 0.9), 0U);
  EXPECT_GT(pairs_after_stretch(0.9, 1.7), 0U);
}

INSTANTIATE_TEST_SUITE_P(Both, EveryManager, testing::ValuesIn(managers));

TEST(SurfaceCollider, UnknownVolumeNamesTheNearest) {
  const Scene scene;
  ColliderOptions options;
  options.bounding_volume = "OBBRS";
  try {
    make_surface_collider(options, scene.bones, scene.muscle.vertices, scene.muscle.triangles);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'OBBRSS'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace musclebench

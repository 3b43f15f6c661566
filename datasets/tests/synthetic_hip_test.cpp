#include "datasets/synthetic_hip.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh_repair/check_mesh.hpp"
#include "datasets/synthetic/make_synthetic_hip.hpp"
#include "datasets/synthetic/synthetic_bones.hpp"
#include "datasets/tests/self_intersection.hpp"

namespace musclebench {

namespace {

struct Expected {
  std::string name;
  int vertices;
  double volume_ml;  ///< of the anatomical muscle
};

const std::vector<Expected>& muscles() {
  static const std::vector<Expected> all = {{"adductor_brevis", 502, 55},
                                            {"gluteus_maximus", 9878, 747},
                                            {"gluteus_medius", 5313, 271},
                                            {"iliacus", 6931, 102}};
  return all;
}

const TriangleMesh& made(const std::string& name) {
  static std::map<std::string, TriangleMesh> cache;
  auto [entry, fresh] = cache.try_emplace(name);
  if (fresh) {
    entry->second = synthetic_hip_mesh(name);
  }
  return entry->second;
}

const TriangleBvh& tree(const std::string& bone) {
  static const TriangleBvh hip_bone(made("hip_bone"));
  static const TriangleBvh femur(made("femur"));
  return bone == "femur" ? femur : hip_bone;
}

int euler_characteristic(const TriangleMesh& mesh) {
  return static_cast<int>(mesh.vertices.size()) - static_cast<int>(mesh.triangles.size()) / 2;
}

}  // namespace

TEST(SyntheticHip, EverySurfaceIsClosedManifoldOutwardAndWellShaped) {
  for (const std::string& name : synthetic_hip_names()) {
    SCOPED_TRACE(name);
    const MeshReport report = check_mesh(made(name));
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.boundary_edges, 0);
    EXPECT_EQ(report.non_manifold_edges, 0);
    EXPECT_EQ(report.inconsistent_edges, 0);
    EXPECT_EQ(report.flipped_triangles, 0);
    EXPECT_EQ(report.zero_area_triangles, 0);
    EXPECT_EQ(report.duplicate_triangles, 0);
    EXPECT_EQ(report.duplicate_vertices, 0);
    EXPECT_EQ(report.unreferenced_vertices, 0);
    EXPECT_GT(report.volume_m3, 0);
    EXPECT_LT(report.worst_aspect, 6);
    EXPECT_EQ(count_self_intersections(made(name)), 0);
  }
}

TEST(SyntheticHip, SelfIntersectionsAreSeen) {
  TriangleMesh twisted = made("adductor_brevis");
  twisted.vertices[100] = twisted.vertices[400];
  EXPECT_GT(count_self_intersections(twisted), 0);
}

TEST(SyntheticHip, TopologyIsThatOfTheAnatomy) {
  EXPECT_EQ(euler_characteristic(made("hip_bone")), 0) << "one hole: the obturator foramen";
  EXPECT_EQ(euler_characteristic(made("femur")), 2);
  for (const Expected& muscle : muscles()) {
    EXPECT_EQ(euler_characteristic(made(muscle.name)), 2) << muscle.name;
  }
}

TEST(SyntheticHip, MusclesHaveTheVertexCountsAndVolumesOfThePapersMuscles) {
  for (const Expected& muscle : muscles()) {
    SCOPED_TRACE(muscle.name);
    EXPECT_EQ(made(muscle.name).vertices.size(), static_cast<std::size_t>(muscle.vertices));
    EXPECT_NEAR(1e6 * check_mesh(made(muscle.name)).volume_m3, muscle.volume_ml, 0.25 * muscle.volume_ml);
  }
}

TEST(SyntheticHip, TheSameBitsTwice) {
  for (const std::string name : {"femur", "adductor_brevis", "iliacus"}) {
    const TriangleMesh again = make_synthetic_hip_mesh(name);
    EXPECT_TRUE(again.vertices == made(name).vertices) << name;
    EXPECT_TRUE(again.triangles == made(name).triangles) << name;
  }
}

TEST(SyntheticHip, AnUnknownNameIsRefusedWithTheNearestOne) {
  try {
    synthetic_hip_mesh("ilacus");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'iliacus'"), std::string::npos) << error.what();
  }
}

TEST(SyntheticHip, MusclesKeepOffBothBonesAtRest) {
  for (const Expected& muscle : muscles()) {
    for (const std::string bone : {"hip_bone", "femur"}) {
      double smallest = 1;
      int inside = 0;
      for (const Vec3& vertex : made(muscle.name).vertices) {
        smallest = std::min(smallest, tree(bone).closest_point(vertex)->distance_m);
        inside += tree(bone).winding_number(vertex) > 0.5 ? 1 : 0;
      }
      EXPECT_GE(smallest, 0.0002) << muscle.name << " and " << bone;
      EXPECT_EQ(inside, 0) << muscle.name << " and " << bone;
    }
  }
}

TEST(SyntheticHip, MusclesLieAgainstTheirBonesAtBothEnds) {
  for (const Expected& muscle : muscles()) {
    for (const std::string bone : {"hip_bone", "femur"}) {
      const auto& vertices = made(muscle.name).vertices;
      const auto near = std::count_if(vertices.begin(), vertices.end(), [&](const Vec3& vertex) {
        return tree(bone).closest_point(vertex, 0.003).has_value();
      });
      EXPECT_GE(near, 15) << muscle.name << " and " << bone;
    }
  }
}

TEST(SyntheticHip, TheIliacusWrapsOverTheFemoralHead) {
  const auto& vertices = made("iliacus").vertices;
  const auto on_head = std::count_if(vertices.begin(), vertices.end(), [](const Vec3& vertex) {
    return vertex.norm() < femoral_head_radius_m + 0.003 && vertex.y() < 0;
  });
  EXPECT_GE(on_head, 50);
}

TEST(SyntheticHip, TheFemurNeverTouchesTheHipBoneWhenItFlexes) {
  for (int degrees = 0; degrees <= 90; degrees += 5) {
    const RigidMotion motion = RigidMotion::about_axis(Vec3(-1, 0, 0), Vec3::Zero(), degrees * std::numbers::pi / 180);
    double gap = 1;
    int inside = 0;
    for (const Vec3& vertex : made("femur").vertices) {
      const Vec3 moved = motion.apply(vertex);
      if (const auto closest = tree("hip_bone").closest_point(moved, 0.004)) {
        gap = std::min(gap, closest->distance_m);
        inside += tree("hip_bone").winding_number(moved) > 0.5 ? 1 : 0;
      }
    }
    for (const Vec3& vertex : made("hip_bone").vertices) {
      const auto closest = tree("femur").closest_point(motion.apply_inverse(vertex), 0.004);
      gap = closest ? std::min(gap, closest->distance_m) : gap;
    }
    EXPECT_GE(gap, 0.0005) << degrees << " degrees";
    EXPECT_LT(gap, 0.0025) << degrees << " degrees: the head has left its socket";
    EXPECT_EQ(inside, 0) << degrees << " degrees";
  }
}

TEST(SyntheticHip, FlexionMovesTheDistalFemurForward) {
  const RigidMotion motion = RigidMotion::about_axis(Vec3(-1, 0, 0), Vec3::Zero(), std::numbers::pi / 2);
  const auto& vertices = made("femur").vertices;
  const auto lowest =
      std::min_element(vertices.begin(), vertices.end(), [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
  EXPECT_LT(lowest->z(), -0.38);
  EXPECT_LT(motion.apply(*lowest).y(), -0.38);
}

}  // namespace musclebench

#include "bench/cases/forces/bone_pressure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

constexpr double pressure_pa = 1000;

/// A square sheet of 40 x 40 mm at this height that faces down, and a uniform pressure that pushes it up.
struct Sheet {
  std::vector<Vec3> positions_m;
  std::vector<Triangle> triangles;
  std::vector<Vec3> pushes_n;
  double whole_n = pressure_pa * 1.6e-3;

  Sheet(int cells, double height_m) {
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j) {
        positions_m.emplace_back(0.04 * i / cells - 0.02, 0.04 * j / cells - 0.02, height_m);
      }
    }
    pushes_n.assign(positions_m.size(), Vec3::Zero());
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        const int a = i * (cells + 1) + j;
        add({a, a + cells + 2, a + cells + 1});
        add({a, a + 1, a + cells + 2});
      }
    }
  }

  void add(const Triangle& triangle) {
    triangles.push_back(triangle);
    const auto at = [&](int k) { return positions_m[static_cast<std::size_t>(triangle[static_cast<std::size_t>(k)])]; };
    const double area_m2 = (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
    for (const int node : triangle) pushes_n[static_cast<std::size_t>(node)].z() += pressure_pa * area_m2 / 3;
  }
};

Vec3 sum_of(const std::vector<Vec3>& forces_n) {
  Vec3 sum_n = Vec3::Zero();
  for (const Vec3& force_n : forces_n) sum_n += force_n;
  return sum_n;
}

VertexLoads pressed_by(const Bone& bone, const Sheet& sheet) {
  BonePressure pressure(bone.surface.mesh);
  pressure.add(sheet.triangles, sheet.positions_m, sheet.pushes_n);
  return pressure.loads();
}

/// A plate of 80 x 80 x 4 mm whose upper side is at 0.
Bone plate(int cells) { return bone_of(moved(make_box(Vec3(0.04, 0.04, 0.002), cells), Vec3(0, 0, -0.002))); }

/// A thin fold: what faces the push counts, and the other side of the fold does not.
TEST(FacingAreas, LeaveOutWhatFacesAway) {
  const std::vector<Vec3> at{{0, 0, 0}, {0.03, 0, 0}, {0, 0.02, 0}, {0, 0.01, 0}};
  const std::vector<Triangle> triangles{{0, 2, 1}, {0, 1, 3}};
  const FacingAreas areas(at.size(), triangles);
  EXPECT_DOUBLE_EQ(areas.about_m2(0, Vec3(0, 0, 7), at), 1e-4);
  EXPECT_DOUBLE_EQ(areas.about_m2(0, Vec3(0, 0, -7), at), 0.5e-4);
  EXPECT_DOUBLE_EQ(areas.about_m2(0, Vec3(7, 0, 0), at), 0.25 * 1.5e-4) << "a quarter, whatever it looks like";
}

/// A bone that is finer than the muscle has no peaks at its nodes, and one that is coarser no holes.
TEST(BonePressure, OfAUniformPressureIsUniform) {
  for (const int cells_of_bone : {20, 33, 97}) {
    for (const int cells_of_sheet : {7, 24, 61}) {
      const Bone bone = plate(cells_of_bone);
      const VertexLoads loads = pressed_by(bone, Sheet(cells_of_sheet, 1e-4));
      int inside = 0;
      for (std::size_t i = 0; i < loads.pressures_pa.size(); ++i) {
        const Vec3& at = bone.surface.mesh.vertices[i];
        const double outside_m = std::max(std::abs(at.x()), std::abs(at.y())) - 0.02;
        const double bone_edge_m = 0.08 / cells_of_bone * std::numbers::sqrt2;
        const double blur_m = bone_edge_m + 0.04 / cells_of_sheet;
        if (at.z() < -1e-6 || outside_m > blur_m) {
          EXPECT_EQ(loads.pressures_pa[i], 0) << at.transpose();
        }
        if (at.z() < -1e-6 || outside_m > -blur_m) continue;
        EXPECT_NEAR(loads.pressures_pa[i], pressure_pa, 0.06 * pressure_pa) << cells_of_bone << " " << cells_of_sheet;
        ++inside;
      }
      EXPECT_GT(inside, 10);
      EXPECT_NEAR(sum_of(loads.forces_n).z(), -1.6, 1e-9) << "all of the force is on the bone";
    }
  }
}

/// Two triangles a side: the bone tells its mean.
TEST(BonePressure, OfACoarseBoneIsAMean) {
  const VertexLoads loads = pressed_by(plate(1), Sheet(20, 1e-4));
  EXPECT_NEAR(sum_of(loads.forces_n).z(), -1.6, 1e-9);
  for (const double here_pa : loads.pressures_pa) EXPECT_LT(here_pa, pressure_pa);
}

/// The tip is finer than any triangle of the sheet.
TEST(BonePressure, OfANeedleKeepsTheForce) {
  Sheet sheet(10, 0);
  sheet.pushes_n.assign(sheet.pushes_n.size(), Vec3::Zero());
  sheet.pushes_n[60] = Vec3(0, 0, 2);
  const Bone needle = bone_of(moved(make_box(Vec3(1e-6, 1e-6, 0.02), 1), Vec3(0, 0, -0.02)));
  const VertexLoads loads = pressed_by(needle, sheet);
  EXPECT_NEAR(sum_of(loads.forces_n).z(), -2, 1e-12);
  for (const double here_pa : loads.pressures_pa) EXPECT_TRUE(std::isfinite(here_pa));
}

/// An open surface may be wound either way: then no bone faces it.
TEST(BonePressure, OfASheetThatFacesAwayKeepsTheForce) {
  Sheet sheet(10, 1e-4);
  for (Triangle& triangle : sheet.triangles) std::swap(triangle[1], triangle[2]);
  EXPECT_NEAR(sum_of(pressed_by(plate(40), sheet).forces_n).z(), -1.6, 1e-9);
}

/// A contact margin that is wider than the edges of the muscle and of the bone.
TEST(BonePressure, ReachesAcrossAMargin) {
  const Bone bone = plate(97);
  const VertexLoads loads = pressed_by(bone, Sheet(10, 8e-3));
  for (std::size_t i = 0; i < loads.pressures_pa.size(); ++i) {
    const Vec3& at = bone.surface.mesh.vertices[i];
    if (at.z() < -1e-6 || std::max(std::abs(at.x()), std::abs(at.y())) > 0.015) continue;
    EXPECT_NEAR(loads.pressures_pa[i], pressure_pa, 0.05 * pressure_pa);
  }
}

/// In the formula's terms: what presses evenly on a ball from above presses by its shadow.
TEST(BonePressure, OfABallIsByItsOwnArea) {
  const Bone ball = bone_of(moved(make_sphere(0.05, 5), Vec3(0, 0, -0.05)));
  Sheet sheet(20, 0);
  for (std::size_t i = 0; i < sheet.positions_m.size(); ++i) {
    Vec3& at = sheet.positions_m[i];
    at.z() = std::sqrt(0.05 * 0.05 - at.x() * at.x() - at.y() * at.y()) - 0.05;
    // Along the normal, so that its part along z stays that of the pressure on the shadow.
    const Vec3 normal = (at - Vec3(0, 0, -0.05)).normalized();
    sheet.pushes_n[i] = sheet.pushes_n[i].z() / normal.z() * normal;
  }
  const VertexLoads loads = pressed_by(ball, sheet);
  int inside = 0;
  for (std::size_t i = 0; i < loads.pressures_pa.size(); ++i) {
    const Vec3& at = ball.surface.mesh.vertices[i];
    if (at.z() < -0.02 || std::max(std::abs(at.x()), std::abs(at.y())) > 0.014) continue;
    EXPECT_NEAR(loads.pressures_pa[i], pressure_pa, 0.06 * pressure_pa) << at.transpose();
    ++inside;
  }
  EXPECT_GT(inside, 30);
}

TEST(BonePressure, OfTwoMusclesAddsUp) {
  const Bone bone = plate(20);
  const Sheet sheet(20, 1e-4);
  BonePressure twice(bone.surface.mesh);
  twice.add(sheet.triangles, sheet.positions_m, sheet.pushes_n);
  const VertexLoads once = twice.loads();
  twice.add(sheet.triangles, sheet.positions_m, sheet.pushes_n);
  for (std::size_t i = 0; i < once.pressures_pa.size(); ++i) {
    EXPECT_DOUBLE_EQ(twice.loads().pressures_pa[i], 2 * once.pressures_pa[i]);
  }
}

/// All of its nodes are at one place.
TEST(BonePressure, OfACollapsedSheetKeepsTheForce) {
  Sheet sheet(4, 1e-4);
  for (Vec3& node : sheet.positions_m) node = Vec3(0.001, 0.002, 1e-4);
  EXPECT_NEAR(sum_of(pressed_by(plate(40), sheet).forces_n).z(), -1.6, 1e-9);
}

TEST(BonePressure, OfWhatIsNoNumberIsNone) {
  Sheet sheet(5, 0);
  sheet.positions_m[7].x() = std::nan("");
  for (const double here_pa : pressed_by(plate(5), sheet).pressures_pa) EXPECT_EQ(here_pa, 0);
}

}  // namespace
}  // namespace musclebench

// A field over a part of its domain's cells, against the whole field.
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/grid/tests/field_samples.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// At points of the whole domain: what a part answers is what the whole field answers, and it answers in all of `box`.
void expect_part_of(const CubicField& whole, const CubicField& part, const Eigen::AlignedBox3d& box) {
  std::vector<Vec3> points = points_over(whole.shape(), 20000);
  for (int n = 0; n < 2000; ++n) {  // on borders of cells
    const GridShape& shape = whole.shape();
    points[static_cast<std::size_t>(n)] =
        shape.vertex(n % (shape.cells[0] + 1), n / 7 % (shape.cells[1] + 1), n / 61 % (shape.cells[2] + 1));
  }
  int answered = 0;
  for (const Vec3& point : points) {
    const std::optional<FieldSample> own = part.sample(point);
    const std::optional<CellPosition> at = part.locate(point);
    EXPECT_TRUE(at || !box.contains(point) || !whole.locate(point)) << point.transpose();
    const std::optional<FieldSample> truth = whole.sample(point);
    if (!at) {
      EXPECT_FALSE(own);
      continue;
    }
    ++answered;
    ASSERT_TRUE(own && truth);
    EXPECT_EQ(own->value_m, truth->value_m);
    EXPECT_EQ(own->gradient, truth->gradient);
    const CellPosition in_whole = whole.locate(point).value();
    EXPECT_EQ(part.may_be_negative(part.shape().cell(at->i, at->j, at->k)),
              whole.may_be_negative(whole.shape().cell(in_whole.i, in_whole.j, in_whole.k)));
  }
  EXPECT_GT(answered, 200);
}

/// A capsule that touches the sides of its box at its ends only.
RepairedMesh leaning_capsule() {
  TriangleMesh mesh = make_capsule(0.3, 2, 16);
  const RigidMotion lean = RigidMotion::about_axis(Vec3(1, 0.7, 0).normalized(), Vec3::Zero(), 0.6);
  for (Vec3& vertex : mesh.vertices) vertex = lean.apply(vertex);
  return {std::move(mesh), true, {}};
}

TEST(BuildField, APartHoldsWhatTheWholeHoldsThere) {
  const RepairedMesh bone = leaning_capsule();
  const SignedSurface surface(bone);
  const GridShape shape = grid_over(bone.mesh, {.cells = 21}, "bone");
  const Vec3 far = Vec3::Constant(10);
  const std::vector<Eigen::AlignedBox3d> boxes = {
      {Vec3(-10, -10, -0.3), Vec3(10, 10, 0.2)}, {Vec3(0.1, -0.2, -10), far}, {-far, Vec3(-0.1, 0.05, -0.4)}};
  const CubicField whole = build_field(surface, shape, 1);
  for (const Eigen::AlignedBox3d& box : boxes) {
    const CubicField part = build_field(surface, shape.part(box), 2);
    EXPECT_LT(part.bytes(), 0.7 * static_cast<double>(whole.bytes()));
    expect_part_of(whole, part, box);
  }
}

TEST(BuildField, WhereTheBoneTouchesTheBorderAPartHoldsWhatTheWholeHoldsThere) {
  const RepairedMesh bone = {make_sphere(1, 3), true, {}};
  const SignedSurface surface(bone);
  const GridShape shape = grid_over(bone.mesh, {.cells = 12}, "bone");
  const CubicField whole = build_field(surface, shape, 1);
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double up_to_z : {0.0, -0.7}) {
    const Eigen::AlignedBox3d box(Vec3::Constant(-infinite), Vec3(infinite, infinite, up_to_z));
    const CubicField part = build_field(surface, shape.part(box), 1);
    EXPECT_TRUE(part.shape().is_part());
    expect_part_of(whole, part, box);
  }
  EXPECT_EQ(shape.part(unbounded_box()), shape);
  EXPECT_EQ(shape.part({Vec3::Constant(5), Vec3::Constant(6)}).cell_count(), 1U);
  EXPECT_EQ(shape.part({Vec3::Constant(5), Vec3::Constant(6)}).whole(), shape);
}

TEST(BuildField, APartThatEndsBesideATouchedBorderHoldsWhatTheWholeHoldsThere) {
  TriangleMesh octahedron{{{1.1, 0.03, 0}, {-1, 0, 0.02}, {0, 1.2, 0.07}, {0.05, -1, 0}, {0, 0.02, 1.3}, {0.04, 0, -1}},
                          {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  const RepairedMesh bone = {std::move(octahedron), true, {}};
  const SignedSurface surface(bone);
  int parts = 0;
  for (const int cells : {10, 11, 13}) {
    const GridShape shape = grid_over(bone.mesh, {.cells = cells}, "bone");
    const CubicField whole = build_field(surface, shape, 1);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      for (double cut = -0.9; cut < 0.95; cut += 0.13) {
        Eigen::AlignedBox3d below = unbounded_box();
        below.max()[axis] = cut;
        Eigen::AlignedBox3d above = unbounded_box();
        above.min()[axis] = cut;
        for (const Eigen::AlignedBox3d& box : {below, above}) {
          const CubicField part = build_field(surface, shape.part(box), 1);
          if (!part.shape().is_part()) continue;
          ++parts;
          expect_part_of(whole, part, box);
        }
      }
    }
  }
  EXPECT_GT(parts, 25);
}

TEST(BuildField, ASearchOfAPartSaysWhereItLeavesOutAPoint) {
  const RepairedMesh bone = leaning_capsule();
  const SignedSurface surface(bone);
  const GridShape whole = grid_over(bone.mesh, {.cells = 21}, "bone");
  const CubicField part = build_field(surface, whole.part({Vec3::Constant(-10), Vec3(10, 10, 0)}), 1);
  ASSERT_TRUE(part.shape().is_part());
  const CellMap map(part.shape(), RigidMotion());
  const auto leaves_out = [&](const std::vector<Vec3>& points, CubicField::Wanted wanted) {
    std::vector<int> nodes(points.size());
    std::iota(nodes.begin(), nodes.end(), 0);
    FieldBlock block;
    part.sample(map, points, nodes, 0, wanted, block);
    return block.found_left_out;
  };
  for (const CubicField::Wanted wanted : {CubicField::Wanted::known, CubicField::Wanted::may_be_inside}) {
    const double lost = std::nan("");
    EXPECT_FALSE(leaves_out({Vec3(0, 0, -0.1), Vec3(0, 0, 3), Vec3(3, 0, 0.5), Vec3(lost, 0, 0.5)}, wanted));
    EXPECT_TRUE(leaves_out({Vec3(0, 0, -0.1), Vec3(0, 0, 3), Vec3(3, 0, 0.5), Vec3(0, 0, 0.5)}, wanted));
  }
}

}  // namespace
}  // namespace musclebench

#include "backends/sdf/files/foreign_field.hpp"

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/grid/tests/field_samples.hpp"
#include "core/base/input_error.hpp"
#include "core/base/random_numbers.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/lhdl_data.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/signed_distance/manifold_features.hpp"

namespace musclebench {
namespace {

std::string refusal(const CubicField& field, const TriangleMesh& mesh, const SignedSurface& surface) {
  try {
    require_field_of(field, mesh, surface, "femur", "fields/femur.cdf");
  } catch (const InputError& error) {
    std::string line = error.what();
    EXPECT_EQ(line.find("fields/femur.cdf: "), 0U) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    EXPECT_NE(line.find("leave out `discregrid`"), std::string::npos) << line;
    return line;
  }
  return "accepted";
}

std::string refusal(const CubicField& field, const RepairedMesh& bone) {
  return refusal(field, bone.mesh, SignedSurface(bone));
}

void expect_refusal(const std::string& words, const CubicField& field, const RepairedMesh& bone) {
  const std::string line = refusal(field, bone);
  EXPECT_NE(line.find(words), std::string::npos) << line;
}

RepairedMesh box_of(const Vec3& half_edges) { return {make_box(half_edges, 3), true, {}}; }

CubicField field_of(const RepairedMesh& bone, int cells) {
  return build_field(SignedSurface(bone), grid_over(bone.mesh, {.cells = cells}, "bone"), 2);
}

/// A box, on which a sheet of no thickness stands.
RepairedMesh box_with_fin() {
  TriangleMesh mesh = make_box({1, 1, 1}, 3);
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{0.9, -0.4, 0.1}, {0.9, 0.4, 0.1}, {2, 0, 0.1}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first + 1, first, first + 2});
  return {std::move(mesh), false, {}};
}

/// The sum of a corner's face normals, weighted by their angles as Discregrid computes these: obtuse ones are folded.
std::vector<Vec3> folded_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  const auto vertex = [&](int index) { return mesh.vertices[static_cast<std::size_t>(index)]; };
  for (const Triangle& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 one = (vertex(triangle[(i + 1) % 3]) - vertex(triangle[i])).normalized();
      const Vec3 other = (vertex(triangle[(i + 2) % 3]) - vertex(triangle[i])).normalized();
      normals[static_cast<std::size_t>(triangle[i])] +=
          std::acos(std::abs(one.dot(other))) * one.cross(other).normalized();
    }
  }
  return normals;
}

struct WrongSigns {
  int without_normal = 0;
  int by_weights = 0;
};

/// Discregrid's signs: inside where an edge or corner has no pseudo-normal, and by folded angles next to corners.
WrongSigns get_signs_wrong(CubicField& field, const TriangleMesh& mesh, const SignedSurface& surface) {
  const ManifoldFeatures clean(mesh, surface.tree());
  const std::vector<Vec3> folded = folded_normals(mesh);
  WrongSigns wrong;
  for_each_node(field.shape(), [&](std::size_t offset, const Vec3& position) {
    const SignedPoint at = surface.locate(position);
    const auto& [closest, inside] = at;
    bool says_inside = inside;
    if (!clean.holds(closest.triangle, closest.feature)) {
      says_inside = true;
      wrong.without_normal += says_inside != inside ? 1 : 0;
    } else if (closest.feature >= Feature::corner_0) {
      const auto corner = static_cast<std::size_t>(closest.feature) - static_cast<std::size_t>(Feature::corner_0);
      const int vertex = mesh.triangles[static_cast<std::size_t>(closest.triangle)][corner];
      says_inside = (position - closest.point).dot(folded[static_cast<std::size_t>(vertex)]) < 0;
      wrong.by_weights += says_inside != inside ? 1 : 0;
    }
    if (says_inside != inside) {
      field.store(offset, says_inside ? -closest.distance_m : closest.distance_m);
    }
  });
  return wrong;
}

TEST(ForeignField, IsAcceptedAsWeWouldBuildIt) {
  TriangleMesh open = make_sphere(0.1, 4);
  open.triangles.resize(open.triangles.size() - 8);
  for (const RepairedMesh& bone :
       {box_of({0.05, 0.03, 0.02}), box_with_fin(), RepairedMesh{make_capsule(0.02, 0.2, 24), true, {}},
        RepairedMesh{open, false, {}}}) {
    for (const int cells : {1, 2, 7, 24}) {
      EXPECT_EQ(refusal(field_of(bone, cells), bone), "accepted") << cells;
    }
  }
}

TEST(ForeignField, IsAcceptedWithSignsThatAreWrongWhereThereIsNoPseudoNormal) {
  const RepairedMesh bone = box_with_fin();
  CubicField field = field_of(bone, 24);
  EXPECT_GT(get_signs_wrong(field, bone.mesh, SignedSurface(bone)).without_normal, 10);
  EXPECT_EQ(refusal(field, bone), "accepted");
}

TEST(ForeignField, IsAcceptedWithSignsThatAreWrongByTheWeightsOfNormals) {
  RandomNumbers random(3);
  int wrong = 0;
  for (int shape = 0; shape < 30; ++shape) {
    TriangleMesh mesh;
    for (int vertex = 0; vertex < 4; ++vertex) {
      const double x = random.share();
      const double y = random.share();
      mesh.vertices.emplace_back(x, y, random.share());
    }
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    const RepairedMesh bone = repair_mesh(mesh, "tetrahedron");
    CubicField field = field_of(bone, 10);
    const WrongSigns signs = get_signs_wrong(field, bone.mesh, SignedSurface(bone));
    wrong += signs.by_weights;
    EXPECT_EQ(refusal(field, bone), "accepted") << shape;
  }
  EXPECT_GT(wrong, 10);
}

TEST(ForeignField, OfAMeshWithATurnedTriangleIsRefused) {
  const RepairedMesh bone = box_of({0.03, 0.03, 0.03});
  const SignedSurface surface(bone);
  CubicField field = field_of(bone, 16);
  for_each_node(field.shape(), [&](std::size_t offset, const Vec3& position) {
    const SignedPoint at = surface.locate(position);
    if (at.closest.triangle == 60 && at.closest.feature == Feature::face) {
      field.store(offset, -field.stored(offset));
    }
  });
  expect_refusal("made from a mesh with turned or flat triangles", field, bone);
}

TEST(ForeignField, IsAcceptedWithAnotherNotionOfInsideAboutAHole) {
  RepairedMesh bone{make_sphere(0.1, 3), false, {}};
  const Vec3 hole = bone.mesh.vertices[static_cast<std::size_t>(bone.mesh.triangles.back()[0])];
  bone.mesh.triangles.pop_back();
  CubicField field = field_of(bone, 16);
  int changed = 0;
  for_each_node(field.shape(), [&](std::size_t offset, const Vec3& position) {
    if ((position - hole).norm() < 0.03 && field.stored(offset) < 0) {
      field.store(offset, -field.stored(offset));
      ++changed;
    }
  });
  EXPECT_GT(changed, 10);
  EXPECT_EQ(refusal(field, bone), "accepted");
}

TEST(ForeignField, IsAcceptedOfASurfaceWithFewDigits) {
  EXPECT_EQ(refusal(field_of(box_of({0.03, 0.03, 0.03}), 8), box_of({0.030001, 0.030001, 0.030001})), "accepted");
}

TEST(ForeignField, OfRealBonesIsTold) {
  const auto folder = lhdl_folder();
  if (!folder) {
    GTEST_SKIP() << "the LHDL data are not here (set MUSCLEBENCH_DATA)";
  }
  for (const char* file : {"meshes/femur_r.ply", "meshes/pelvis.ply"}) {
    const TriangleMesh as_shipped = read_mesh(*folder / file);
    const RepairedMesh bone = repair_mesh(as_shipped, file);
    const SignedSurface surface(bone);
    CubicField field =
        build_field(SignedSurface({as_shipped, false, {}}), grid_over(as_shipped, {.cells = 24}, "bone"), 2);
    EXPECT_EQ(refusal(field, bone.mesh, surface), "accepted") << file;
    get_signs_wrong(field, bone.mesh, surface);
    EXPECT_EQ(refusal(field, bone.mesh, surface), "accepted") << file;
    for (const double scale : {0.99, 0.9995}) {
      RepairedMesh smaller = bone;
      const Vec3 middle = 0.5 * (field.shape().lower_m + field.shape().upper_m());
      for (Vec3& vertex : smaller.mesh.vertices) {
        vertex = middle + scale * (vertex - middle);
      }
      expect_refusal("another surface", field, smaller);
    }
  }
}

TEST(ForeignField, OfAnotherBoneIsRefused) {
  const RepairedMesh bone = box_of({0.03, 0.03, 0.03});
  CubicField field = field_of(bone, 8);
  expect_refusal("is off the distance to femur", field, box_of({0.0285, 0.0285, 0.0285}));
  expect_refusal("is off the distance to femur", field, box_of({0.03, 0.03, 0.0299}));
  expect_refusal("does not cover all of femur", field, box_of({30, 30, 30}));
  // In millimetres, though over the box in metres.
  CubicField other = field;
  for (float& value : other.values()) {
    value *= 1000;
  }
  expect_refusal("not in metres", other, bone);
}

TEST(ForeignField, WithoutSignsOrWithInvertedOnesIsRefused) {
  const RepairedMesh bone = box_of({0.03, 0.03, 0.03});
  const CubicField field = field_of(bone, 8);
  CubicField other = field;
  for (float& value : other.values()) {
    value = -value;
  }
  expect_refusal("inverted", other, bone);
  for (float& value : other.values()) {
    value = std::abs(value);
  }
  expect_refusal("is not negative inside femur", other, bone);
}

TEST(ForeignField, ThatIsDamagedInOneNodeIsRefused) {
  const RepairedMesh bone = box_of({0.03, 0.03, 0.03});
  CubicField field = field_of(bone, 9);
  const double cell_m = field.shape().cell_size_m[0];
  std::vector<std::size_t> offsets;
  for_each_node(field.shape(), [&](std::size_t offset, const Vec3& /*position*/) { offsets.push_back(offset); });
  // A prime, so that corners and all nodes of edges come, inside, outside and on the border.
  for (std::size_t n = 0; n < offsets.size(); n += 61) {
    const std::size_t offset = offsets[n];
    const double sound = field.stored(offset);
    for (const double damaged : {1.87e34, -5.4e36, -1e30, sound + 2 * cell_m, 2 * sound, 4 * sound, -sound}) {
      // Nearer than that to the surface it might as well be there.
      if (std::abs(damaged - sound) > 0.7 * cell_m) {
        field.store(offset, damaged);
        ASSERT_NE(refusal(field, bone), "accepted") << sound << " as " << damaged;
      }
    }
    field.store(offset, sound);
  }
  const std::size_t middle = field.shape().record(4, 4, 4);
  const double sound = field.stored(middle);
  field.store(middle, 1.87e34);
  expect_refusal("is damaged: two nodes of cell 3 3 3 hold 1.87e+34 m", field, bone);
  field.store(middle, -sound);
  expect_refusal("holds 0.0267 m at a node of cell 3 3 3 that is 0.0267 m inside femur", field, bone);
}

}  // namespace
}  // namespace musclebench

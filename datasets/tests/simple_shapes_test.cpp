#include "datasets/simple_shapes.hpp"

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {
namespace {

/// Every edge has two triangles, which run along it in opposite directions.
bool is_closed_and_consistent(const TriangleMesh& mesh) {
  const MeshEdges edges(mesh);
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    if (uses.size() != 2 || uses[0].forward == uses[1].forward) return false;
  }
  return true;
}

TEST(SimpleShapes, AreClosedAndOutwardButForSheets) {
  for (const std::string& name : simple_shape_names()) {
    const TriangleMesh mesh = simple_shape(name);
    const bool is_sheet = name == "hinge" || name == "folded_sheet";
    EXPECT_EQ(is_closed_and_consistent(mesh), !is_sheet) << name;
    if (!is_sheet) {
      EXPECT_GT(surface_volume_m3(mesh.vertices, mesh.triangles), 1e-7) << name;
    }
    for (const Vec3& vertex : mesh.vertices) ASSERT_LT(vertex.norm(), 0.3) << name;
  }
}

TEST(SimpleShapes, AnUnknownNameIsAnsweredWithTheNearest) {
  try {
    (void)simple_shape("bal");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("synthetic:bal: is unknown; did you mean 'ball'?"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace musclebench

#include "core/mesh/mesh_edges.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// Two triangles at an edge, one that touches them in a corner, one apart, and a vertex that none uses.
TEST(MeshEdges, ComponentsAreJoinedByAnySharedVertex) {
  const TriangleMesh mesh{std::vector<Vec3>(11, Vec3::Zero()), {{1, 2, 3}, {3, 2, 4}, {6, 5, 4}, {9, 8, 10}}};
  EXPECT_EQ(first_of_component(mesh), (std::vector<int>{0, 1, 1, 1, 1, 1, 1, 7, 8, 8, 8}));
  EXPECT_TRUE(first_of_component({}).empty());
}

}  // namespace
}  // namespace musclebench

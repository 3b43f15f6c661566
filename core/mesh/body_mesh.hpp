#pragma once

#include "core/mesh/body.hpp"

namespace musclebench {

/// The surface of one body of `all`, with its nodes numbered from 0.
inline TriangleMesh mesh_of(const TriangleMesh& all, const Body& body) {
  TriangleMesh mesh;
  mesh.vertices.assign(all.vertices.begin() + body.first_node, all.vertices.begin() + body.last_node);
  mesh.triangles.reserve(body.last_triangle - body.first_triangle);
  for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
    Triangle triangle = all.triangles[t];
    for (int& corner : triangle) corner -= body.first_node;
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace musclebench

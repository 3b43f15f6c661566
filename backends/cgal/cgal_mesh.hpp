#pragma once

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalPoint = CgalKernel::Point_3;
using CgalMesh = CGAL::Surface_mesh<CgalPoint>;
using CgalPrimitive = CGAL::AABB_face_graph_triangle_primitive<CgalMesh>;
using CgalTree = CGAL::AABB_tree<CGAL::AABB_traits<CgalKernel, CgalPrimitive>>;
using CgalSide = CGAL::Side_of_triangle_mesh<CgalMesh, CgalKernel>;

/// A surface as CGAL holds it. Its face number i is triangle number i. CGAL's meshes are manifold: where the surface is
/// not, its vertices are doubled.
struct CgalSurface {
  CgalMesh mesh;
  std::vector<int> vertex_of;  ///< by CGAL's vertex: ours, an index of the positions
};

/// Of `triangles`, whose corners are indices of `positions` (m).
CgalSurface to_cgal(std::span<const Vec3> positions, std::span<const Triangle> triangles);

inline CgalPoint to_cgal(const Vec3& point) { return {point.x(), point.y(), point.z()}; }

/// By the sizes of what CGAL documents: a mesh with three halfedges a face, a tree with a primitive a face and as many
/// nodes with a box, and a search tree of one point a face where distance queries are accelerated.
std::size_t cgal_bytes(const CgalMesh& mesh, bool accelerates);

}  // namespace musclebench

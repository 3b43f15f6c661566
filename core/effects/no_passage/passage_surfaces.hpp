#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <span>
#include <vector>

#include "core/effects/no_passage/stencil.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Two features that may touch: corners of a stencil as vertices of the muscles' mesh or of a bone's.
struct PassageStencil {
  StencilKind kind = StencilKind::node_face;
  int bone = -1;               ///< -1: all corners are nodes
  bool bone_is_first = false;  ///< with a bone: whether the stencil's first side is its
  std::array<int, 4> corners = {};

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes the 0 that results are compared with for a pointer.
  friend auto operator<=>(const PassageStencil&, const PassageStencil&) = default;

  [[nodiscard]] bool is_of_bone(std::size_t corner) const {
    const std::size_t second = kind == StencilKind::node_face ? 1 : 2;
    return bone >= 0 && (corner < second) == bone_is_first;
  }
  /// For corners of one mesh: whether both sides have one in common, so that they are never apart.
  [[nodiscard]] bool shares_a_vertex() const {
    const auto& [a, b, c, d] = corners;
    if (kind == StencilKind::node_face) return a == b || a == c || a == d;
    return a == c || a == d || b == c || b == d;
  }
};

/// A surface with each edge and each vertex given to one of its triangles, so that going through pairs of triangles
/// meets each pair of features once.
struct OwnedFeatures {
  struct OfTriangle {
    std::array<int, 3> vertices{-1, -1, -1};  ///< -1: another triangle's
    std::array<std::array<int, 2>, 3> edges{{{-1, -1}, {-1, -1}, {-1, -1}}};
  };

  explicit OwnedFeatures(std::span<const Triangle> triangles, std::size_t vertices);

  std::vector<OfTriangle> of;
};

/// Of one mesh.
inline bool share_a_vertex(const Triangle& one, const Triangle& other) {
  return std::ranges::any_of(one, [&](int vertex) { return std::ranges::find(other, vertex) != other.end(); });
}

/// All stencils of two triangles that own their features.
template <typename Visit>
void for_each_stencil(const OwnedFeatures::OfTriangle& one, const Triangle& face_of_one,
                      const OwnedFeatures::OfTriangle& other, const Triangle& face_of_other, const Visit& visit) {
  for (const int vertex : one.vertices) {
    if (vertex >= 0)
      visit(StencilKind::node_face, true, std::array{vertex, face_of_other[0], face_of_other[1], face_of_other[2]});
  }
  for (const int vertex : other.vertices) {
    if (vertex >= 0)
      visit(StencilKind::node_face, false, std::array{vertex, face_of_one[0], face_of_one[1], face_of_one[2]});
  }
  for (const auto& mine : one.edges) {
    if (mine[0] < 0) continue;
    for (const auto& theirs : other.edges) {
      if (theirs[0] >= 0) visit(StencilKind::edge_edge, true, std::array{mine[0], mine[1], theirs[0], theirs[1]});
    }
  }
}

}  // namespace musclebench

#include "core/effects/no_passage/passage_surfaces.hpp"

#include <algorithm>
#include <utility>

namespace musclebench {

OwnedFeatures::OwnedFeatures(std::span<const Triangle> triangles, std::size_t vertices) : of(triangles.size()) {
  std::vector<char> has_owner(vertices, 0);
  struct Side {
    std::array<int, 2> edge;  ///< the smaller vertex first
    std::size_t triangle;
    std::size_t side;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int vertex = triangles[t][k];
      const int next = triangles[t][(k + 1) % 3];
      if (std::exchange(has_owner[static_cast<std::size_t>(vertex)], 1) == 0) of[t].vertices[k] = vertex;
      sides.push_back({{std::min(vertex, next), std::max(vertex, next)}, t, k});
    }
  }
  std::ranges::stable_sort(sides, {}, &Side::edge);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i > 0 && sides[i].edge == sides[i - 1].edge) continue;
    of[sides[i].triangle].edges[sides[i].side] = sides[i].edge;
  }
}

}  // namespace musclebench

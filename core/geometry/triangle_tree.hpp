#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "core/geometry/triangle_distance.hpp"
#include "core/geometry/triangle_mesh.hpp"

namespace musclebench {

struct ClosestPoint {
  Vec3 point = Vec3::Zero();
  double distance_m = 0;
  int triangle = -1;
  Feature feature = Feature::face;
};

/// A bounding-box tree over the triangles of a mesh, for closest points and winding numbers: four children a node, four
/// triangles a leaf, both tested side by side. Keeps a copy of the triangles' corners; the mesh need not outlive it.
/// Queries are const and safe from several threads.
class TriangleTree {
 public:
  explicit TriangleTree(const TriangleMesh& mesh);

  /// The closest point within `max_distance_m`; nothing when the surface is farther away. Of several triangles at the
  /// same distance (to rounding) the one with the smallest index.
  [[nodiscard]] std::optional<ClosestPoint> closest_point(
      const Vec3& point, double max_distance_m = std::numeric_limits<double>::infinity()) const;

  /// The closest point, found faster from a triangle that is known to be near: the closest one of a neighbouring query.
  /// `triangle` is any triangle of the mesh; the answer is that of `closest_point`.
  [[nodiscard]] ClosestPoint closest_point_from(const Vec3& point, int triangle) const;

  /// Generalised winding number (Jacobson et al. 2013), far clusters by their dipole (Barill et al. 2018): about 1
  /// inside an outward closed surface, 0 outside; inside is > 0.5. A result within 0.25 of 0.5 is refined, in the end
  /// exactly.
  [[nodiscard]] double winding_number(const Vec3& point) const;

  /// Normal of a triangle by its winding, as long as twice its area; zero where it has none.
  [[nodiscard]] Vec3 area_normal(int triangle) const;

  [[nodiscard]] std::size_t triangle_count() const { return m_place.size(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  static constexpr int width = 4;

  /// Up to `width` children, each bounded by a box and by a slab across its mean normal: a nearly flat patch fills
  /// little of its box, and most of what a search must look into is such a box that the sphere of the best distance
  /// cuts. An unused child's box is empty (lower = infinity), so that it is never the closest.
  struct Node {
    std::array<std::array<double, width>, 3> lower;
    std::array<std::array<double, width>, 3> upper;
    std::array<std::array<double, width>, 3> normal;
    std::array<double, width> slab_lower;
    std::array<double, width> slab_upper;
    std::array<int, width> child;  ///< index of a node, or ~index of a leaf
  };
  /// Up to `width` triangles; unused places repeat the first one.
  struct Leaf {
    std::array<std::array<std::array<double, width>, 3>, 3> corner;  ///< [corner][axis][place]
    std::array<int, width> triangle;
    int count = 0;
  };
  /// The triangles below one child as seen from afar.
  struct Cluster {
    Vec3 centre = Vec3::Zero();
    Vec3 area_normal = Vec3::Zero();
    double radius = 0;  ///< of the ball about `centre` that holds the triangles
  };
  struct Builder;
  struct Search;

  void search(Search& state) const;
  void search_leaf(const Leaf& leaf, Search& state) const;
  /// Clusters count as far beyond `opening` times their radius.
  [[nodiscard]] double winding_number(const Vec3& point, double opening) const;
  [[nodiscard]] double leaf_winding(const Leaf& leaf, const Vec3& point) const;
  [[nodiscard]] std::array<Vec3, 3> corners(int triangle) const;

  std::vector<Node> m_nodes;
  std::vector<std::array<Cluster, width>> m_clusters;  ///< one a child of a node
  std::vector<Leaf> m_leaves;
  std::vector<int> m_place;  ///< of each triangle: width * leaf + place
};

}  // namespace musclebench

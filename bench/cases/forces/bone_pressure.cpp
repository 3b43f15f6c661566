#include "bench/cases/forces/bone_pressure.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/triangle_distance.hpp"

namespace musclebench {

namespace {

using Corners = std::array<Vec3, 3>;

/// Samples of the bone are this many times as fine as the edges of the muscle.
constexpr double samples_per_edge = 2;
/// And no finer than this share of a bone's triangle: the edges of a muscle that has collapsed may be 0, or nearly.
constexpr double finest_share = 1e-6;
/// So far beside the muscle, in its edges, or beneath what is round between its nodes, a bone is still under it.
constexpr double edges_away = 0.5;
/// A node that has flown off since it was pushed does not reach for the bone from afar.
constexpr double most_edges_of_margin = 4;

/// Of a triangle without area.
const Vec3 even_weights = Vec3::Constant(1.0 / 3);

/// A small piece of a bone under a triangle of a muscle.
struct Sample {
  Triangle nodes;       ///< of the muscle
  Vec3 node_weights;    ///< of its closest point
  Triangle vertices;    ///< of the bone
  Vec3 vertex_weights;  ///< of its centre
  double area_m2;
};

Corners corners_of(const Triangle& triangle, std::span<const Vec3> positions_m) {
  const auto at = [&](int corner) { return positions_m[static_cast<std::size_t>(corner)]; };
  return {at(triangle[0]), at(triangle[1]), at(triangle[2])};
}

Vec3 area_vector(const Corners& corners) { return (corners[1] - corners[0]).cross(corners[2] - corners[0]) / 2; }

double longest_edge_m(const Corners& corners) {
  double longest_m = 0;
  for (std::size_t k = 0; k < 3; ++k) longest_m = std::max(longest_m, (corners[(k + 1) % 3] - corners[k]).norm());
  return longest_m;
}

/// Triangles with a node that is pushed.
std::vector<Triangle> pressed(std::span<const Triangle> triangles, std::span<const Vec3> pushes_n) {
  std::vector<Triangle> found;
  std::ranges::copy_if(triangles, std::back_inserter(found), [&](const Triangle& triangle) {
    return std::ranges::any_of(triangle, [&](int node) { return !pushes_n[static_cast<std::size_t>(node)].isZero(0); });
  });
  return found;
}

/// The triangles of a muscle that press, and how far a bone's point may be away from them.
class PressedPatch {
 public:
  PressedPatch(const TriangleBvh& bone, std::vector<Triangle> triangles, std::span<const Vec3> positions_m,
               std::span<const Vec3> pushes_n)
      : m_triangles(std::move(triangles)), m_tree(mesh_of(m_triangles, positions_m)) {
    double sum_m = 0;
    for (const Triangle& triangle : m_triangles) sum_m += longest_edge_m(corners_of(triangle, positions_m));
    m_edge_m = sum_m / static_cast<double>(m_triangles.size());
    for (const Triangle& triangle : m_triangles) {
      double away_m = 0;
      for (const int node : triangle) {
        const auto n = static_cast<std::size_t>(node);
        if (!pushes_n[n].isZero(0)) away_m = std::max(away_m, bone.closest_point(positions_m[n])->distance_m);
      }
      m_reaches_m.push_back(edges_away * m_edge_m + std::min(away_m, most_edges_of_margin * m_edge_m));
      m_farthest_m = std::max(m_farthest_m, m_reaches_m.back());
    }
  }

  /// Appends the samples of a bone's triangle that lie under the patch.
  void sample(const Triangle& vertices, const Corners& whole, std::vector<Sample>& samples) const {
    const double edge_m = std::max(m_edge_m / samples_per_edge, finest_share * longest_edge_m(whole));
    sample_part(vertices, whole, whole, edge_m, samples);
  }

 private:
  static TriangleMesh mesh_of(const std::vector<Triangle>& triangles, std::span<const Vec3> positions_m) {
    TriangleMesh mesh;
    for (const Triangle& triangle : triangles) {
      const auto first = static_cast<int>(mesh.vertices.size());
      for (const Vec3& corner : corners_of(triangle, positions_m)) mesh.vertices.push_back(corner);
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
  }

  /// By halves along the longest edge, so that a long thin triangle has no more samples than its length needs.
  void sample_part(const Triangle& vertices, const Corners& whole, const Corners& part, double edge_m,
                   std::vector<Sample>& samples) const {
    const Vec3 centre = (part[0] + part[1] + part[2]) / 3;
    double radius_m = 0;
    for (const Vec3& corner : part) radius_m = std::max(radius_m, (corner - centre).norm());
    const std::optional<ClosestPoint> closest = m_tree.closest_point(centre, m_farthest_m + radius_m);
    if (!closest) return;
    std::array<double, 3> edges_m{};
    for (std::size_t k = 0; k < 3; ++k) edges_m[k] = (part[(k + 1) % 3] - part[k]).norm();
    const auto longest = static_cast<std::size_t>(std::ranges::max_element(edges_m) - edges_m.begin());
    if (edges_m[longest] > edge_m) {
      const Vec3 middle = (part[longest] + part[(longest + 1) % 3]) / 2;
      Corners one = part;
      Corners other = part;
      one[longest] = middle;
      other[(longest + 1) % 3] = middle;
      sample_part(vertices, whole, one, edge_m, samples);
      sample_part(vertices, whole, other, edge_m, samples);
      return;
    }
    const auto triangle = static_cast<std::size_t>(closest->triangle);
    const Vec3 area = area_vector(part);
    // What faces the same way is the far side of a thin muscle or bone.
    if (closest->distance_m > m_reaches_m[triangle] || area.dot(m_tree.area_normal(closest->triangle)) >= 0) return;
    samples.push_back({.nodes = m_triangles[triangle],
                       .node_weights = barycentric(closest->point, m_tree.corners()[triangle], even_weights),
                       .vertices = vertices,
                       .vertex_weights = barycentric(centre, whole, even_weights),
                       .area_m2 = area.norm()});
  }

  std::vector<Triangle> m_triangles;
  TriangleBvh m_tree;
  double m_edge_m = 0;
  std::vector<double> m_reaches_m;  ///< by triangle of the patch
  double m_farthest_m = 0;
};

}  // namespace

BonePressure::BonePressure(const TriangleMesh& bone)
    : m_bone(bone),
      m_tree(bone),
      m_areas(bone.vertices.size(), bone.triangles),
      m_loads{.forces_n = std::vector<Vec3>(bone.vertices.size(), Vec3::Zero()),
              .pressures_pa = std::vector<double>(bone.vertices.size(), 0)} {}

void BonePressure::add(std::span<const Triangle> triangles, std::span<const Vec3> positions_m,
                       std::span<const Vec3> pushes_n) {
  const std::vector<Triangle> pressing = pressed(triangles, pushes_n);
  const bool is_told = std::ranges::all_of(pressing, [&](const Triangle& triangle) {
    return std::ranges::all_of(triangle, [&](int node) {
      const auto n = static_cast<std::size_t>(node);
      return positions_m[n].allFinite() && pushes_n[n].allFinite();
    });
  });
  if (m_bone.triangles.empty() || pressing.empty() || !is_told) return;
  const PressedPatch patch(m_tree, pressing, positions_m, pushes_n);
  std::vector<Sample> samples;
  for (const Triangle& triangle : m_bone.triangles) {
    patch.sample(triangle, corners_of(triangle, m_bone.vertices), samples);
  }
  std::vector<double> covered_m2(positions_m.size(), 0);
  for (const Sample& sample : samples) {
    for (int k = 0; k < 3; ++k) {
      covered_m2[static_cast<std::size_t>(sample.nodes[static_cast<std::size_t>(k)])] +=
          sample.node_weights[k] * sample.area_m2;
    }
  }
  std::vector<Vec3> forces_n(m_bone.vertices.size(), Vec3::Zero());
  const auto put = [&](const Triangle& vertices, const Vec3& weights, const Vec3& force_n) {
    for (int k = 0; k < 3; ++k)
      forces_n[static_cast<std::size_t>(vertices[static_cast<std::size_t>(k)])] += weights[k] * force_n;
  };
  for (const Sample& sample : samples) {
    Vec3 force_n = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      const auto node = static_cast<std::size_t>(sample.nodes[static_cast<std::size_t>(k)]);
      if (covered_m2[node] > 0) force_n -= sample.node_weights[k] * sample.area_m2 / covered_m2[node] * pushes_n[node];
    }
    put(sample.vertices, sample.vertex_weights, force_n);
  }
  // A node that covers no sample, at a needle's tip, say.
  std::vector<int> nodes;
  for (const Triangle& triangle : pressing) nodes.insert(nodes.end(), triangle.begin(), triangle.end());
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  for (const int n : nodes) {
    const auto node = static_cast<std::size_t>(n);
    if (pushes_n[node].isZero(0) || covered_m2[node] > 0) continue;
    const ClosestPoint closest = *m_tree.closest_point(positions_m[node]);
    const Triangle& vertices = m_bone.triangles[static_cast<std::size_t>(closest.triangle)];
    put(vertices, barycentric(closest.point, corners_of(vertices, m_bone.vertices), even_weights), -pushes_n[node]);
  }
  for (std::size_t vertex = 0; vertex < forces_n.size(); ++vertex) {
    if (forces_n[vertex].isZero(0)) continue;
    const double area_m2 = m_areas.about_m2(static_cast<int>(vertex), forces_n[vertex], m_bone.vertices);
    if (area_m2 > 0) m_loads.pressures_pa[vertex] += forces_n[vertex].norm() / area_m2;
    m_loads.forces_n[vertex] += forces_n[vertex];
  }
}

}  // namespace musclebench

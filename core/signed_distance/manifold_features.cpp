#include "core/signed_distance/manifold_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/triangle_separation.hpp"
#include "core/mesh/mesh_edges.hpp"

namespace musclebench {

namespace {

/// Triangles closer than this, relative to their size and to the largest coordinate, count as touching: far more than
/// rounding, far less than the distance between two sheets of a surface.
constexpr double gap_by_size = 1e-9;
constexpr double gap_by_coordinate = 1e-12;
/// The normal of a triangle with a smaller sine at a corner is dominated by rounding.
constexpr double least_sine = 1e-6;

class Finder {
 public:
  Finder(const TriangleMesh& mesh, const TriangleBvh& tree, const MeshEdges& edges)
      : m_mesh(mesh),
        m_tree(tree),
        m_edges(edges),
        m_is_candidate(mesh.triangles.size()),
        m_partner(3 * mesh.triangles.size(), -1) {}

  [[nodiscard]] std::vector<std::uint8_t> find() {
    find_separate_triangles();
    find_partners();
    keep_outer_patches();
    return features();
  }

 private:
  [[nodiscard]] std::array<Vec3, 3> corners(std::size_t triangle) const {
    const auto& [a, b, c] = m_mesh.triangles[triangle];
    return {m_mesh.vertices[static_cast<std::size_t>(a)], m_mesh.vertices[static_cast<std::size_t>(b)],
            m_mesh.vertices[static_cast<std::size_t>(c)]};
  }

  /// Candidates have an area and touch other triangles only at shared edges and vertices.
  void find_separate_triangles() {
    double reach = 0;
    for (const Vec3& vertex : m_mesh.vertices) {
      reach = std::max(reach, vertex.cwiseAbs().maxCoeff());
    }
    for (std::size_t t = 0; t < m_is_candidate.size(); ++t) {
      const auto [a, b, c] = corners(t);
      const std::array<double, 3> squared = {(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()};
      const double normal = (b - a).cross(c - a).norm();
      // The smallest sine lies between the two longest sides.
      const double longest = *std::max_element(squared.begin(), squared.end());
      m_is_candidate[t] = static_cast<char>(normal > least_sine * longest);
    }
    m_tree.for_each_close_pair([&](int one, int other) {
      const auto i = static_cast<std::size_t>(one);
      const auto j = static_cast<std::size_t>(other);
      const auto of_one = corners(i);
      const auto of_other = corners(j);
      const double size =
          std::sqrt(std::max((of_one[1] - of_one[0]).squaredNorm() + (of_one[2] - of_one[0]).squaredNorm(),
                             (of_other[1] - of_other[0]).squaredNorm() + (of_other[2] - of_other[0]).squaredNorm()));
      if (!surely_apart({m_mesh.triangles[i], of_one}, {m_mesh.triangles[j], of_other},
                        gap_by_size * size + gap_by_coordinate * reach)) {
        m_is_candidate[i] = 0;
        m_is_candidate[j] = 0;
      }
    });
  }

  /// m_partner: for half-edge 3 t + k the opposite half-edge, where exactly two consistently wound triangles meet.
  void find_partners() {
    for (int edge = 0; edge < m_edges.count(); ++edge) {
      const auto uses = m_edges.uses(edge);
      if (uses.size() == 2 && uses[0].forward != uses[1].forward) {
        m_partner[static_cast<std::size_t>(uses[0].corner)] = uses[1].corner;
        m_partner[static_cast<std::size_t>(uses[1].corner)] = uses[0].corner;
      }
    }
  }

  /// The winding numbers on both sides are constant over a patch of connected candidates, so that one point decides.
  void keep_outer_patches() {
    std::vector<char> seen(m_is_candidate.size(), 0);
    std::vector<int> patch;
    for (std::size_t seed = 0; seed < m_is_candidate.size(); ++seed) {
      if (m_is_candidate[seed] == 0 || seen[seed] != 0) {
        continue;
      }
      patch.assign(1, static_cast<int>(seed));
      seen[seed] = 1;
      for (std::size_t next = 0; next < patch.size(); ++next) {
        for (int side = 3 * patch[next]; side < 3 * patch[next] + 3; ++side) {
          const int other = m_partner[static_cast<std::size_t>(side)] / 3;
          const bool joined = m_partner[static_cast<std::size_t>(side)] >= 0;
          if (joined && m_is_candidate[static_cast<std::size_t>(other)] != 0 &&
              seen[static_cast<std::size_t>(other)] == 0) {
            seen[static_cast<std::size_t>(other)] = 1;
            patch.push_back(other);
          }
        }
      }
      if (!has_inside_on_inner_side_only(patch)) {
        for (const int triangle : patch) {
          m_is_candidate[static_cast<std::size_t>(triangle)] = 0;
        }
      }
    }
  }

  /// Tested next to the middle of the patch's largest triangle, as far away from it as it stays the closest one.
  [[nodiscard]] bool has_inside_on_inner_side_only(const std::vector<int>& patch) const {
    const int largest = *std::max_element(patch.begin(), patch.end(), [&](int a, int b) {
      return m_tree.area_normal(a).squaredNorm() < m_tree.area_normal(b).squaredNorm();
    });
    const auto [a, b, c] = corners(static_cast<std::size_t>(largest));
    const Vec3 normal = m_tree.area_normal(largest);
    const Vec3 middle = (a + b + c) / 3;
    for (const double relative_step : {1e-2, 1e-4, 1e-6}) {
      const Vec3 step = relative_step * normal / std::sqrt(normal.norm());
      if (m_tree.closest_point(middle + step)->triangle == largest &&
          m_tree.closest_point(middle - step)->triangle == largest) {
        return m_tree.winding_number(middle + step) < 0.5 && m_tree.winding_number(middle - step) > 0.5;
      }
    }
    return false;
  }

  /// Whether the triangles about corner k of `triangle` are one closed fan of `count` candidates.
  [[nodiscard]] bool is_closed_fan(int triangle, int k, int count) const {
    int side = 3 * triangle + k;
    for (int i = 0; i < count; ++i) {
      if (m_is_candidate[static_cast<std::size_t>(side / 3)] == 0) {
        return false;
      }
      // The half-edge of this triangle that ends at the vertex; its partner starts there.
      const int last = side / 3 * 3 + (side + 2) % 3;
      side = m_partner[static_cast<std::size_t>(last)];
      if (side < 0) {
        return false;
      }
      if (side == 3 * triangle + k) {
        return i + 1 == count;
      }
    }
    return false;
  }

  [[nodiscard]] std::vector<std::uint8_t> features() const {
    std::vector<int> fan(m_mesh.vertices.size(), 0);
    for (const Triangle& triangle : m_mesh.triangles) {
      for (const int vertex : triangle) {
        ++fan[static_cast<std::size_t>(vertex)];
      }
    }
    std::vector<std::uint8_t> bits(m_is_candidate.size(), 0);
    for (std::size_t t = 0; t < bits.size(); ++t) {
      if (m_is_candidate[t] == 0) {
        continue;
      }
      unsigned manifold = 1U << static_cast<unsigned>(Feature::face);
      for (std::size_t k = 0; k < 3; ++k) {
        const int partner = m_partner[3 * t + k];
        const bool edge = partner >= 0 && m_is_candidate[static_cast<std::size_t>(partner / 3)] != 0;
        const bool corner = edge && is_closed_fan(static_cast<int>(t), static_cast<int>(k),
                                                  fan[static_cast<std::size_t>(m_mesh.triangles[t][k])]);
        manifold |= static_cast<unsigned>(edge) << (static_cast<unsigned>(Feature::edge_0) + k);
        manifold |= static_cast<unsigned>(corner) << (static_cast<unsigned>(Feature::corner_0) + k);
      }
      bits[t] = static_cast<std::uint8_t>(manifold);
    }
    return bits;
  }

  const TriangleMesh& m_mesh;
  const TriangleBvh& m_tree;
  const MeshEdges& m_edges;
  std::vector<char> m_is_candidate;
  std::vector<int> m_partner;
};

}  // namespace

ManifoldFeatures::ManifoldFeatures(const TriangleMesh& mesh, const TriangleBvh& tree)
    : ManifoldFeatures(mesh, tree, MeshEdges(mesh)) {}

ManifoldFeatures::ManifoldFeatures(const TriangleMesh& mesh, const TriangleBvh& tree, const MeshEdges& edges)
    : m_bits(Finder(mesh, tree, edges).find()) {}

}  // namespace musclebench

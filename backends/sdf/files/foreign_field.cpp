#include "backends/sdf/files/foreign_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/signed_distance/manifold_features.hpp"

namespace musclebench {

namespace {

constexpr std::size_t corners_of_cell = 8;
constexpr std::size_t nodes_of_cell = 32;

/// Nodes near the surface that are compared with it, and as many all over the domain.
constexpr std::size_t samples = 2000;

/// Of a cell: first its corners, x fastest, then two on each edge.
struct CellNode {
  std::array<std::size_t, 3> corner{};  ///< where it stands, or where its edge begins
  std::size_t axis = 0;                 ///< of its edge
  std::size_t thirds = 0;               ///< of its edge; 0: a corner
};

std::array<CellNode, nodes_of_cell> make_cell_nodes() {
  std::array<CellNode, nodes_of_cell> nodes{};
  std::size_t count = 0;
  for (std::size_t corner = 0; corner < corners_of_cell; ++corner) {
    nodes[count++].corner = {corner & 1U, corner >> 1 & 1U, corner >> 2};
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t corner = 0; corner < corners_of_cell; ++corner) {
      if ((corner >> axis & 1U) == 0) {
        for (const std::size_t thirds : {1, 2}) {
          nodes[count++] = {nodes[corner].corner, axis, thirds};
        }
      }
    }
  }
  return nodes;
}

using CellIndex = GridIndex::Coordinates;

class ForeignField {
 public:
  ForeignField(const CubicField& field, const TriangleMesh& mesh, const SignedSurface& surface,
               const std::string& bone_name, const std::filesystem::path& path)
      : m_field(field),
        m_shape(field.shape()),
        m_mesh(mesh),
        m_surface(surface),
        m_bone_name(bone_name),
        m_path(path),
        m_slack_m(1e-3 * m_shape.cell_size_m.minCoeff() + 1e-6 * (m_shape.upper_m() - m_shape.lower_m).norm()) {
    // Offsets of records are linear in the coordinates of their vertices.
    for (std::size_t n = 0; n < nodes_of_cell; ++n) {
      const auto& [corner, axis, thirds] = m_nodes[n];
      m_offset[n] = m_shape.record(corner[0], corner[1], corner[2]) +
                    (thirds == 0 ? 0 : GridShape::edge_offset[axis] + thirds - 1);
      Vec3 in_cells(static_cast<double>(corner[0]), static_cast<double>(corner[1]), static_cast<double>(corner[2]));
      in_cells[static_cast<Eigen::Index>(axis)] += static_cast<double>(thirds) / 3;
      m_from_cell_m[n] = in_cells.cwiseProduct(m_shape.cell_size_m);
      for (std::size_t m = 0; m < n; ++m) {
        m_most_m[n][m] = (m_from_cell_m[n] - m_from_cell_m[m]).norm() + m_slack_m;
      }
    }
  }

  void require_cover() const {
    for (const Vec3& vertex : m_mesh.vertices) {
      if (!m_field.locate(vertex)) {
        refuse(fmt::format("does not cover all of {}: was it made from this surface, in metres?", m_bone_name));
      }
    }
    std::size_t negative = 0;
    for (std::size_t n = 0; n < corners_of_cell; ++n) {
      const CellIndex& side = m_nodes[n].corner;
      const std::size_t record =
          m_shape.record(side[0] * m_shape.count(0), side[1] * m_shape.count(1), side[2] * m_shape.count(2));
      negative += m_field.stored(record) < 0 ? 1U : 0U;
    }
    if (2 * negative > corners_of_cell) {
      refuse(fmt::format("is negative outside {}: its signs are inverted", m_bone_name));
    }
  }

  void require_distances() {
    std::size_t checked = 0;
    std::size_t wrong = 0;
    std::size_t inside = 0;
    std::size_t not_negative = 0;
    double largest_m = 0;
    for_each_sample([&](const CellIndex& cell, std::size_t node) {
      const double exact_m = m_surface.locate(position(cell, node)).signed_distance_m();
      const double difference_m = std::abs(std::abs(value(cell, node)) - std::abs(exact_m));
      ++checked;
      wrong += difference_m > m_slack_m ? 1U : 0U;
      largest_m = std::max(largest_m, difference_m);
      inside += exact_m < -m_slack_m ? 1U : 0U;
      not_negative += exact_m < -m_slack_m && value(cell, node) > 0 ? 1U : 0U;
    });
    if (100 * wrong > checked) {
      refuse(
          fmt::format("is off the distance to {} by more than {:.2g} mm at {} of {} nodes, by up to {:.3g} mm: it was "
                      "made from another surface, or is not in metres",
                      m_bone_name, m_slack_m * 1e3, wrong, checked, largest_m * 1e3));
    }
    if (2 * not_negative > inside) {
      refuse(fmt::format("is not negative inside {}: its distances have no sign", m_bone_name));
    }
    for_each_sample([&](const CellIndex& cell, std::size_t node) { require_side(cell, node); });
  }

  void require_slopes() {
    for_each_in({0, 0, 0}, m_shape.cell_grid().count, [&](std::size_t i, std::size_t j, std::size_t k) {
      if (const CellIndex cell{i, j, k}; has_steep_pair(cell)) {
        require_slopes_of(cell);
      }
    });
  }

 private:
  [[noreturn]] void refuse(const std::string& problem) const {
    throw InputError(m_path.string(),
                     problem + "; make it again from this bone's mesh, or leave out `discregrid` to build it here");
  }

  [[nodiscard]] double value(const CellIndex& cell, std::size_t node) const {
    return m_field.stored(m_shape.record(cell[0], cell[1], cell[2]) + m_offset[node]);
  }
  [[nodiscard]] Vec3 position(const CellIndex& cell, std::size_t node) const {
    const Vec3 in_cells(static_cast<double>(cell[0]), static_cast<double>(cell[1]), static_cast<double>(cell[2]));
    return m_shape.lower_m + in_cells.cwiseProduct(m_shape.cell_size_m) + m_from_cell_m[node];
  }

  template <typename Visit>
  void for_each_sample(const Visit& visit) const {
    const auto visit_one_of = [&](const CellIndex& cell, std::size_t turn) { visit(cell, turn % nodes_of_cell); };
    for (std::size_t n = 0; n < samples; ++n) {
      const CellPosition at = *m_field.locate(m_mesh.vertices[n * m_mesh.vertices.size() / samples]);
      visit_one_of({at.i, at.j, at.k}, n);
      visit_one_of(m_shape.cell_grid().coordinates(n * m_shape.cell_count() / samples), n);
    }
  }

  [[nodiscard]] bool has_steep_pair(const CellIndex& cell) const {
    std::array<double, nodes_of_cell> values{};
    for (std::size_t n = 0; n < nodes_of_cell; ++n) {
      values[n] = value(cell, n);
    }
    std::int64_t steep = 0;
    for (std::size_t n = 1; n < nodes_of_cell; ++n) {
      for (std::size_t m = 0; m < n; ++m) {
        steep += std::abs(values[n] - values[m]) > m_most_m[n][m] ? 1 : 0;
      }
    }
    return steep > 0;
  }

  void require_slopes_of(const CellIndex& cell) {
    std::array<bool, nodes_of_cell> is_doubtful{};
    for (std::size_t n = 1; n < nodes_of_cell; ++n) {
      for (std::size_t m = 0; m < n; ++m) {
        const double one = value(cell, n);
        const double other = value(cell, m);
        if (!(std::abs(one - other) > m_most_m[n][m])) continue;
        if (std::abs(std::abs(one) - std::abs(other)) > m_most_m[n][m]) {
          refuse(
              fmt::format("is damaged: two nodes of cell {} {} {} hold {:.3g} m and {:.3g} m, which differ by more "
                          "than the {:.3g} m between them",
                          cell[0], cell[1], cell[2], one, other, m_most_m[n][m] - m_slack_m));
        }
        is_doubtful[n] = is_doubtful[m] = true;
      }
    }
    for (std::size_t n = 0; n < nodes_of_cell; ++n) {
      if (is_doubtful[n]) {
        require_side(cell, n);
      }
    }
  }

  void require_side(const CellIndex& cell, std::size_t node) {
    const SignedPoint exact = m_surface.locate(position(cell, node));
    const bool is_negative = value(cell, node) < 0;
    if (is_negative == exact.inside || exact.closest.distance_m <= m_slack_m || !m_surface.closed()) {
      return;
    }
    if (!m_clean) {
      m_clean.emplace(m_mesh, m_surface.tree());
    }
    if (m_clean->holds(exact.closest.triangle, exact.closest.feature) && faces_agree(exact, position(cell, node))) {
      refuse(
          fmt::format("holds {:.3g} m at a node of cell {} {} {} that is {:.3g} m {} {}: it is damaged, or was made "
                      "from a mesh with turned or flat triangles",
                      value(cell, node), cell[0], cell[1], cell[2], exact.closest.distance_m,
                      exact.inside ? "inside" : "outside", m_bone_name));
    }
  }

  /// Whether a normal at the closest point has the right side however its faces are weighted. Discregrid's weights
  /// differ from version to version, and are not those by angles that would be right.
  [[nodiscard]] bool faces_agree(const SignedPoint& exact, const Vec3& point) const {
    if (exact.closest.feature < Feature::corner_0) {
      return true;
    }
    const auto corner_index =
        static_cast<std::size_t>(exact.closest.feature) - static_cast<std::size_t>(Feature::corner_0);
    const int corner = m_mesh.triangles[static_cast<std::size_t>(exact.closest.triangle)][corner_index];
    const Vec3 outward = point - exact.closest.point;
    for (std::size_t t = 0; t < m_mesh.triangles.size(); ++t) {
      const Triangle& triangle = m_mesh.triangles[t];
      if (std::find(triangle.begin(), triangle.end(), corner) != triangle.end() &&
          (m_surface.tree().area_normal(static_cast<int>(t)).dot(outward) < 0) != exact.inside) {
        return false;
      }
    }
    return true;
  }

  const CubicField& m_field;
  const GridShape& m_shape;
  const TriangleMesh& m_mesh;
  const SignedSurface& m_surface;
  const std::string& m_bone_name;
  const std::filesystem::path& m_path;
  double m_slack_m;
  std::array<CellNode, nodes_of_cell> m_nodes = make_cell_nodes();
  std::array<std::size_t, nodes_of_cell> m_offset{};  ///< from the record of the cell to that of the node
  std::array<Vec3, nodes_of_cell> m_from_cell_m;
  /// By how much the values of two nodes may differ, for a node and those before it.
  std::array<std::array<double, nodes_of_cell>, nodes_of_cell> m_most_m{};
  std::optional<ManifoldFeatures> m_clean;  ///< made when it is first needed
};

}  // namespace

void require_field_of(const CubicField& field, const TriangleMesh& mesh, const SignedSurface& surface,
                      const std::string& bone_name, const std::filesystem::path& path) {
  ForeignField foreign(field, mesh, surface, bone_name, path);
  foreign.require_cover();
  foreign.require_distances();
  foreign.require_slopes();
}

}  // namespace musclebench

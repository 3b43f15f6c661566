#include "datasets/synthetic/synthetic_isosurface.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>

#include "core/base/grid_index.hpp"

namespace musclebench {

namespace {

using Cell = std::array<int, 3>;
using Tetrahedron = std::array<int, 4>;

constexpr int block_cells = 8;
constexpr int part_cells = 2;
constexpr int block_parts = block_cells / part_cells;
/// Of a field, whose gradient may exceed 1 by a few per cent; cells are skipped where it proves that there is no zero.
constexpr double lipschitz_bound = 1.3;
/// Cuts keep off the ends of an edge, so that no triangle is born with an edge of length zero.
constexpr double shortest_cut = 0.05;

/// Corner i of a cube lies at ((i >> 0) & 1, (i >> 1) & 1, (i >> 2) & 1). All tetrahedra are positively oriented.
constexpr std::array<Tetrahedron, 6> tetrahedra = {
    {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 3, 2, 7}, {0, 5, 1, 7}, {0, 6, 4, 7}}};

class Marcher {
 public:
  Marcher(const Field& field, const Vec3& lower_m, const Vec3& upper_m, double cell_m)
      : m_field(field), m_lower_m(lower_m), m_cell_m(cell_m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cells = (upper_m - lower_m)[static_cast<int>(axis)] / cell_m;
      m_blocks[axis] = static_cast<int>(cells / block_cells) + 1;
      m_nodes.count[axis] = static_cast<std::size_t>(m_blocks[axis] * block_cells + 1);
    }
  }

  TriangleMesh run() {
    Cell block;
    for (block[2] = 0; block[2] < m_blocks[2]; ++block[2]) {
      for (block[1] = 0; block[1] < m_blocks[1]; ++block[1]) {
        for (block[0] = 0; block[0] < m_blocks[0]; ++block[0]) {
          march_block(block);
        }
      }
    }
    return std::move(m_mesh);
  }

 private:
  [[nodiscard]] Vec3 position_m(const Cell& node) const {
    return m_lower_m + m_cell_m * Vec3(node[0], node[1], node[2]);
  }

  [[nodiscard]] std::int64_t index(const Cell& node) const {
    return static_cast<std::int64_t>(m_nodes.index(static_cast<std::size_t>(node[0]), static_cast<std::size_t>(node[1]),
                                                   static_cast<std::size_t>(node[2])));
  }

  double value(const Cell& node) {
    const auto [entry, fresh] = m_values.try_emplace(index(node), 0.0);
    if (fresh) {
      entry->second = m_field(position_m(node));
    }
    return entry->second;
  }

  void march_block(const Cell& block) {
    const Cell first = {block[0] * block_cells, block[1] * block_cells, block[2] * block_cells};
    m_may_cross.fill(false);
    find_parts(first, block_cells);
    for (int i = 0; i < block_cells * block_cells * block_cells; ++i) {
      const Cell cell = {first[0] + i % block_cells, first[1] + i / block_cells % block_cells,
                         first[2] + i / (block_cells * block_cells)};
      if (m_may_cross[part_index(cell)]) {
        march_cell(cell);
      }
    }
  }

  /// Marks the parts of a cube of cells that the surface may cross.
  void find_parts(const Cell& first, int cells) {
    const Vec3 centre = position_m(first) + Vec3::Constant(0.5 * cells * m_cell_m);
    const double reach = 0.5 * std::sqrt(3.0) * cells * m_cell_m;
    if (std::abs(m_field(centre)) > lipschitz_bound * reach) {
      return;
    }
    if (cells == part_cells) {
      m_may_cross[part_index(first)] = true;
      return;
    }
    const int half = cells / 2;
    for (int i = 0; i < 8; ++i) {
      find_parts({first[0] + half * (i & 1), first[1] + half * (i >> 1 & 1), first[2] + half * (i >> 2 & 1)}, half);
    }
  }

  /// Of the part of its block that holds the cell.
  static std::size_t part_index(const Cell& cell) {
    const auto part = [&](std::size_t axis) { return cell[axis] % block_cells / part_cells; };
    return static_cast<std::size_t>(part(0) + block_parts * (part(1) + block_parts * part(2)));
  }

  void march_cell(const Cell& cell) {
    std::array<Cell, 8> corners;
    std::array<double, 8> values;
    int inside = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      corners[i] = {cell[0] + static_cast<int>(i & 1), cell[1] + static_cast<int>(i >> 1 & 1),
                    cell[2] + static_cast<int>(i >> 2 & 1)};
      values[i] = value(corners[i]);
      inside += values[i] < 0 ? 1 : 0;
    }
    if (inside == 0 || inside == 8) {
      return;
    }
    for (const Tetrahedron& tetrahedron : tetrahedra) {
      march_tetrahedron(tetrahedron, corners, values);
    }
  }

  void march_tetrahedron(const Tetrahedron& tetrahedron, const std::array<Cell, 8>& corners,
                         const std::array<double, 8>& values) {
    unsigned inside = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      inside |= (values[static_cast<std::size_t>(tetrahedron[i])] < 0 ? 1U : 0U) << i;
    }
    if (inside == 0 || inside == 15) {
      return;
    }
    // Even permutations of the corners that bring the inside ones to the front.
    static constexpr std::array<Tetrahedron, 16> order = {{{0, 1, 2, 3},
                                                           {0, 1, 2, 3},
                                                           {1, 0, 3, 2},
                                                           {0, 1, 2, 3},
                                                           {2, 3, 0, 1},
                                                           {0, 2, 3, 1},
                                                           {1, 2, 0, 3},
                                                           {3, 2, 1, 0},
                                                           {3, 2, 1, 0},
                                                           {0, 3, 1, 2},
                                                           {1, 3, 2, 0},
                                                           {2, 3, 0, 1},
                                                           {2, 3, 0, 1},
                                                           {1, 0, 3, 2},
                                                           {0, 1, 2, 3},
                                                           {0, 1, 2, 3}}};
    const Tetrahedron& o = order[inside];
    const auto cut_edge = [&](int from, int to) {
      const auto a = static_cast<std::size_t>(tetrahedron[static_cast<std::size_t>(o[static_cast<std::size_t>(from)])]);
      const auto b = static_cast<std::size_t>(tetrahedron[static_cast<std::size_t>(o[static_cast<std::size_t>(to)])]);
      return cut(corners[a], values[a], corners[b], values[b]);
    };
    const int count = std::popcount(inside);
    if (count == 2) {
      const int ik = cut_edge(0, 2);
      const int il = cut_edge(0, 3);
      const int jl = cut_edge(1, 3);
      const int jk = cut_edge(1, 2);
      m_mesh.triangles.push_back({ik, il, jl});
      m_mesh.triangles.push_back({ik, jl, jk});
      return;
    }
    const int first = cut_edge(0, 1);
    const int second = cut_edge(0, 2);
    const int third = cut_edge(0, 3);
    // With three corners inside, the lone one in front is outside: the triangle turns round.
    m_mesh.triangles.push_back(count == 1 ? Triangle{first, second, third} : Triangle{first, third, second});
  }

  int cut(const Cell& a, double value_a, const Cell& b, double value_b) {
    const std::int64_t low = std::min(index(a), index(b));
    const std::int64_t high = std::max(index(a), index(b));
    // Node distance along an edge is one of seven; its difference of indices tells them apart within a grid.
    const std::int64_t step = high - low;
    const std::int64_t row = static_cast<std::int64_t>(m_nodes.count[0]);
    const std::int64_t layer = row * static_cast<std::int64_t>(m_nodes.count[1]);
    const std::int64_t kind = step / layer * 4 + step % layer / row * 2 + step % row;
    const auto [entry, fresh] = m_cuts.try_emplace(low * 8 + kind, static_cast<int>(m_mesh.vertices.size()));
    if (fresh) {
      const double t = std::clamp(value_a / (value_a - value_b), shortest_cut, 1.0 - shortest_cut);
      m_mesh.vertices.push_back((1.0 - t) * position_m(a) + t * position_m(b));
    }
    return entry->second;
  }

  const Field& m_field;
  Vec3 m_lower_m;
  double m_cell_m;
  std::array<int, 3> m_blocks{};
  GridIndex m_nodes;
  std::array<bool, block_parts * block_parts * block_parts> m_may_cross{};  ///< parts of the block that is marched
  std::unordered_map<std::int64_t, double> m_values;
  std::unordered_map<std::int64_t, int> m_cuts;
  TriangleMesh m_mesh;
};

int find_root(std::vector<int>& parent, int i) {
  while (parent[static_cast<std::size_t>(i)] != i) {
    auto& above = parent[static_cast<std::size_t>(i)];
    above = parent[static_cast<std::size_t>(above)];
    i = above;
  }
  return i;
}

}  // namespace

TriangleMesh extract_isosurface(const Field& field, const Vec3& lower_m, const Vec3& upper_m, double cell_m) {
  return Marcher(field, lower_m, upper_m, cell_m).run();
}

TriangleMesh largest_surface(const TriangleMesh& mesh) {
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Triangle& t : mesh.triangles) {
    parent[static_cast<std::size_t>(find_root(parent, t[1]))] = find_root(parent, t[0]);
    parent[static_cast<std::size_t>(find_root(parent, t[2]))] = find_root(parent, t[0]);
  }
  std::vector<int> triangles_of(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    ++triangles_of[static_cast<std::size_t>(find_root(parent, t[0]))];
  }
  const auto largest = std::max_element(triangles_of.begin(), triangles_of.end()) - triangles_of.begin();
  TriangleMesh result;
  std::vector<int> new_index(mesh.vertices.size(), -1);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (find_root(parent, static_cast<int>(v)) == largest) {
      new_index[v] = static_cast<int>(result.vertices.size());
      result.vertices.push_back(mesh.vertices[v]);
    }
  }
  for (const Triangle& t : mesh.triangles) {
    const auto renamed = [&](int v) { return new_index[static_cast<std::size_t>(v)]; };
    if (renamed(t[0]) >= 0) {
      result.triangles.push_back({renamed(t[0]), renamed(t[1]), renamed(t[2])});
    }
  }
  return result;
}

}  // namespace musclebench

#include "backends/sdf/files/discregrid_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/build/cell_signs.hpp"
#include "backends/sdf/files/sealed_file.hpp"

namespace musclebench {

namespace {

using Index = GridIndex::Coordinates;
using CellNodes = std::array<std::uint32_t, 32>;

constexpr std::uint32_t most_cells = 4096;  ///< along an axis
constexpr double no_value = std::numeric_limits<double>::max();
constexpr double most_m = std::numeric_limits<float>::max();  ///< that a field keeps
constexpr std::uint32_t no_cell = std::numeric_limits<std::uint32_t>::max();

/// The numbers of a grid's nodes in the file: vertices, x fastest; then, two and two, the nodes of the edges along x,
/// along y and along z. Edges along an axis follow each other along it first; then along x, y, z the next of the axes
/// in turn is y, z, x, and the one before it comes last.
class NodeNumbers {
 public:
  explicit NodeNumbers(const GridShape& shape) : m_vertices(shape.vertex_grid()), m_cells(shape.cell_grid().count) {
    m_first_edge[0] = m_vertices.size();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t edges = m_cells[axis] * (m_cells[(axis + 1) % 3] + 1) * (m_cells[(axis + 2) % 3] + 1);
      (axis < 2 ? m_first_edge[axis + 1] : m_count) = m_first_edge[axis] + 2 * edges;
    }
  }

  [[nodiscard]] std::size_t count() const { return m_count; }
  [[nodiscard]] std::size_t vertex(const Index& at) const { return m_vertices.index(at); }
  /// The node at the first third of the edge that leaves a vertex along an axis; the one at the second follows it.
  [[nodiscard]] std::size_t edge(const Index& at, std::size_t axis) const {
    const std::size_t next = axis == 0 ? 1 : (axis == 1 ? 2 : 0);
    const std::size_t last = 3 - axis - next;
    return m_first_edge[axis] + 2 * ((at[last] * (m_cells[next] + 1) + at[next]) * m_cells[axis] + at[axis]);
  }

 private:
  GridIndex m_vertices;
  Index m_cells;
  Index m_first_edge{};
  std::size_t m_count = 0;
};

/// Calls visit(number in the cell, vertex, axis or 3 for a corner, third) for the 32 nodes of a cell, in the file's
/// order: corners, x fastest; edges along x, y, z, each four by four with the axis that is stepped first: z for edges
/// along x, x for those along y, y for those along z.
template <typename Visit>
void for_each_node_of_cell(const Index& cell, const Visit& visit) {
  std::size_t number = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    visit(number++, Index{cell[0] + (corner & 1U), cell[1] + (corner >> 1 & 1U), cell[2] + (corner >> 2)}, 3, 0);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t fast = (axis + 2) % 3;
    const std::size_t slow = (axis + 1) % 3;
    for (std::size_t edge = 0; edge < 4; ++edge) {
      Index start = cell;
      start[fast] += edge & 1U;
      start[slow] += edge >> 1;
      visit(number++, start, axis, 0);
      visit(number++, start, axis, 1);
    }
  }
}

std::size_t offset_of(const CubicField& field, const Index& at, std::size_t axis, std::size_t third) {
  return field.shape().record(at[0], at[1], at[2]) + (axis == 3 ? 0 : GridShape::edge_offset[axis] + third);
}

std::size_t number_of(const NodeNumbers& numbers, const Index& at, std::size_t axis, std::size_t third) {
  return axis == 3 ? numbers.vertex(at) : numbers.edge(at, axis) + third;
}

template <typename T>
void write(std::ostream& out, const T& value) {
  write_bytes(out, std::as_bytes(std::span(&value, 1)));
}
template <typename T>
void write(std::ostream& out, const std::vector<T>& values) {
  write(out, static_cast<std::uint64_t>(values.size()));
  write_bytes(out, std::as_bytes(std::span(values)));
}

void write_field(const CubicField& field, std::ostream& out) {
  const GridShape& shape = field.shape();
  const NodeNumbers numbers(shape);
  write(out, shape.lower_m);
  write(out, shape.upper_m());
  for (const std::int32_t cells : shape.cells) {
    write(out, static_cast<std::uint32_t>(cells));
  }
  write(out, shape.cell_size_m);
  write(out, Vec3(shape.cell_size_m.cwiseInverse()));
  write(out, static_cast<std::uint64_t>(shape.cell_count()));
  constexpr std::uint64_t fields = 1;
  write(out, fields);

  std::vector<double> values(numbers.count());
  std::vector<CellNodes> cells;
  cells.reserve(shape.cell_count());
  for_each_in({0, 0, 0}, shape.cell_grid().count, [&](std::size_t i, std::size_t j, std::size_t k) {
    const Index cell{i, j, k};
    CellNodes nodes{};
    for_each_node_of_cell(cell, [&](std::size_t n, const Index& at, std::size_t axis, std::size_t third) {
      const std::size_t number = number_of(numbers, at, axis, third);
      values[number] = field.stored(offset_of(field, at, axis, third));
      nodes[n] = static_cast<std::uint32_t>(number);
    });
    cells.push_back(nodes);
  });
  std::vector<std::uint32_t> map(cells.size());
  for (std::size_t cell = 0; cell < map.size(); ++cell) {
    map[cell] = static_cast<std::uint32_t>(cell);
  }
  write(out, fields);
  write(out, values);
  write(out, fields);
  write(out, cells);
  write(out, fields);
  write(out, map);
}

BinaryReader::Words discregrid_words() {
  return {
      "is truncated or no Discregrid field",
      "make it from this bone's mesh, with Discregrid or `musclebench field`, or leave out `discregrid` to build it "
      "here"};
}

struct Header {
  std::array<double, 3> lower_m{};
  std::array<double, 3> upper_m{};
  std::array<std::uint32_t, 3> cells{};
  std::array<double, 3> cell_size_m{};
  std::array<double, 3> inverse_size{};
  std::uint64_t cell_count = 0;
  std::uint64_t fields = 0;
};

/// Calls visit(value) for everything in a header, in the file's order.
template <typename Visit>
void for_each_part(Header& header, const Visit& visit) {
  visit(header.lower_m);
  visit(header.upper_m);
  visit(header.cells);
  visit(header.cell_size_m);
  visit(header.inverse_size);
  visit(header.cell_count);
  visit(header.fields);
}

/// Whether its numbers fit together: those of another kind of file or another byte order do not.
bool is_sound(const Header& header) {
  constexpr double rounding = 1e-9;
  std::uint64_t cells = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = header.cell_size_m[axis];
    const double width = size * header.cells[axis];
    const bool sound = header.cells[axis] >= 1 && header.cells[axis] <= most_cells && size > 0 &&
                       std::isfinite(width) &&
                       std::abs(header.upper_m[axis] - header.lower_m[axis] - width) <= rounding * width &&
                       std::abs(header.inverse_size[axis] * size - 1) <= rounding;
    if (!sound) {
      return false;
    }
    cells *= header.cells[axis];
  }
  return header.cell_count == cells;
}

Header of_other_byte_order(Header header) {
  for_each_part(header, [](auto& part) {
    const auto reverse = [](auto& number) {
      const auto bytes = std::as_writable_bytes(std::span(&number, 1));
      std::reverse(bytes.begin(), bytes.end());
    };
    if constexpr (std::is_integral_v<std::remove_reference_t<decltype(part)>>) {
      reverse(part);
    } else {
      std::for_each(part.begin(), part.end(), reverse);
    }
  });
  return header;
}

GridShape read_shape(BinaryReader& in) {
  Header header;
  for_each_part(header, [&](auto& part) { part = in.read<std::remove_reference_t<decltype(part)>>(); });
  if (!is_sound(header)) {
    in.refuse(is_sound(of_other_byte_order(header))
                  ? "was written on a machine of another byte order"
                  : "is no Discregrid field: its domain, cells and their size do not fit together");
  }
  if (header.fields == 0) {
    in.refuse("holds no field");
  }
  GridShape shape;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    shape.lower_m[static_cast<Eigen::Index>(axis)] = header.lower_m[axis];
    shape.cell_size_m[static_cast<Eigen::Index>(axis)] = header.cell_size_m[axis];
    shape.cells[axis] = static_cast<std::int32_t>(header.cells[axis]);
  }
  return shape;
}

/// The first of as many lists as there are fields; the others are skipped.
template <typename T>
std::vector<T> read_first(BinaryReader& in) {
  const auto lists = in.read<std::uint64_t>();
  if (lists == 0) {
    in.refuse("holds no field");
  }
  std::vector<T> first = in.read_all<T>(in.read<std::uint64_t>());
  for (std::uint64_t list = 1; list < lists; ++list) {
    (void)in.read_all<T>(in.read<std::uint64_t>());
  }
  return first;
}

void store_nodes(const BinaryReader& in, const std::vector<double>& values, const std::vector<CellNodes>& cells,
                 const std::vector<std::uint32_t>& map, CubicField& field) {
  const GridShape& shape = field.shape();
  const NodeNumbers numbers(shape);
  std::vector<double> known(numbers.count(), no_value);
  for_each_in({0, 0, 0}, shape.cell_grid().count, [&](std::size_t i, std::size_t j, std::size_t k) {
    const Index cell{i, j, k};
    const CellNodes& nodes = cells[map[shape.cell(i, j, k)]];
    for_each_node_of_cell(cell, [&](std::size_t n, const Index& at, std::size_t axis, std::size_t third) {
      const double value = nodes[n] < values.size() ? values[nodes[n]] : std::nan("");
      if (!std::isfinite(value) || value == no_value) {
        in.refuse(fmt::format("has no value at a node of cell {} {} {}", cell[0], cell[1], cell[2]));
      }
      if (std::abs(value) > most_m) {
        in.refuse(fmt::format("is damaged: a node of cell {} {} {} holds {:.3g} m", cell[0], cell[1], cell[2], value));
      }
      double& in_neighbours = known[number_of(numbers, at, axis, third)];
      if (in_neighbours != no_value && in_neighbours != value) {
        in.refuse(fmt::format("is damaged: cell {} {} {} and its neighbour disagree about a node that they share",
                              cell[0], cell[1], cell[2]));
      }
      in_neighbours = value;
      field.store(offset_of(field, at, axis, third), value);
    });
  });
}

}  // namespace

void write_discregrid(const CubicField& field, const std::filesystem::path& path) {
  write_atomically(path, [&](std::ostream& out) { write_field(field, out); });
}

CubicField read_discregrid(const std::filesystem::path& path, int threads) {
  BinaryReader in(path, discregrid_words());
  const GridShape shape = read_shape(in);
  const auto values = read_first<double>(in);
  const auto cells = read_first<CellNodes>(in);
  const auto map = read_first<std::uint32_t>(in);
  in.require_end();
  const auto lacking = std::count(map.begin(), map.end(), no_cell);
  if (map.size() != shape.cell_count() || lacking > 0) {
    in.refuse(fmt::format("is a reduced field that lacks {} of {} cells; a whole one is needed", lacking,
                          shape.cell_count()));
  }
  if (std::any_of(map.begin(), map.end(), [&](std::uint32_t cell) { return cell >= cells.size(); })) {
    in.refuse("is damaged: it refers to cells that it does not hold");
  }
  CubicField field(shape);
  store_nodes(in, values, cells, map, field);
  find_cell_signs(field, threads);
  return field;
}

}  // namespace musclebench

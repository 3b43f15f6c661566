#include "backends/sdf/node_distances.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <thread>

#include "backends/sdf/packet_search.hpp"

namespace musclebench {

namespace {

/// Rows of the grid that one thread takes at a time, along y and z.
constexpr std::size_t chunk_rows = 4;

/// Of the six nodes on the edges that leave a grid vertex.
constexpr std::array<std::size_t, 6> edge_axis{1, 1, 2, 2, 0, 0};

using Index = std::array<std::size_t, 3>;

/// The nodes of one record, its own vertex first.
struct Record {
  std::size_t count = 0;
  std::array<std::size_t, GridShape::record_size> offset;
  std::array<Vec3, GridShape::record_size> point;

  void add(std::size_t at, const Vec3& position) {
    offset[count] = at;
    point[count++] = position;
  }
};

/// Whether a cell that is known has this edge.
bool has_cell_at_edge(const CubicField& field, const Index& vertex, std::size_t axis) {
  const GridShape& shape = field.shape();
  if (vertex[axis] >= shape.count(axis)) {
    return false;
  }
  if (!field.band()) {
    return true;
  }
  const std::size_t p = (axis + 1) % 3;
  const std::size_t q = (axis + 2) % 3;
  for (const std::size_t down : {0, 1, 2, 3}) {
    const std::size_t down_p = down % 2;
    const std::size_t down_q = down / 2;
    if (vertex[p] < down_p || vertex[q] < down_q) {
      continue;
    }
    Index cell = vertex;
    cell[p] -= down_p;
    cell[q] -= down_q;
    if (cell[p] < shape.count(p) && cell[q] < shape.count(q) && field.knows(shape.cell(cell[0], cell[1], cell[2]))) {
      return true;
    }
  }
  return false;
}

Record nodes_of_record(const CubicField& field, const Index& vertex) {
  const GridShape& shape = field.shape();
  const Vec3 cells(static_cast<double>(vertex[0]), static_cast<double>(vertex[1]), static_cast<double>(vertex[2]));
  const auto position = [&](const Vec3& place) { return Vec3(shape.lower_m + shape.cell_size_m.cwiseProduct(place)); };
  Record record;
  record.add(0, position(cells));
  for (std::size_t edge_node = 0; edge_node < edge_axis.size(); ++edge_node) {
    const std::size_t axis = edge_axis[edge_node];
    if (has_cell_at_edge(field, vertex, axis)) {
      Vec3 place = cells;
      place[static_cast<Eigen::Index>(axis)] += static_cast<double>(1 + edge_node % 2) / 3;
      record.add(edge_node + 1, position(place));
    }
  }
  return record;
}

/// Walks over the grid vertices of one chunk and remembers the last one: its closest triangle starts the next search,
/// and a node that is farther from the surface than from a signed node lies on the same side.
class NodeWalk {
 public:
  NodeWalk(const SignedSurface& surface, CubicField& field)
      : m_surface(surface), m_search(surface.tree()), m_field(field) {}

  void visit(const Index& vertex) {
    const std::optional<std::size_t> place = m_field.record(vertex[0], vertex[1], vertex[2]);
    if (!place) {
      return;
    }
    const Record record = nodes_of_record(m_field, vertex);
    if (m_last.closest.triangle < 0) {
      m_last.point = record.point[0];
      m_last.closest = m_surface.tree().closest_point(m_last.point).value();
      m_last.inside = m_surface.is_inside(m_last.point, m_last.closest);
    }
    std::array<ClosestPoint, GridShape::record_size> closest;
    m_search.closest_points({record.point.data(), record.count}, m_last.closest.triangle, closest);
    for (std::size_t n = 0; n < record.count; ++n) {
      const Node node{record.point[n], closest[n], is_inside(record.point[n], closest[n])};
      m_field.store(*place + record.offset[n], node.inside ? -node.closest.distance_m : node.closest.distance_m);
      if (n == 0) {
        m_last = node;  // the others of the record are next to it, too
      }
    }
  }

 private:
  struct Node {
    Vec3 point = Vec3::Zero();
    ClosestPoint closest;
    bool inside = false;
  };

  [[nodiscard]] bool is_inside(const Vec3& point, const ClosestPoint& closest) const {
    const double step = (point - m_last.point).norm() * (1 + 1e-9);
    return std::max(closest.distance_m, m_last.closest.distance_m) > step ? m_last.inside
                                                                          : m_surface.is_inside(point, closest);
  }

  const SignedSurface& m_surface;
  PacketSearch m_search;
  CubicField& m_field;
  Node m_last;
};

/// There and back along the rows of one chunk.
void fill_chunk(const SignedSurface& surface, std::size_t first_j, std::size_t first_k, CubicField& field) {
  const GridShape& shape = field.shape();
  const std::size_t end_j = std::min(first_j + chunk_rows, shape.count(1) + 1);
  const std::size_t end_k = std::min(first_k + chunk_rows, shape.count(2) + 1);
  NodeWalk walk(surface, field);
  bool forward = true;
  for (std::size_t k = first_k; k < end_k; ++k) {
    for (std::size_t step = first_j; step < end_j; ++step) {
      const std::size_t j = (k - first_k) % 2 == 0 ? step : first_j + end_j - 1 - step;
      for (std::size_t column = 0; column <= shape.count(0); ++column) {
        walk.visit({forward ? column : shape.count(0) - column, j, k});
      }
      forward = !forward;
    }
  }
}

}  // namespace

void fill_distances(const SignedSurface& surface, CubicField& field, [[maybe_unused]] int threads,
                    const std::function<void(double)>& progress) {
  const std::size_t across = field.shape().count(1) / chunk_rows + 1;
  const std::size_t chunks = across * (field.shape().count(2) / chunk_rows + 1);
  const std::thread::id reporter = std::this_thread::get_id();
  std::atomic<std::size_t> done = 0;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    fill_chunk(surface, chunk_rows * (chunk % across), chunk_rows * (chunk / across), field);
    ++done;
    if (progress && std::this_thread::get_id() == reporter) {
      progress(static_cast<double>(done) / static_cast<double>(chunks));
    }
  }
}

}  // namespace musclebench

#include "backends/sdf/build/node_distances.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>
#include <vector>

#include "core/bvh/batch/batched_closest_point.hpp"

namespace musclebench {

namespace {

/// Grid vertices along the edge of a block, which are searched for together.
constexpr std::size_t block_edge = 4;
constexpr std::size_t block_size = block_edge * block_edge * block_edge;

/// Of the three edges that leave a grid vertex, in the order of their nodes in its record.
constexpr std::array<std::size_t, 3> edge_axis{1, 2, 0};

/// Offsets of the nodes of a record from its vertex, in thirds of a cell.
constexpr std::array<std::array<std::size_t, 3>, GridShape::record_size> thirds_away{
    {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 0, 1}, {0, 0, 2}, {1, 0, 0}, {2, 0, 0}}};

using Index = GridIndex::Coordinates;

/// Positions of the nodes of one record.
struct Record {
  std::size_t begin = 0;
  std::array<std::size_t, GridShape::record_size> offset;
};

/// Three numbers of two bits each, whose bits alternate in `number`: those that follow each other are close together.
Index coordinates_in_block(std::size_t number) {
  Index at{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    at[axis] = (number >> axis & 1U) + 2 * (number >> (axis + 3) & 1U);
  }
  return at;
}

/// Fills block after block, warm-started by the last node: its closest triangle starts the next search, and a node that
/// is farther from the surface than from a node with a known sign lies on the same side.
class NodeWalk {
 public:
  NodeWalk(const SignedSurface& surface, CubicField& field)
      : m_surface(surface), m_search(surface.tree()), m_field(field), m_batches(block_size) {
    const GridShape& shape = field.shape();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      for (std::size_t third = 0; third < 3 * (shape.count(axis) + 1); ++third) {
        const double cells =
            shape.first_cell()[a] + static_cast<double>(third / 3) + static_cast<double>(third % 3) / 3;
        m_coordinate[axis].push_back(shape.lower_m[a] + shape.cell_size_m[a] * cells);
      }
    }
  }

  /// Resets the warm start, so that results do not depend on which blocks a thread filled before.
  void reset_warm_start() { m_has_signed_node = false; }

  void fill_block(const Index& first) {
    m_box.setEmpty();
    for (std::size_t number = 0; number < block_size; ++number) {
      const Index at = coordinates_in_block(number);
      m_batches[number].count = 0;
      add_record({first[0] + at[0], first[1] + at[1], first[2] + at[2]}, number);
    }
    if (m_box.isEmpty()) {
      return;
    }
    const int last = std::max(m_last.closest.triangle, 0);
    m_search.begin(m_box, m_surface.tree().closest_point_from(m_box.center(), last).triangle);
    m_search.closest_points(m_batches);
    for (std::size_t number = 0; number < block_size; ++number) {
      store(m_batches[number], m_records[number]);
    }
  }

 private:
  struct Node {
    Vec3 point = Vec3::Zero();
    ClosestPoint closest;
    bool inside = false;
  };

  /// Nothing beyond the last vertex.
  void add_record(const Index& vertex, std::size_t number) {
    const GridShape& shape = m_field.shape();
    if (vertex[0] > shape.count(0) || vertex[1] > shape.count(1) || vertex[2] > shape.count(2)) {
      return;
    }
    PointBatch& batch = m_batches[number];
    Record& record = m_records[number];
    record.begin = shape.record(vertex[0], vertex[1], vertex[2]);
    const auto at = [&](std::size_t axis, std::size_t thirds) { return m_coordinate[axis][3 * vertex[axis] + thirds]; };
    const auto add = [&](std::size_t offset) {
      const std::array<std::size_t, 3>& away = thirds_away[offset];
      record.offset[batch.count] = offset;
      batch.add({at(0, away[0]), at(1, away[1]), at(2, away[2])});
    };
    add(0);
    m_box.extend(batch.point[0]);
    for (std::size_t edge = 0; edge < edge_axis.size(); ++edge) {
      const std::size_t axis = edge_axis[edge];
      if (vertex[axis] < shape.count(axis)) {
        add(2 * edge + 1);
        add(2 * edge + 2);
        double& highest = m_box.max()[static_cast<Eigen::Index>(axis)];
        highest = std::max(highest, at(axis, 2));
      }
    }
  }

  void store(const PointBatch& batch, const Record& record) {
    for (std::size_t n = 0; n < batch.count; ++n) {
      const ClosestPoint& closest = batch.closest[n];
      const bool inside = is_inside(batch.point[n], closest);
      m_field.store(record.begin + record.offset[n], inside ? -closest.distance_m : closest.distance_m);
      if (n == 0) {
        m_last = {batch.point[n], closest, inside};  // the others of the record are next to it, too
        m_has_signed_node = true;
      }
    }
  }

  [[nodiscard]] bool is_inside(const Vec3& point, const ClosestPoint& closest) const {
    const double step = (point - m_last.point).norm() * (1 + 1e-9);
    // Across a hole the side changes without a surface.
    const bool sure =
        m_surface.closed() && m_has_signed_node && std::max(closest.distance_m, m_last.closest.distance_m) > step;
    return sure ? m_last.inside : m_surface.is_inside(point, closest);
  }

  const SignedSurface& m_surface;
  BatchedClosestPoint m_search;
  CubicField& m_field;
  std::array<std::vector<double>, 3> m_coordinate;  ///< along each axis: a vertex, the two thirds that follow it
  Eigen::AlignedBox3d m_box;                        ///< of the block's nodes
  std::vector<PointBatch> m_batches;
  std::array<Record, block_size> m_records;
  Node m_last;
  bool m_has_signed_node = false;
};

std::size_t blocks_along(const GridShape& shape, std::size_t axis) { return shape.count(axis) / block_edge + 1; }

}  // namespace

void fill_distances(const SignedSurface& surface, CubicField& field, [[maybe_unused]] int threads,
                    const std::function<void(double)>& progress) {
  const GridShape& shape = field.shape();
  const std::size_t rows_y = blocks_along(shape, 1);
  const std::size_t rows = rows_y * blocks_along(shape, 2);
  const std::thread::id reporter = std::this_thread::get_id();
  std::atomic<std::size_t> done = 0;
#pragma omp parallel num_threads(threads)
  {
    NodeWalk walk(surface, field);
#pragma omp for schedule(dynamic)
    for (std::size_t row = 0; row < rows; ++row) {
      walk.reset_warm_start();
      for (std::size_t x = 0; x < blocks_along(shape, 0); ++x) {
        walk.fill_block({block_edge * x, block_edge * (row % rows_y), block_edge * (row / rows_y)});
      }
      ++done;
      if (progress && std::this_thread::get_id() == reporter) {
        progress(static_cast<double>(done) / static_cast<double>(rows));
      }
    }
  }
}

}  // namespace musclebench

#include "backends/sdf/node_distances.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <thread>

namespace musclebench {

namespace {

/// Rows of the grid that one thread takes at a time, along y and z. Fixed, so that the closest triangles that searches
/// start from, and with them the last bits of the result, do not depend on the number of threads.
constexpr std::size_t chunk_rows = 4;

/// The seven nodes of a record, in an order of short steps: up along x from its first to its last.
struct RecordNode {
  std::size_t offset;
  std::array<double, 3> thirds;
};
constexpr std::array<RecordNode, 7> path{
    {{0, {0, 0, 0}}, {4, {0, 0, 2}}, {3, {0, 0, 1}}, {1, {0, 1, 0}}, {2, {0, 2, 0}}, {5, {1, 0, 0}}, {6, {2, 0, 0}}}};

/// Walks over the nodes of one chunk and remembers the last one: its closest triangle starts the next search, and a
/// node that is farther from the surface than from a signed node lies on the same side.
class NodeWalk {
 public:
  NodeWalk(const SignedSurface& surface, const GridShape& shape, CubicField& field)
      : m_surface(surface), m_shape(shape), m_field(field) {}

  void visit(std::size_t i, std::size_t j, std::size_t k, const RecordNode& node) {
    const std::optional<std::size_t> record = m_field.record(i, j, k);
    const auto exists = [&](std::size_t axis, std::size_t index) {
      return node.thirds[axis] == 0 || index < m_shape.count(axis);
    };
    if (!record || !exists(0, i) || !exists(1, j) || !exists(2, k)) {
      return;
    }
    const Vec3 cells(static_cast<double>(i) + node.thirds[0] / 3, static_cast<double>(j) + node.thirds[1] / 3,
                     static_cast<double>(k) + node.thirds[2] / 3);
    const Vec3 point = m_shape.lower_m + m_shape.cell_size_m.cwiseProduct(cells);
    m_field.store(*record + node.offset, signed_distance(point));
  }

 private:
  double signed_distance(const Vec3& point) {
    const bool first = m_closest.triangle < 0;
    const ClosestPoint closest = first ? m_surface.tree().closest_point(point).value()
                                       : m_surface.tree().closest_point_from(point, m_closest.triangle);
    const double step = (point - m_point).norm() * (1 + 1e-9);
    if (first || std::max(closest.distance_m, m_closest.distance_m) <= step) {
      m_inside = m_surface.is_inside(point, closest);
    }
    m_closest = closest;
    m_point = point;
    return m_inside ? -closest.distance_m : closest.distance_m;
  }

  const SignedSurface& m_surface;
  const GridShape& m_shape;
  CubicField& m_field;
  ClosestPoint m_closest;
  Vec3 m_point = Vec3::Zero();
  bool m_inside = false;
};

/// There and back along the rows of one chunk.
void fill_chunk(const SignedSurface& surface, std::size_t first_j, std::size_t first_k, CubicField& field) {
  const GridShape& shape = field.shape();
  const std::size_t end_j = std::min(first_j + chunk_rows, shape.count(1) + 1);
  const std::size_t end_k = std::min(first_k + chunk_rows, shape.count(2) + 1);
  NodeWalk walk(surface, shape, field);
  bool forward = true;
  for (std::size_t k = first_k; k < end_k; ++k) {
    for (std::size_t step = first_j; step < end_j; ++step) {
      const std::size_t j = (k - first_k) % 2 == 0 ? step : first_j + end_j - 1 - step;
      for (std::size_t column = 0; column <= shape.count(0); ++column) {
        const std::size_t i = forward ? column : shape.count(0) - column;
        for (std::size_t n = 0; n < path.size(); ++n) {
          walk.visit(i, j, k, path[n]);
        }
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

#include "core/fibres/muscle_fibres.hpp"

#include <algorithm>
#include <atomic>

#include <Eigen/Geometry>

#include "core/base/input_error.hpp"
#include "core/base/parallel_chunks.hpp"
#include "core/fibres/mean_value_coordinates.hpp"

namespace musclebench {

namespace {

/// Of a point of the triangle; all of the first corner's where the triangle has no area.
Vec3 barycentric_weights(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double squared_area = normal.squaredNorm();
  if (!(squared_area > 0)) return Vec3::UnitX();
  const double of_b = normal.dot((c - point).cross(a - point)) / squared_area;
  const double of_c = normal.dot((a - point).cross(b - point)) / squared_area;
  return {1 - of_b - of_c, of_b, of_c};
}

}  // namespace

MuscleFibres::MuscleFibres(const TriangleMesh& muscle, const FibrePaths& paths, const std::string& name, int threads)
    : m_count(paths.fibres.size()),
      m_points_per_fibre(paths.fibres.empty() ? 0 : paths.fibres.front().points.size()),
      m_nodes(muscle.vertices.size()),
      m_threads(threads) {
  std::vector<Vec3> inner;
  for (const FibrePath& fibre : paths.fibres) {
    for (const auto& [triangle, point] : {std::pair(fibre.origin_triangle, fibre.points.front()),
                                          std::pair(fibre.insertion_triangle, fibre.points.back())}) {
      const Triangle& nodes = muscle.triangles[static_cast<std::size_t>(triangle)];
      const auto corner = [&](std::size_t i) { return muscle.vertices[static_cast<std::size_t>(nodes[i])]; };
      m_ends.push_back({nodes, barycentric_weights(point, corner(0), corner(1), corner(2))});
    }
    inner.insert(inner.end(), fibre.points.begin() + 1, fibre.points.end() - 1);
  }
  m_weights.resize(inner.size() * m_nodes);
  std::atomic<bool> all_bound = true;
  for_each_chunk(inner.size(), 1, threads, [&](std::size_t point, std::size_t /*first*/, std::size_t /*last*/) {
    const std::vector<double> weights = mean_value_coordinates(muscle, inner[point]);
    if (weights.empty()) {
      all_bound = false;
      return;
    }
    std::copy(weights.begin(), weights.end(), m_weights.begin() + static_cast<std::ptrdiff_t>(point * m_nodes));
  });
  if (!all_bound) {
    throw InputError(name, "has fibres where its surface does not span space; give a surface that encloses a volume");
  }
}

std::vector<Vec3> MuscleFibres::points(std::span<const Vec3> nodes) const {
  std::vector<Vec3> points(m_count * m_points_per_fibre);
  const std::size_t inner = m_points_per_fibre - 2;
  for_each_chunk(m_count, 1, m_threads, [&](std::size_t fibre, std::size_t /*first*/, std::size_t /*last*/) {
    const std::size_t first = fibre * m_points_per_fibre;
    for (const std::size_t end : {std::size_t{0}, std::size_t{1}}) {
      const EndPoint& bound = m_ends[2 * fibre + end];
      Vec3& point = points[first + end * (m_points_per_fibre - 1)];
      point = Vec3::Zero();
      for (int corner = 0; corner < 3; ++corner) {
        point += bound.weights[corner] * nodes[static_cast<std::size_t>(bound.nodes[static_cast<std::size_t>(corner)])];
      }
    }
    for (std::size_t i = 0; i < inner; ++i) {
      const double* weights = m_weights.data() + (fibre * inner + i) * m_nodes;
      Vec3 point = Vec3::Zero();
      for (std::size_t node = 0; node < m_nodes; ++node) point += weights[node] * nodes[node];
      points[first + 1 + i] = point;
    }
  });
  return points;
}

std::vector<double> MuscleFibres::lengths(std::span<const Vec3> points) const {
  std::vector<double> lengths(m_count, 0.0);
  for (std::size_t fibre = 0; fibre < m_count; ++fibre) {
    for (std::size_t i = 1; i < m_points_per_fibre; ++i) {
      const std::size_t at = fibre * m_points_per_fibre + i;
      lengths[fibre] += (points[at] - points[at - 1]).norm();
    }
  }
  return lengths;
}

std::size_t MuscleFibres::bytes() const {
  return m_weights.capacity() * sizeof(double) + m_ends.capacity() * sizeof(EndPoint);
}

}  // namespace musclebench

#include "core/signed_distance/ray_winding.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// Planes of triangles nearer to a point than this, over the diagonal of the surface, are left to a slower method.
constexpr double uncertain_share = 1e-9;
constexpr std::size_t most_bins = 256;

Eigen::AlignedBox3d box_of(const TriangleMesh& mesh, const Triangle& triangle) {
  Eigen::AlignedBox3d box;
  for (const int vertex : triangle) box.extend(mesh.vertices[static_cast<std::size_t>(vertex)]);
  return box;
}

/// Whether the box meets what `points` sweeps along +w or -w.
bool is_before(const Eigen::AlignedBox3d& box, const Eigen::AlignedBox3d& points, int w, double sign) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool ends_below = box.max()[axis] < points.min()[axis] && !(axis == w && sign < 0);
    const bool begins_above = box.min()[axis] > points.max()[axis] && !(axis == w && sign > 0);
    if (ends_below || begins_above) return false;
  }
  return true;
}

/// By axis and sign: the direction along which the fewest vertices are before the box of points.
int shortest_way_out(const TriangleMesh& mesh, const Eigen::AlignedBox3d& points) {
  std::array<std::size_t, 6> before{};
  for (const Vec3& vertex : mesh.vertices) {
    std::array<bool, 3> is_below{};
    std::array<bool, 3> is_above{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      is_below[axis] = vertex[a] < points.min()[a];
      is_above[axis] = vertex[a] > points.max()[a];
    }
    for (std::size_t w = 0; w < 3; ++w) {
      const std::size_t u = (w + 1) % 3;
      const std::size_t v = (w + 2) % 3;
      if (is_below[u] || is_above[u] || is_below[v] || is_above[v]) continue;
      before[2 * w] += is_below[w] ? 0 : 1;
      before[2 * w + 1] += is_above[w] ? 0 : 1;
    }
  }
  return static_cast<int>(std::min_element(before.begin(), before.end()) - before.begin());
}

/// How often, and in which direction, the outline of a triangle in the plane goes round a point: 1, 0 or -1. An edge is
/// judged by the same operations for both triangles at it, so that a point never falls between them or into both.
int winding_in_plane(const std::array<std::array<double, 2>, 3>& corners, double u, double v) {
  int winding = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& from = corners[k];
    const auto& to = corners[(k + 1) % 3];
    const bool from_below = from[1] <= v;
    if (from_below == (to[1] <= v)) continue;
    const auto& low = from_below ? from : to;
    const auto& high = from_below ? to : from;
    const double side = (low[0] - u) * (high[1] - v) - (high[0] - u) * (low[1] - v);
    if (side > 0) winding += from_below ? 1 : -1;
  }
  return winding;
}

}  // namespace

RayWinding::RayWinding(const TriangleMesh& mesh, const Eigen::AlignedBox3d& points)
    : m_mesh(mesh),
      m_frame(frame_of(shortest_way_out(mesh, points))),
      m_uncertain_m(uncertain_share * bounding_box(mesh.vertices).diagonal().norm()),
      m_lower(points.min()) {
  struct Before {
    int triangle;
    Eigen::AlignedBox3d box;
  };
  std::vector<Before> before;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::AlignedBox3d box = box_of(mesh, mesh.triangles[t]);
    if (is_before(box, points, m_frame.w, m_frame.sign)) before.push_back({static_cast<int>(t), box});
  }
  const auto count = static_cast<double>(before.size());
  m_bins = std::clamp<std::size_t>(static_cast<std::size_t>(std::sqrt(count)), 1, most_bins);
  m_per_bin = points.sizes() / static_cast<double>(m_bins);

  m_first.assign(m_bins * m_bins + 1, 0);
  const auto for_each_bin = [&](const auto& visit) {
    for (const auto& [triangle, box] : before) {
      const auto bin = [this](const Vec3& at, int axis) { return bin_along(at[axis], m_lower[axis], m_per_bin[axis]); };
      const std::size_t last_row = bin(box.max(), m_frame.v);
      const std::size_t last_column = bin(box.max(), m_frame.u);
      for (std::size_t row = bin(box.min(), m_frame.v); row <= last_row; ++row) {
        for (std::size_t column = bin(box.min(), m_frame.u); column <= last_column; ++column) {
          visit(row * m_bins + column, triangle);
        }
      }
    }
  };
  for_each_bin([&](std::size_t bin, int /*triangle*/) { ++m_first[bin + 1]; });
  for (std::size_t bin = 0; bin < m_bins * m_bins; ++bin) m_first[bin + 1] += m_first[bin];
  m_triangles.resize(m_first.back());
  std::vector<std::uint32_t> next(m_first.begin(), m_first.end() - 1);
  for_each_bin([&](std::size_t bin, int triangle) { m_triangles[next[bin]++] = triangle; });
}

RayWinding::Frame RayWinding::frame_of(int direction) {
  const int w = direction / 2;
  return {(w + 1) % 3, (w + 2) % 3, w, direction % 2 == 0 ? 1.0 : -1.0};
}

std::size_t RayWinding::bin_along(double value, double lower, double per_bin) const {
  const double bin = per_bin > 0 ? (value - lower) / per_bin : 0;
  return static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(m_bins - 1)));
}

std::optional<int> RayWinding::at(const Vec3& point) const {
  const auto [u, v, w, sign] = m_frame;
  const std::size_t bin =
      bin_along(point[v], m_lower[v], m_per_bin[v]) * m_bins + bin_along(point[u], m_lower[u], m_per_bin[u]);
  int winding = 0;
  for (std::uint32_t i = m_first[bin]; i < m_first[bin + 1]; ++i) {
    const Triangle& triangle = m_mesh.triangles[static_cast<std::size_t>(m_triangles[i])];
    std::array<std::array<double, 2>, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& vertex = m_mesh.vertices[static_cast<std::size_t>(triangle[k])];
      corners[k] = {vertex[u], vertex[v]};
    }
    const int round = winding_in_plane(corners, point[u], point[v]);
    if (round == 0) continue;
    const Vec3& a = m_mesh.vertices[static_cast<std::size_t>(triangle[0])];
    const Vec3& b = m_mesh.vertices[static_cast<std::size_t>(triangle[1])];
    const Vec3& c = m_mesh.vertices[static_cast<std::size_t>(triangle[2])];
    const Vec3 normal = (b - a).cross(c - a);
    const double to_plane = normal.dot(a - point);  // times the normal's length
    if (!(std::abs(to_plane) > m_uncertain_m * normal.norm()) || (normal[w] > 0) != (round > 0)) return std::nullopt;
    if (sign * to_plane * normal[w] > 0) winding += normal[w] * sign > 0 ? 1 : -1;  // on the ray's side of the point
  }
  return winding;
}

}  // namespace musclebench

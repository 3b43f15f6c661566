#include "core/mesh/morton_order.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace musclebench {

namespace {

constexpr unsigned bits_per_axis = 10;

/// The lowest ten bits of `index`, two zeros between each.
std::uint32_t spread_bits(std::uint32_t index) {
  index = (index | index << 16U) & 0x030000ffU;
  index = (index | index << 8U) & 0x0300f00fU;
  index = (index | index << 4U) & 0x030c30c3U;
  return (index | index << 2U) & 0x09249249U;
}

/// Morton code of coordinates in [0, 1]: the bits of the three cell indices interleaved.
std::uint32_t morton_code(const Vec3& relative) {
  constexpr double cells = 1U << bits_per_axis;
  std::uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::min(cells * relative[axis], cells - 1);
    code |= spread_bits(cell > 0 ? static_cast<std::uint32_t>(cell) : 0) << static_cast<unsigned>(axis);
  }
  return code;
}

/// Least significant digit first, as many passes as a code has digits: in linear time, equal codes stay in order.
std::vector<int> sorted_by_code(const std::vector<std::uint32_t>& codes) {
  constexpr unsigned digit_bits = bits_per_axis;
  constexpr std::size_t digits = 1U << digit_bits;
  std::vector<int> order(codes.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<int> sorted(codes.size());
  for (unsigned shift = 0; shift < 3 * bits_per_axis; shift += digit_bits) {
    const auto digit_of = [&](int index) { return codes[static_cast<std::size_t>(index)] >> shift & (digits - 1); };
    std::array<std::size_t, digits + 1> next{};
    for (const int index : order) ++next[digit_of(index) + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (const int index : order) sorted[next[digit_of(index)]++] = index;
    order.swap(sorted);
  }
  return order;
}

}  // namespace

std::vector<int> morton_order(std::span<const Vec3> points) {
  std::vector<int> original(points.size());
  std::iota(original.begin(), original.end(), 0);
  Eigen::AlignedBox3d box;
  for (const Vec3& point : points) {
    if (point.allFinite()) {
      box.extend(point);
    }
  }
  const double extent = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  if (!(extent > 0 && std::isfinite(extent))) {
    return original;
  }
  std::vector<std::uint32_t> codes;
  codes.reserve(points.size());
  for (const Vec3& point : points) {
    codes.push_back(point.allFinite() ? morton_code((point - box.min()) / extent) : 0);
  }
  std::vector<int> along_curve = sorted_by_code(codes);
  const auto path_length = [&](const std::vector<int>& order) {
    double sum = 0;
    for (std::size_t i = 1; i < order.size(); ++i) {
      const Vec3& from = points[static_cast<std::size_t>(order[i - 1])];
      const double step = ((points[static_cast<std::size_t>(order[i])] - from) / extent).norm();
      sum += std::isfinite(step) ? step : 0;
    }
    return sum;
  };
  return path_length(along_curve) < path_length(original) ? along_curve : original;
}

void sort_in_morton_order(TriangleMesh& mesh) {
  const auto corner = [&](const Triangle& triangle, std::size_t i) -> Vec3& {
    return mesh.vertices[static_cast<std::size_t>(triangle[i])];
  };
  std::vector<Vec3> middles;
  middles.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    middles.push_back((corner(triangle, 0) + corner(triangle, 1) + corner(triangle, 2)) / 3);
  }
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const int index : morton_order(middles)) {
    triangles.push_back(mesh.triangles[static_cast<std::size_t>(index)]);
  }
  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  std::vector<int> new_index(mesh.vertices.size(), -1);
  const auto take = [&](std::size_t vertex) {
    if (new_index[vertex] < 0) {
      new_index[vertex] = static_cast<int>(vertices.size());
      vertices.push_back(mesh.vertices[vertex]);
    }
    return new_index[vertex];
  };
  for (Triangle& triangle : triangles) {
    for (int& vertex : triangle) {
      vertex = take(static_cast<std::size_t>(vertex));
    }
  }
  for (std::size_t vertex = 0; vertex < mesh.vertices.size(); ++vertex) {
    take(vertex);  // those that no triangle uses
  }
  mesh = {std::move(vertices), std::move(triangles)};
}

}  // namespace musclebench

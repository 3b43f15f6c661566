#include "core/mesh/morton_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

namespace musclebench {

namespace {

constexpr int bits_an_axis = 10;

/// The bits of three coordinates in turn.
std::uint32_t place_on_curve(const Vec3& share) {
  constexpr double cells = 1U << static_cast<unsigned>(bits_an_axis);
  std::uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::min(cells * share[axis], cells - 1);
    const std::uint32_t number = cell > 0 ? static_cast<std::uint32_t>(cell) : 0;
    for (int bit = 0; bit < bits_an_axis; ++bit) {
      code |= (number >> bit & 1U) << (3 * bit + axis);
    }
  }
  return code;
}

}  // namespace

std::vector<int> morton_order(std::span<const Vec3> points) {
  std::vector<int> as_they_are(points.size());
  std::iota(as_they_are.begin(), as_they_are.end(), 0);
  Eigen::AlignedBox3d box;
  for (const Vec3& point : points) {
    if (point.allFinite()) {
      box.extend(point);
    }
  }
  const double extent = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  if (!(extent > 0 && std::isfinite(extent))) {
    return as_they_are;
  }
  std::vector<std::pair<std::uint32_t, int>> by_code;
  by_code.reserve(points.size());
  for (const int place : as_they_are) {
    const Vec3& point = points[static_cast<std::size_t>(place)];
    by_code.emplace_back(point.allFinite() ? place_on_curve((point - box.min()) / extent) : 0, place);
  }
  std::sort(by_code.begin(), by_code.end());
  std::vector<int> along_curve;
  along_curve.reserve(points.size());
  for (const auto& [code, place] : by_code) {
    along_curve.push_back(place);
  }
  const auto way = [&](const std::vector<int>& order) {
    double sum = 0;
    for (std::size_t i = 1; i < order.size(); ++i) {
      const Vec3& from = points[static_cast<std::size_t>(order[i - 1])];
      const double step = ((points[static_cast<std::size_t>(order[i])] - from) / extent).norm();
      sum += std::isfinite(step) ? step : 0;
    }
    return sum;
  };
  return way(along_curve) < way(as_they_are) ? along_curve : as_they_are;
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
  for (const int place : morton_order(middles)) {
    triangles.push_back(mesh.triangles[static_cast<std::size_t>(place)]);
  }
  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  std::vector<int> number(mesh.vertices.size(), -1);
  const auto take = [&](std::size_t vertex) {
    if (number[vertex] < 0) {
      number[vertex] = static_cast<int>(vertices.size());
      vertices.push_back(mesh.vertices[vertex]);
    }
    return number[vertex];
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

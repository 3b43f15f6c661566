#include "datasets/tests/self_intersection.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

namespace musclebench {

namespace {

double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  if ((volume(a, b, c, p) > 0) == (volume(a, b, c, q) > 0)) {
    return false;
  }
  const bool ab = volume(p, q, a, b) > 0;
  return ab == (volume(p, q, b, c) > 0) && ab == (volume(p, q, c, a) > 0);
}

struct Span {
  double low;
  double high;
  int triangle;
};

}  // namespace

int count_self_intersections(const TriangleMesh& mesh) {
  const auto corner = [&](int triangle, int i) -> const Vec3& {
    const auto& t = mesh.triangles[static_cast<std::size_t>(triangle)];
    return mesh.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(i % 3)])];
  };
  std::vector<Span> spans;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
    Eigen::AlignedBox3d box(corner(i, 0));
    box.extend(corner(i, 1)).extend(corner(i, 2));
    boxes.push_back(box);
    spans.push_back({box.min().z(), box.max().z(), i});
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.low < b.low; });
  int count = 0;
  for (std::size_t i = 0; i < spans.size(); ++i) {
    for (std::size_t j = i + 1; j < spans.size() && spans[j].low <= spans[i].high; ++j) {
      const int first = spans[i].triangle;
      const int second = spans[j].triangle;
      const Triangle& one = mesh.triangles[static_cast<std::size_t>(first)];
      const Triangle& other = mesh.triangles[static_cast<std::size_t>(second)];
      const bool neighbours = std::any_of(
          one.begin(), one.end(), [&](int v) { return std::find(other.begin(), other.end(), v) != other.end(); });
      if (neighbours || !boxes[static_cast<std::size_t>(first)].intersects(boxes[static_cast<std::size_t>(second)])) {
        continue;
      }
      for (int edge = 0; edge < 3; ++edge) {
        count += crosses(corner(first, edge), corner(first, edge + 1), corner(second, 0), corner(second, 1),
                         corner(second, 2));
        count += crosses(corner(second, edge), corner(second, edge + 1), corner(first, 0), corner(first, 1),
                         corner(first, 2));
      }
    }
  }
  return count;
}

}  // namespace musclebench

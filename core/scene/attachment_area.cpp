#include "core/scene/attachment_area.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "core/bvh/nearby_triangles.hpp"

namespace musclebench {

namespace {

using Vec2 = Eigen::Vector2d;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Counter-clockwise, without collinear points (Andrew's monotone chain).
std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  std::vector<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const Vec2& point : points) {
      while (hull.size() >= first + 2 && cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// 0 inside.
double distance_to_hull(const std::vector<Vec2>& hull, const Vec2& point) {
  bool inside = hull.size() >= 3;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2& start = hull[i];
    const Vec2 along = hull[(i + 1) % hull.size()] - start;
    inside = inside && cross(along, point - start) >= 0;
    const double length2 = along.squaredNorm();
    const double t = length2 > 0 ? std::clamp((point - start).dot(along) / length2, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (start + t * along - point).norm());
  }
  return inside ? 0 : nearest;
}

struct MeanPlane {
  Vec3 centre;
  Vec3 u, v, normal;
  double extent_m;  ///< largest distance of an outline point from the centre

  explicit MeanPlane(const std::vector<Vec3>& points) : centre(Vec3::Zero()), extent_m(0) {
    for (const Vec3& point : points) {
      centre += point;
    }
    centre /= static_cast<double>(points.size());
    Mat3 covariance = Mat3::Zero();
    for (const Vec3& point : points) {
      covariance += (point - centre) * (point - centre).transpose();
      extent_m = std::max(extent_m, (point - centre).norm());
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance);
    normal = solver.eigenvectors().col(0);
    u = solver.eigenvectors().col(2);
    v = normal.cross(u);
  }

  [[nodiscard]] Vec2 flat(const Vec3& point) const { return {u.dot(point - centre), v.dot(point - centre)}; }
};

/// The area in its mean plane.
class FlatArea {
 public:
  explicit FlatArea(const AttachmentArea& area) : m_plane(area.outline_m) {
    std::vector<Vec2> outline;
    for (const Vec3& point : area.outline_m) {
      outline.push_back(m_plane.flat(point));
    }
    m_hull = convex_hull(outline);
  }

  [[nodiscard]] double distance_off_m(const Vec3& point) const {
    return std::abs(m_plane.normal.dot(point - m_plane.centre));
  }
  [[nodiscard]] bool is_on_its_side(const Vec3& point, double more_m = 0) const {
    return distance_off_m(point) <= m_plane.extent_m + more_m;
  }
  [[nodiscard]] double distance_beside_m(const Vec3& point) const {
    return distance_to_hull(m_hull, m_plane.flat(point));
  }

 private:
  MeanPlane m_plane;
  std::vector<Vec2> m_hull;
};

std::vector<int> nodes_near_outline(std::span<const Vec3> nodes, const FlatArea& flat, const AttachmentArea& area) {
  std::vector<int> bound;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (flat.distance_off_m(nodes[i]) <= area.distance_m && flat.distance_beside_m(nodes[i]) <= area.margin_m) {
      bound.push_back(static_cast<int>(i));
    }
  }
  return bound;
}

std::optional<DistanceToArea> nearest_to_points(std::span<const Vec3> nodes, const AttachmentArea& area) {
  if (nodes.empty()) return std::nullopt;
  double nearest2 = std::numeric_limits<double>::infinity();
  for (const Vec3& node : nodes) {
    for (const Vec3& point : area.outline_m) nearest2 = std::min(nearest2, (point - node).squaredNorm());
  }
  return DistanceToArea{std::sqrt(nearest2), 0};
}

/// Sorted along the longest axis of their box, so that each node is compared with few.
class SortedPoints {
 public:
  explicit SortedPoints(std::vector<Vec3> points) : m_points(std::move(points)) {
    Eigen::AlignedBox3d box;
    for (const Vec3& point : m_points) box.extend(point);
    box.sizes().maxCoeff(&m_axis);
    std::sort(m_points.begin(), m_points.end(),
              [&](const Vec3& one, const Vec3& other) { return one[m_axis] < other[m_axis]; });
  }

  [[nodiscard]] bool is_one_within(const Vec3& node, double distance_m) const {
    const auto first = std::lower_bound(m_points.begin(), m_points.end(), node[m_axis] - distance_m,
                                        [&](const Vec3& point, double at) { return point[m_axis] < at; });
    for (auto point = first; point != m_points.end() && (*point)[m_axis] <= node[m_axis] + distance_m; ++point) {
      if ((*point - node).norm() <= distance_m) return true;
    }
    return false;
  }

 private:
  std::vector<Vec3> m_points;
  int m_axis = 0;
};

std::vector<int> nodes_near_points(std::span<const Vec3> nodes, const AttachmentArea& area) {
  const SortedPoints points(area.outline_m);
  std::vector<int> bound;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (points.is_one_within(nodes[i], area.distance_m)) bound.push_back(static_cast<int>(i));
  }
  return bound;
}

/// Nothing where the node does not count.
std::optional<DistanceToArea> distance_to_area(const Vec3& node, const TriangleBvh& bone, const FlatArea& flat,
                                               AttachmentSurface surface) {
  if (surface == AttachmentSurface::outline) {
    return DistanceToArea{flat.distance_off_m(node), flat.distance_beside_m(node)};
  }
  const auto closest = bone.closest_point(node);
  if (!closest || !flat.is_on_its_side(closest->point)) return std::nullopt;
  return DistanceToArea{closest->distance_m, flat.distance_beside_m(closest->point)};
}

}  // namespace

std::vector<int> nodes_over_area(std::span<const Vec3> nodes, const TriangleMesh& bone, const AttachmentArea& area) {
  if (area.surface == AttachmentSurface::points) return nodes_near_points(nodes, area);
  const FlatArea flat(area);
  if (area.surface == AttachmentSurface::outline) return nodes_near_outline(nodes, flat, area);
  // A node is at most distance_m from its closest point, and so is what it is measured by in the area's plane.
  const double allowed_m = area.distance_m + 1e-9 * (1 + area.distance_m);
  std::vector<int> candidates;
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!flat.is_on_its_side(nodes[i], allowed_m) || !(flat.distance_beside_m(nodes[i]) <= area.margin_m + allowed_m)) {
      continue;
    }
    candidates.push_back(static_cast<int>(i));
    points.push_back(nodes[i]);
  }
  const NearbyTriangles nearby(bone, points, area.distance_m);
  std::vector<int> bound;
  for (const int node : candidates) {
    const auto closest = nearby.closest_point(nodes[static_cast<std::size_t>(node)], area.distance_m);
    if (closest && flat.is_on_its_side(closest->point) && flat.distance_beside_m(closest->point) <= area.margin_m) {
      bound.push_back(node);
    }
  }
  return bound;
}

std::optional<DistanceToArea> nearest_to_area(std::span<const Vec3> nodes, const TriangleBvh& bone,
                                              const AttachmentArea& area) {
  if (area.surface == AttachmentSurface::points) return nearest_to_points(nodes, area);
  const FlatArea flat(area);
  std::optional<DistanceToArea> nearest;
  double least_lack_m = std::numeric_limits<double>::infinity();
  for (const Vec3& node : nodes) {
    const auto distance = distance_to_area(node, bone, flat, area.surface);
    if (!distance) continue;
    const double lack_m = std::hypot(std::max(0.0, distance->to_surface_m - area.distance_m),
                                     std::max(0.0, distance->beside_area_m - area.margin_m));
    if (lack_m < least_lack_m) {
      least_lack_m = lack_m;
      nearest = distance;
    }
  }
  return nearest;
}

}  // namespace musclebench

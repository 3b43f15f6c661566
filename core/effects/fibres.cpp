#include "core/effects/fibres.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace musclebench {

namespace {

double squared_distance_to(const FibreSegment& segment, const Vec3& point) {
  const Vec3 along = segment.end - segment.start;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((point - segment.start).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (segment.start + t * along - point).squaredNorm();
}

Vec3 longest_direction(const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& point : points) {
    mean += point;
  }
  mean /= static_cast<double>(points.size());
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& point : points) {
    covariance += (point - mean) * (point - mean).transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvectors().col(2);
}

std::vector<Vec3> sorted_along(std::vector<Vec3> points, const Vec3& direction) {
  std::stable_sort(points.begin(), points.end(),
                   [&](const Vec3& a, const Vec3& b) { return a.dot(direction) < b.dot(direction); });
  return points;
}

}  // namespace

double alignment_with_nearest_fibre(const std::vector<FibreSegment>& fibres, const Vec3& point, const Vec3& direction) {
  double nearest2 = std::numeric_limits<double>::infinity();
  const FibreSegment* nearest = nullptr;
  for (const FibreSegment& fibre : fibres) {
    const double distance2 = squared_distance_to(fibre, point);
    if (distance2 < nearest2) {
      nearest2 = distance2;
      nearest = &fibre;
    }
  }
  if (nearest == nullptr) {
    return 0;
  }
  const Vec3 along = nearest->end - nearest->start;
  const double lengths = std::sqrt(along.squaredNorm() * direction.squaredNorm());
  return lengths > 0 ? std::min(1.0, std::abs(along.dot(direction)) / lengths) : 0.0;
}

std::vector<FibreSegment> fibres_between(const std::vector<Vec3>& origin, const std::vector<Vec3>& insertion,
                                         int count) {
  if (origin.empty() || insertion.empty()) {
    return {};
  }
  const Vec3 origin_direction = longest_direction(origin);
  Vec3 insertion_direction = longest_direction(insertion);
  if (insertion_direction.dot(origin_direction) < 0) {
    insertion_direction = -insertion_direction;
  }
  const std::vector<Vec3> starts = sorted_along(origin, origin_direction);
  const std::vector<Vec3> ends = sorted_along(insertion, insertion_direction);
  std::vector<FibreSegment> fibres;
  for (int i = 0; i < count; ++i) {
    const double part = (i + 0.5) / count;
    fibres.push_back({starts[static_cast<std::size_t>(part * static_cast<double>(starts.size()))],
                      ends[static_cast<std::size_t>(part * static_cast<double>(ends.size()))]});
  }
  return fibres;
}

}  // namespace musclebench

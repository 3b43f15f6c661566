#include "core/fibres/fibre_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace musclebench {

double alignment_with_nearest_fibre(const std::vector<FibreSegment>& fibres, const Vec3& point, const Vec3& direction) {
  double nearest2 = std::numeric_limits<double>::infinity();
  const FibreSegment* nearest = nullptr;
  for (const FibreSegment& fibre : fibres) {
    const double distance2 = squared_distance(fibre, point);
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

}  // namespace musclebench

#include "core/contact/muscle_contact.hpp"

#include <algorithm>
#include <cmath>

namespace musclebench {

namespace {

/// Of a point of the triangle. Sides that have no length, and heights of none, count as their first corner.
Vec3 weights_of(const Vec3& point, const std::array<Vec3, 3>& corners, Feature feature) {
  if (feature >= Feature::corner_0) {
    return Vec3::Unit(static_cast<Eigen::Index>(feature) - static_cast<Eigen::Index>(Feature::corner_0));
  }
  if (feature == Feature::face) return barycentric(point, corners, Vec3::UnitX());
  const auto from = static_cast<std::size_t>(feature) - static_cast<std::size_t>(Feature::edge_0);
  const std::size_t to = (from + 1) % 3;
  const Vec3 side = corners[to] - corners[from];
  const double squared = side.squaredNorm();
  const double share = squared > 0 ? std::clamp((point - corners[from]).dot(side) / squared, 0.0, 1.0) : 0.0;
  Vec3 weights = Vec3::Zero();
  weights[static_cast<Eigen::Index>(from)] = 1 - share;
  weights[static_cast<Eigen::Index>(to)] = share;
  return weights;
}

}  // namespace

MuscleContact muscle_contact_at(int node, int muscle, const Vec3& point, int triangle,
                                const std::array<Vec3, 3>& corners, const ClosestOnTriangle& closest) {
  const double depth_m = std::sqrt(closest.squared_distance_m2);
  return {node,     muscle,
          triangle, weights_of(closest.point, corners, closest.feature),
          depth_m,  depth_m > 0 ? Vec3((closest.point - point) / depth_m) : Vec3(Vec3::UnitZ())};
}

std::vector<int> muscles_beside(std::span<const MusclePair> pairs, int index) {
  std::vector<int> found;
  for (const MusclePair& pair : pairs) {
    if (pair.first == index) found.push_back(pair.second);
    if (pair.second == index) found.push_back(pair.first);
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::size_t pair_index(std::span<const MusclePair> pairs, int one, int other) {
  const auto found = std::ranges::find(pairs, MusclePair{std::min(one, other), std::max(one, other)});
  return static_cast<std::size_t>(found - pairs.begin());
}

std::vector<PairTime> no_times(std::span<const MusclePair> pairs) {
  std::vector<PairTime> times;
  for (const MusclePair& pair : pairs) times.push_back({pair});
  return times;
}

}  // namespace musclebench

#include "core/measure/depth_limit.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/measure/edge_stretch.hpp"
#include "core/measure/outcome_limits.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {
namespace {

/// The areas of a closed surface sum to nothing as vectors; of one with a small hole nearly so.
constexpr double open_share = 0.05;

/// Takes `share` of `length_m` where that is smaller.
void lower(DepthLimit& limit, double share, double length_m, const std::string& words) {
  if (!(length_m > 0) || !(share * length_m < limit.depth_m)) return;
  limit = {share * length_m, words};
}

DepthLimit limit_of_muscle(const MuscleSize& muscle) {
  DepthLimit limit{std::numeric_limits<double>::infinity(), "unknown"};
  const double edges = outcome_limit("depth_edges");
  const double share = outcome_limit("depth_share");
  lower(limit, edges, muscle.mean_edge_length_m, fmt::format("{:g} mean edge", edges));
  lower(limit, share, muscle.diagonal_m, fmt::format("{:g} % of the muscle's size", 100 * share));
  return limit;
}

}  // namespace

double thickness_m(const TriangleMesh& mesh) {
  double area_m2 = 0;
  Vec3 sum_m2 = Vec3::Zero();
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3& from = mesh.vertices[static_cast<std::size_t>(a)];
    const Vec3 area =
        (mesh.vertices[static_cast<std::size_t>(b)] - from).cross(mesh.vertices[static_cast<std::size_t>(c)] - from) /
        2;
    area_m2 += area.norm();
    sum_m2 += area;
  }
  if (!(area_m2 > 0) || sum_m2.norm() > open_share * area_m2) return 0;
  return 2 * std::abs(surface_volume_m3(mesh.vertices, mesh.triangles)) / area_m2;
}

MuscleSize size_of(const std::string& name, const TriangleMesh& muscle) {
  const auto box = bounding_box(muscle.vertices);
  return {name, EdgeStretchMeter(muscle).mean_length_m(), box.isEmpty() ? 0 : box.diagonal().norm(),
          static_cast<int>(muscle.triangles.size())};
}

DepthLimit depth_limit(const MuscleSize& muscle, const BoneSize& bone) {
  DepthLimit limit = limit_of_muscle(muscle);
  const double share = outcome_limit("thickness_share");
  lower(limit, share, bone.thickness_m, fmt::format("{:g} % of the bone's thickness", 100 * share));
  return limit;
}

DepthLimit depth_limit(const MuscleSize& muscle, const MuscleSize& other) {
  const DepthLimit one = limit_of_muscle(muscle), two = limit_of_muscle(other);
  return two.depth_m < one.depth_m ? two : one;
}

}  // namespace musclebench

#include "core/effects/no_passage/passage_overlaps.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>

#include "core/effects/no_passage/passage_paths.hpp"

namespace musclebench {

namespace {

using Corners = PassagePaths::Corners;

Vec3 unit_normal(const Corners& corners) {
  return (corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized();
}

/// A range on a line.
struct Range {
  double least = 0;
  double most = 0;
};

/// Where a triangle goes through the plane of another one with this normal, along `line`; nothing where it does not
/// reach farther than `touching_m` beyond it on both sides.
std::optional<Range> range_in_plane(const Corners& triangle, const Vec3& on_plane, const Vec3& normal, const Vec3& line,
                                    double touching_m) {
  std::array<double, 3> above_m;
  for (std::size_t k = 0; k < 3; ++k) above_m[k] = normal.dot(triangle[k] - on_plane);
  const auto [least, most] = std::ranges::minmax(above_m);
  if (least > -touching_m || most < touching_m) return std::nullopt;
  std::optional<Range> range;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if ((above_m[k] > 0) == (above_m[next] > 0)) continue;
    const double share = above_m[k] / (above_m[k] - above_m[next]);
    const double along = line.dot(triangle[k] + share * (triangle[next] - triangle[k]));
    if (!range) range = Range{along, along};
    range->least = std::min(range->least, along);
    range->most = std::max(range->most, along);
  }
  return range;
}

/// Whether two triangles have more than `touching_m` of a line in common at which each goes through the other (Moeller
/// 1997, "A fast triangle-triangle intersection test").
bool intersect(const Corners& one, const Corners& other, double touching_m) {
  const Vec3 normal = unit_normal(one);
  const Vec3 normal_of_other = unit_normal(other);
  const Vec3 line = normal.cross(normal_of_other).stableNormalized();
  if (line.isZero()) return false;
  const auto range = range_in_plane(one, other[0], normal_of_other, line, touching_m);
  const auto range_of_other = range_in_plane(other, one[0], normal, line, touching_m);
  if (!range || !range_of_other) return false;
  return std::min(range->most, range_of_other->most) - std::max(range->least, range_of_other->least) > touching_m;
}

}  // namespace

bool go_through_each_other(const PassagePaths& paths, const TrianglePair& pair, double touching_m) {
  const std::vector<Triangle>& triangles = paths.mesh().triangles;
  if (pair.bone < 0 && share_a_vertex(triangles[pair.triangle], triangles[pair.other])) return false;
  return intersect(paths.corners_of(pair.bone, pair.triangle), paths.corners_of_other(pair.bone, pair.other),
                   touching_m);
}

std::vector<TrianglePair> find_overlaps(PassagePaths& paths, double touching_m) {
  std::vector<std::vector<TrianglePair>> parts;
  paths.for_each_near(0, parts,
                      [&](std::vector<TrianglePair>& found, int bone, std::size_t t, std::size_t other, double) {
                        const TrianglePair pair{bone, t, other};
                        if (go_through_each_other(paths, pair, touching_m)) found.push_back(pair);
                        return 0.0;
                      });
  std::vector<TrianglePair> overlaps;
  for (const auto& part : parts) overlaps.insert(overlaps.end(), part.begin(), part.end());
  std::ranges::sort(overlaps, {},
                    [](const TrianglePair& pair) { return std::tuple(pair.bone, pair.triangle, pair.other); });
  return overlaps;
}

std::vector<TrianglePair> overlaps_at_start(const TriangleMesh& mesh, std::span<const Body> bodies,
                                            std::span<const Bone> bones, std::span<const BoundNode> bound_nodes,
                                            std::span<const RigidMotion> poses, double gap_m) {
  PassagePaths paths(mesh, bodies, bones, bound_nodes, true, 1);
  paths.set(mesh.vertices, mesh.vertices, poses, poses);
  std::vector<TrianglePair> overlaps = find_overlaps(paths, touching_share * gap_m);
  std::erase_if(overlaps, [&](const TrianglePair& pair) {
    return pair.bone >= 0 && std::ranges::any_of(mesh.triangles[pair.triangle], [&](int node) {
             return paths.carriers()[static_cast<std::size_t>(node)] == pair.bone;
           });
  });
  return overlaps;
}

}  // namespace musclebench

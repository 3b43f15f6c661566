#include "core/contact/reach_watch.hpp"

#include <algorithm>

namespace musclebench {

namespace {

/// By how much a box is grown beyond the reach, over its diagonal: far more than rounding moves a point.
constexpr double slack = 0.01;

Eigen::AlignedBox3d moved(const Eigen::AlignedBox3d& box, const RigidMotion& pose) {
  const Vec3 centre = pose.apply(box.center());
  const Vec3 half = pose.rotation.cwiseAbs() * (0.5 * box.sizes());
  return {centre - half, centre + half};
}

/// A comparison with a NaN is false, so that such a position changes nothing.
void extend(Eigen::AlignedBox3d& box, const Vec3& position) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    box.min()[axis] = position[axis] < box.min()[axis] ? position[axis] : box.min()[axis];
    box.max()[axis] = position[axis] > box.max()[axis] ? position[axis] : box.max()[axis];
  }
}

}  // namespace

void ReachWatch::add(int bone, const Eigen::AlignedBox3d& rest_box, double reach_m) {
  const double grown_m = reach_m + slack * rest_box.diagonal().norm();
  Eigen::AlignedBox3d box(rest_box.min() - Vec3::Constant(grown_m), rest_box.max() + Vec3::Constant(grown_m));
  m_watched.push_back({m_bones.size(), box, RigidMotion{}, box});
  m_bones.push_back({.bone = bone, .reach_m = grown_m});
}

bool ReachWatch::watches(int bone) const {
  return std::ranges::any_of(m_watched, [&](const Watched& each) { return m_bones[each.index].bone == bone; });
}

void ReachWatch::move(std::span<const RigidMotion> poses) {
  for (Watched& each : m_watched) {
    each.pose = poses[static_cast<std::size_t>(m_bones[each.index].bone)];
    each.world_box = moved(each.rest_box, each.pose);
  }
}

std::span<const int> ReachWatch::find_near(std::span<const Vec3> positions, std::span<const int> nodes) {
  Eigen::AlignedBox3d of_nodes;
  for (const int node : nodes) extend(of_nodes, positions[static_cast<std::size_t>(node)]);
  m_near.clear();
  for (const Watched& each : m_watched) {
    if (!each.world_box.intersects(of_nodes)) continue;
    const auto is_near = [&](int node) {
      return each.rest_box.contains(each.pose.apply_inverse(positions[static_cast<std::size_t>(node)]));
    };
    if (std::ranges::any_of(nodes, is_near)) m_near.push_back(m_bones[each.index].bone);
  }
  return m_near;
}

std::span<const int> ReachWatch::find_near(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  Eigen::AlignedBox3d of_nodes;
  for (const Vec3& position : positions) extend(of_nodes, position);
  m_near.clear();
  for (const Watched& each : m_watched) {
    if (!each.world_box.intersects(of_nodes)) continue;
    const auto is_near = [&](const Triangle& triangle) {
      Eigen::AlignedBox3d box;
      for (const int node : triangle) extend(box, positions[static_cast<std::size_t>(node)]);
      return each.world_box.intersects(box);
    };
    if (std::ranges::any_of(triangles, is_near)) m_near.push_back(m_bones[each.index].bone);
  }
  return m_near;
}

void ReachWatch::count_saved_queries(std::size_t nodes) {
  for (const Watched& each : m_watched) m_bones[each.index].saved_queries += static_cast<std::int64_t>(nodes);
}

PrunedBone& ReachWatch::bring_back(int bone) {
  std::erase_if(m_watched, [&](const Watched& each) { return m_bones[each.index].bone == bone; });
  PrunedBone& pruned = *std::ranges::find(m_bones, bone, &PrunedBone::bone);
  pruned.is_back = true;
  return pruned;
}

}  // namespace musclebench

#include "core/scene/check/pinch.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <tuple>

namespace musclebench {

namespace {

/// Normals of the two bones are more than 120 degrees apart: between two sides of a wedge as wide nodes are pushed out,
/// not pinched.
constexpr double opposed_cosine = -0.5;

/// The muscle's surface looks towards the bone there, so that its thickness lies behind, towards the other bone.
bool faces(const NearNode& near) { return near.muscle_normal.dot(near.normal) < opposed_cosine; }

template <typename Opposed>
Pinch pinch_of(const BoneNearness& one, const BoneNearness& other, const std::vector<double>& thickness_m,
               const Opposed& opposed) {
  Pinch pinch;
  pinch.room_m = std::numeric_limits<double>::infinity();
  std::set<int> nodes;
  const auto before = [](const NearNode& a, const NearNode& b) {
    return std::tie(a.pose, a.node) < std::tie(b.pose, b.node);
  };
  auto second = other.near.begin();  // both are in the order of poses and nodes
  for (const NearNode& first : one.near) {
    while (second != other.near.end() && before(*second, first)) ++second;
    if (second == other.near.end()) break;
    if (before(first, *second)) continue;
    if (first.signed_distance_m < 0 || second->signed_distance_m < 0) continue;
    if (!opposed(first, *second) || !(faces(first) || faces(*second))) continue;
    const double room_m = first.signed_distance_m + second->signed_distance_m;
    const double thick_m = thickness_m[static_cast<std::size_t>(first.node)];
    if (room_m >= thick_m) continue;
    nodes.insert(first.node);
    if (room_m < pinch.room_m) {
      pinch.room_m = room_m;
      pinch.thickness_m = thick_m;
      pinch.node = first.node;
    }
  }
  pinch.nodes = static_cast<int>(nodes.size());
  return pinch;
}

}  // namespace

std::vector<Pinch> pinches(const PoseEstimates& poses, const std::vector<BoneNearness>& nearness,
                           const std::vector<double>& thickness_m) {
  std::vector<Pinch> found;
  for (std::size_t first = 0; first < nearness.size(); ++first) {
    for (std::size_t second = first + 1; second < nearness.size(); ++second) {
      const auto opposed = [&](const NearNode& one, const NearNode& other) {
        const std::vector<RigidMotion>& bones = poses.bone_poses(one.pose);
        return bones[first].apply_to_direction(one.normal).dot(bones[second].apply_to_direction(other.normal)) <
               opposed_cosine;
      };
      Pinch pinch = pinch_of(nearness[first], nearness[second], thickness_m, opposed);
      pinch.first_bone = first;
      pinch.second_bone = second;
      if (pinch.nodes > 0) found.push_back(pinch);
    }
  }
  return found;
}

}  // namespace musclebench

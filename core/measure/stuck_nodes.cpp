#include "core/measure/stuck_nodes.hpp"

#include <algorithm>
#include <vector>

namespace musclebench {
namespace {

constexpr double largest_share_left = 0.1;

}  // namespace

int count_stuck_nodes(const LastDetection& detection, std::span<const Contact> truth, std::span<const Vec3> after,
                      double floor_m) {
  std::vector<char> in_bone(detection.positions.size(), 0);
  for (const Contact& contact : truth) in_bone[static_cast<std::size_t>(contact.node)] = 1;
  std::vector<int> stuck;
  for (const Contact& contact : detection.contacts) {
    const auto node = static_cast<std::size_t>(contact.node);
    const auto bone = static_cast<std::size_t>(contact.bone);
    if (in_bone[node] != 0) continue;
    const Vec3 carried = detection.bone_poses[bone].apply(
        detection.previous_bone_poses[bone].apply_inverse(detection.substep_start[node]));
    const double wanted_m = (detection.positions[node] - carried).norm();
    if (wanted_m > floor_m && (after[node] - carried).norm() <= largest_share_left * wanted_m) {
      stuck.push_back(contact.node);
    }
  }
  std::sort(stuck.begin(), stuck.end());
  return static_cast<int>(std::unique(stuck.begin(), stuck.end()) - stuck.begin());
}

}  // namespace musclebench

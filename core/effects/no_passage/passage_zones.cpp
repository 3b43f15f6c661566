#include "core/effects/no_passage/passage_zones.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace musclebench {

namespace {

std::size_t as_index(int item) { return static_cast<std::size_t>(item); }

}  // namespace

void PassageZones::begin(std::span<const Vec3> from, std::span<const Vec3> to) {
  m_from.assign(from.begin(), from.end());
  m_to.assign(to.begin(), to.end());
  m_sets.reset(m_from.size() + m_paths.bones());
  m_is_in.assign(m_from.size(), 0);
  m_is_held.assign(m_from.size(), 0);
}

bool PassageZones::join(const PassageStencil& stencil, const ContactStageInput& input) {
  bool is_news = false;
  int first = -1;
  const auto add = [&](int item) {
    if (first >= 0 && m_sets.find(first) != m_sets.find(item)) {
      m_sets.join(first, item);
      is_news = true;
    }
    first = item;
  };
  if (stencil.bone >= 0) add(bone_item(as_index(stencil.bone)));
  for (std::size_t k = 0; k < 4; ++k) {
    if (stencil.is_of_bone(k)) continue;
    const std::size_t node = as_index(stencil.corners[k]);
    if (std::exchange(m_is_in[node], 1) == 0) {
      is_news = true;
      const int carrier = m_paths.carriers()[node];
      m_is_held[node] = carrier >= 0 && is_held(node, input) ? 1 : 0;
      if (carrier >= 0 && m_is_held[node] == 0) add(bone_item(as_index(carrier)));
    }
    add(stencil.corners[k]);
  }
  return is_news;
}

/// Whether a bound node stays where it is while its bone moves: no effect carries it.
bool PassageZones::is_held(std::size_t node, const ContactStageInput& input) const {
  const std::size_t bone = as_index(m_paths.carriers()[node]);
  const RigidMotion& before = input.previous_bone_poses[bone];
  const RigidMotion& after = input.bone_poses[bone];
  return m_to[node] == m_from[node] &&
         (before.rotation != after.rotation || before.translation_m != after.translation_m);
}

std::vector<int> PassageZones::carriers() {
  std::vector<int> carriers(m_from.size() + m_paths.bones(), nothing);
  for (std::size_t node = 0; node < m_from.size(); ++node) {
    if (m_is_held[node] != 0) carriers[as_index(m_sets.find(static_cast<int>(node)))] = held;
  }
  for (std::size_t bone = m_paths.bones(); bone-- > 0;) {
    carriers[as_index(m_sets.find(bone_item(bone)))] = static_cast<int>(bone);
  }
  return carriers;
}

void PassageZones::place(const ContactStageInput& input, std::span<const double> inverse_masses, std::span<Vec3> ends,
                         std::span<char> is_moved) {
  const std::vector<int> carrier_of = carriers();
  std::vector<Vec3> moments(carrier_of.size(), Vec3::Zero());
  std::vector<double> masses(carrier_of.size(), 0);
  const auto for_each_free_node = [&](const auto& visit) {
    for (std::size_t node = 0; node < m_from.size(); ++node) {
      if (m_is_in[node] == 0 || !(inverse_masses[node] > 0)) continue;
      visit(node, as_index(m_sets.find(static_cast<int>(node))));
    }
  };
  for_each_free_node([&](std::size_t node, std::size_t zone) {
    moments[zone] += (m_to[node] - m_from[node]) / inverse_masses[node];
    masses[zone] += 1 / inverse_masses[node];
  });
  std::ranges::fill(is_moved, 0);
  for_each_free_node([&](std::size_t node, std::size_t zone) {
    is_moved[node] = 1;
    ends[node] = m_from[node];
    const int carrier = carrier_of[zone];
    if (carrier == nothing) {
      ends[node] += moments[zone] / masses[zone];
    } else if (carrier != held) {
      const std::size_t bone = as_index(carrier);
      ends[node] = input.bone_poses[bone].apply(input.previous_bone_poses[bone].apply_inverse(m_from[node]));
    }
  });
}

std::string PassageZones::prescribed_in_zone_of(int node, std::span<const Bone> bones) {
  const int zone = m_sets.find(node);
  std::vector<std::string_view> names;
  for (std::size_t bone = 0; bone < bones.size(); ++bone) {
    if (m_sets.find(bone_item(bone)) == zone) names.push_back(bones[bone].name);
  }
  for (std::size_t other = 0; other < m_from.size(); ++other) {
    if (m_is_held[other] == 0 || m_sets.find(static_cast<int>(other)) != zone) continue;
    names.push_back("nodes that are held in place");
    break;
  }
  return fmt::format("{}", fmt::join(names, " and "));
}

}  // namespace musclebench

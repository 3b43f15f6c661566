#include "core/effects/no_passage/near_pairs.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/bvh/bvh_lanes.hpp"

namespace musclebench {

namespace {

/// What would be used up within so many steps like this is measured together with others, so that the next steps need
/// not look at the same pair of nodes.
constexpr float soon_steps = 2;
/// Triangles that a step may bring together are open by themselves until what is left lasts for so many steps; with
/// fewer they would be opened again at once.
constexpr float away_steps = 4;
/// Eights that have more of them are looked at whole, as nothing in them rests: a body that bursts meets everything.
constexpr int most_opened = 16;

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

/// One of eight spheres.
struct LaneOf {
  const SphereLanes& lanes;
  std::size_t lane;

  static LaneOf node(PathSpheres& spheres, int level, int index) {
    const auto i = at_index(index);
    return {spheres.below(level + 1, i / bvh_width), i % bvh_width};
  }
};

float squared(const std::array<float, 3>& vector) {
  return vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2];
}

std::array<float, 3> difference(const std::array<BvhLanes, 3>& first, std::size_t i,
                                const std::array<BvhLanes, 3>& second, std::size_t j) {
  return {first[0][i] - second[0][j], first[1][i] - second[1][j], first[2][i] - second[2][j]};
}

/// How far two spheres come closer at most.
float approach_of(const LaneOf& one, const LaneOf& other) {
  const float moved_m = std::sqrt(squared(difference(one.lanes.move, one.lane, other.lanes.move, other.lane)));
  return (1 + lane_rounding) * (moved_m + one.lanes.spread_m[one.lane] + other.lanes.spread_m[other.lane]);
}

/// The same of two that tell their moves and, last, their spread.
float approach_of(const Four& one, const Four& other) {
  const Four apart = one - other;
  const float moved_m = std::sqrt(apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]);
  return (1 + lane_rounding) * (moved_m + (one[3] + other[3]));
}

/// How far two spheres are apart where the paths start, at least.
float apart_m(const LaneOf& one, const LaneOf& other) {
  const float centres_m = std::sqrt(squared(difference(one.lanes.from, one.lane, other.lanes.from, other.lane)));
  return (1 - lane_rounding) * centres_m - one.lanes.radius_m[one.lane] - other.lanes.radius_m[other.lane];
}

/// The same at any time on the paths.
float closest_m(const LaneOf& one, const LaneOf& other) {
  std::array<float, 3> apart = difference(one.lanes.from, one.lane, other.lanes.from, other.lane);
  const std::array<float, 3> move = difference(one.lanes.move, one.lane, other.lanes.move, other.lane);
  const float squared_move = squared(move);
  const float towards = -(apart[0] * move[0] + apart[1] * move[1] + apart[2] * move[2]);
  const float when = squared_move > 0 ? std::clamp(towards / squared_move, 0.0F, 1.0F) : 0.0F;
  for (std::size_t axis = 0; axis < 3; ++axis) apart[axis] += when * move[axis];
  return (1 - lane_rounding) * std::sqrt(squared(apart)) - one.lanes.radius_m[one.lane] -
         other.lanes.radius_m[other.lane] - one.lanes.spread_m[one.lane] - other.lanes.spread_m[other.lane];
}

float least_of(const PairDistances& left_m) {
  BvhLanes least = left_m[0];
  for (const BvhLanes& row : left_m) {
    for (std::size_t j = 0; j < bvh_width; ++j) least[j] = std::min(least[j], row[j]);
  }
  return *std::ranges::min_element(least);
}

template <typename Visit>
void for_each_bit(std::uint64_t bits, const Visit& visit) {
  for (; bits != 0; bits &= bits - 1) visit(static_cast<std::size_t>(std::countr_zero(bits)));
}

}  // namespace

NearPairs::NearPairs(PathSpheres& first, PathSpheres& second)
    : m_first(first), m_second(second), m_levels(at_index(first.tree().top()) + 1) {
  (void)open(top(), -1, 0);
}

int NearPairs::open(int level, int above, int slot) {
  Level& all = at(level);
  std::size_t index = all.open.size();
  if (all.free.empty()) {
    all.open.emplace_back();
    all.first.emplace_back();
    all.second.emplace_back();
    all.left_m.emplace_back();
    all.left_at_end_m.emplace_back();
    if (level > 0) all.blocks.emplace_back();
    if (level > 1) all.below.emplace_back();
  } else {
    index = at_index(all.free.back());
    all.free.pop_back();
  }
  all.open[index] = {.is_used = true, .above = above, .slot = slot};
  all.first[index] = all.second[index] = 0;
  if (above >= 0) {
    Level& parents = at(level + 1);
    constexpr auto width = static_cast<int>(bvh_width);
    all.first[index] = parents.first[at_index(above)] * width + slot / width;
    all.second[index] = parents.second[at_index(above)] * width + slot % width;
    parents.blocks[at_index(above)].left_m[at_index(slot) / bvh_width][at_index(slot) % bvh_width] = nowhere_m;
    if (level > 0) parents.below[at_index(above)][at_index(slot)] = static_cast<int>(index);
    ++parents.open[at_index(above)].open_below;
  }
  all.left_m[index] = all.left_at_end_m[index] = 0;
  if (level > 0) {
    Block& block = all.blocks[index] = {};
    if (&m_first == &m_second && all.first[index] == all.second[index]) {
      // Each pair once, and no triangle with itself.
      for (std::size_t i = 0; i < bvh_width; ++i) {
        for (std::size_t j = 0; j < i + (level == 1 ? 1 : 0); ++j) block.left_m[i][j] = nowhere_m;
      }
    }
  }
  if (level > 1) all.below[index].fill(-1);
  return static_cast<int>(index);
}

void NearPairs::close(int level, int index, float left_m) {
  Level& all = at(level);
  Level& parents = at(level + 1);
  Open& pair = all.open[at_index(index)];
  const int above = pair.above;
  make_current(level + 1, above);
  parents.blocks[at_index(above)].left_m[at_index(pair.slot) / bvh_width][at_index(pair.slot) % bvh_width] = left_m;
  parents.left_m[at_index(above)] = std::min(parents.left_m[at_index(above)], left_m);
  if (level > 0) parents.below[at_index(above)][at_index(pair.slot)] = -1;
  Open& of_parents = parents.open[at_index(above)];
  if (--of_parents.open_below == 0 && !std::exchange(of_parents.is_emptied, true)) parents.emptied.push_back(above);
  pair = {};
  all.left_m[at_index(index)] = all.left_at_end_m[at_index(index)] = nowhere_m;
  all.free.push_back(index);
}

/// Where the spheres of a pair tell enough from now on, and nothing below it is open.
bool NearPairs::close_if_far(int level, int index) {
  const Level& all = at(level);
  if (all.open[at_index(index)].open_below > 0) return false;
  const LaneOf one = LaneOf::node(m_first, level, all.first[at_index(index)]);
  const LaneOf other = LaneOf::node(m_second, level, all.second[at_index(index)]);
  const float apart = apart_m(one, other);
  if (!(apart > approach_of(one, other) + m_least_m)) return false;
  close(level, index, apart);
  return true;
}

void NearPairs::find(double least_m) {
  m_found.clear();
  m_sources.clear();
  m_leaves.clear();
  if (m_first.tree().size(0) == 0 || m_second.tree().size(0) == 0) return;
  m_least_m = (1 + lane_rounding) * static_cast<float>(least_m);
  look_into(top(), 0);
  for (int level = top() - 1; level >= 0; --level) {
    find_used_up(level);
    for (const int index : m_used_up) {
      Open& pair = at(level).open[at_index(index)];
      if (!pair.is_used) continue;
      if (level == 0) {
        look_at_pair(index);
        continue;
      }
      pair.is_emptied = false;
      if (close_if_far(level, index)) continue;
      if (level > 1) {
        look_into(level, index);
      } else {
        look_at_leaf(index);
      }
    }
    for (const int index : at(level).emptied) {
      if (std::exchange(at(level).open[at_index(index)].is_emptied, false)) close_if_far(level, index);
    }
    at(level).emptied.clear();
  }
}

void NearPairs::find_used_up(int level) {
  Level& all = at(level);
  const std::size_t count = all.first.size();
  // Pointers, so that they need not be read again after each store: most pairs are only looked at here.
  const int* firsts = all.first.data();
  const int* seconds = all.second.data();
  const float* left_m = all.left_m.data();
  float* left_at_end_m = all.left_at_end_m.data();
  const float least_m = m_least_m;
  m_used_up.resize(count);
  int* used_up = m_used_up.data();
  const auto ones = m_first.motions(level);
  const auto others = m_second.motions(level);
  const auto look_at = [&](std::size_t i) {
    const float left = left_after(left_m[i], approach_of(ones[firsts[i]], others[seconds[i]]));
    left_at_end_m[i] = left;
    *used_up = static_cast<int>(i);
    if (!(left > least_m)) ++used_up;
  };
  if (m_first.is_all_changed()) {
    for (std::size_t i = 0; i < count; ++i) look_at(i);
  } else {
    // Triangles are as their leaf.
    const int shift = level > 0 ? 0 : std::countr_zero(bvh_width);
    const auto first = m_first.changed(std::max(level, 1));
    const auto second = m_second.changed(std::max(level, 1));
    for (std::size_t i = 0; i < count; ++i) {
      if (first[firsts[i] >> shift] || second[seconds[i] >> shift]) look_at(i);
    }
  }
  m_used_up.resize(static_cast<std::size_t>(used_up - m_used_up.data()));
}

void NearPairs::make_current(int level, int index) {
  Open& pair = at(level).open[at_index(index)];
  if (std::exchange(pair.is_current, true)) return;
  at(level).current.push_back(index);
  const float gone_m = (1 + lane_rounding) * (pair.left_when_current_m - at(level).left_m[at_index(index)]);
  for (BvhLanes& row : at(level).blocks[at_index(index)].left_m) {
    for (float& left_m : row) left_m = left_after(left_m, gone_m);
  }
}

void NearPairs::look_into(int level, int index) {
  Level& all = at(level);
  make_current(level, index);
  PairDistances& left_m = all.blocks[at_index(index)].left_m;
  const SphereLanes& first = m_first.below(level, at_index(all.first[at_index(index)]));
  const SphereLanes& second = m_second.below(level, at_index(all.second[at_index(index)]));
  const float soon_m =
      level < top() ? soon_steps * (all.left_m[at_index(index)] - all.left_at_end_m[at_index(index)]) : 0;
  for_each_bit(used_up_slots(first, second, m_least_m, soon_m, left_m), [&](std::size_t slot) {
    const LaneOf one{first, slot / bvh_width};
    const LaneOf other{second, slot % bvh_width};
    if (left_m[one.lane][other.lane] > approach_of(one, other) + m_least_m) return;
    if (closest_m(one, other) > m_least_m || all.below[at_index(index)][slot] >= 0) return;
    (void)open(level - 1, index, static_cast<int>(slot));
  });
  all.left_m[at_index(index)] = least_of(left_m);
}

void NearPairs::look_at_leaf(int index) {
  Level& all = at(1);
  const int first = all.first[at_index(index)];
  const int second = all.second[at_index(index)];
  if (closest_m(LaneOf::node(m_first, 1, first), LaneOf::node(m_second, 1, second)) > m_least_m) return;
  make_current(1, index);
  PairDistances& left_m = all.blocks[at_index(index)].left_m;
  // What slides on another surface is as close again at once.
  const float soon_m =
      &m_first == &m_second ? soon_steps * (all.left_m[at_index(index)] - all.left_at_end_m[at_index(index)]) : 0;
  const SphereLanes& of_first = m_first.below(1, at_index(first));
  const SphereLanes& of_second = m_second.below(1, at_index(second));
  const std::uint64_t used_up = used_up_slots(of_first, of_second, m_least_m, soon_m, left_m);
  for_each_bit(used_up, [&](std::size_t slot) {
    const LaneOf one{of_first, slot / bvh_width};
    const LaneOf other{of_second, slot % bvh_width};
    m_found.push_back({at_index(first) * bvh_width + one.lane, at_index(second) * bvh_width + other.lane,
                       approach_of(one, other), left_m[one.lane][other.lane]});
    m_sources.push_back({index, static_cast<int>(slot), std::popcount(used_up) <= most_opened});
  });
  m_leaves.push_back(index);
}

void NearPairs::look_at_pair(int index) {
  const Level& all = at(0);
  const int first = all.first[at_index(index)];
  const int second = all.second[at_index(index)];
  const LaneOf one = LaneOf::node(m_first, 0, first);
  const LaneOf other = LaneOf::node(m_second, 0, second);
  const NearPair pair{at_index(first), at_index(second), approach_of(one, other),
                      std::max(all.left_m[at_index(index)], apart_m(one, other))};
  if (lasts(pair, 1)) {
    keep_or_close(index, pair);
  } else {
    m_found.push_back(pair);
    m_sources.push_back({index, -1, true});
  }
}

bool NearPairs::lasts(const NearPair& pair, float steps) const {
  return pair.left_m > steps * pair.approach_m + m_least_m;
}

void NearPairs::keep_or_close(int index, const NearPair& pair) {
  if (lasts(pair, away_steps)) {
    close(0, index, pair.left_m);
    return;
  }
  at(0).left_m[at_index(index)] = pair.left_m;
  at(0).left_at_end_m[at_index(index)] = left_after(pair.left_m, pair.approach_m);
}

void NearPairs::tell() {
  for (std::size_t i = 0; i < m_found.size(); ++i) {
    const auto& [index, slot, may_open] = m_sources[i];
    if (slot < 0) {
      keep_or_close(index, m_found[i]);
    } else if (!may_open || lasts(m_found[i], 1)) {
      at(1).blocks[at_index(index)].left_m[at_index(slot) / bvh_width][at_index(slot) % bvh_width] = m_found[i].left_m;
    } else {
      keep_or_close(open(0, index, slot), m_found[i]);
    }
  }
  for (const int leaf : m_leaves) at(1).left_m[at_index(leaf)] = least_of(at(1).blocks[at_index(leaf)].left_m);
}

void NearPairs::move_on() {
  for (int level = 0; level <= top(); ++level) {
    Level& all = at(level);
    all.left_m.swap(all.left_at_end_m);
    for (const int index : all.current) {
      const auto i = at_index(index);
      if (!std::exchange(all.open[i].is_current, false)) continue;  // closed since
      all.left_m[i] = all.open[i].left_when_current_m =
          take_off_approach(m_first.below(level, at_index(all.first[i])),
                            m_second.below(level, at_index(all.second[i])), all.blocks[i].left_m);
    }
    all.current.clear();
    constexpr std::size_t few = 64;
    if (all.free.size() > few && 2 * all.free.size() > all.open.size()) compact(level);
  }
}

std::size_t NearPairs::bytes() const {
  std::size_t bytes = 0;
  for (const Level& all : m_levels) {
    bytes += all.open.size() * (sizeof(Open) + 2 * sizeof(int) + 2 * sizeof(float)) +
             all.blocks.size() * sizeof(Block) + all.below.size() * sizeof(all.below[0]);
  }
  return bytes;
}

/// So that steps do not go through what a flight opened and has closed since.
void NearPairs::compact(int level) {
  Level& all = at(level);
  std::vector<int> kept;
  std::vector<int> place(all.open.size(), -1);
  for (std::size_t i = 0; i < all.open.size(); ++i) {
    if (!all.open[i].is_used) continue;
    place[i] = static_cast<int>(kept.size());
    kept.push_back(static_cast<int>(i));
  }
  const auto keep = [&](auto& of_pairs) {
    if (of_pairs.empty()) return;
    for (std::size_t i = 0; i < kept.size(); ++i) of_pairs[i] = of_pairs[at_index(kept[i])];
    of_pairs.resize(kept.size());
  };
  keep(all.open);
  keep(all.first);
  keep(all.second);
  keep(all.left_m);
  keep(all.left_at_end_m);
  keep(all.blocks);
  keep(all.below);
  all.free.clear();
  for (int& index : all.emptied) index = place[at_index(index)];
  std::erase(all.emptied, -1);
  if (level > 0) {
    for (Open& child : at(level - 1).open) {
      if (child.is_used) child.above = place[at_index(child.above)];
    }
    for (std::size_t i = 0; i < all.open.size(); ++i) {
      at(level + 1).below[at_index(all.open[i].above)][at_index(all.open[i].slot)] = static_cast<int>(i);
    }
  }
}

}  // namespace musclebench

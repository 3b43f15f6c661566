#include "core/effects/no_passage/near_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/bvh/bvh_lanes.hpp"

namespace musclebench {

namespace {

/// What would be used up within so many steps like this is measured together with others, so that the next steps need
/// not look at the same pair of nodes.
constexpr float soon_steps = 2;
/// Spheres that are apart by more than this share of their radii tell enough; closer ones are looked into, as their
/// distance says little.
constexpr float far_share = 0.1F;

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

/// The same of four pairs; each has its move and, last, its spread.
Four approach_of(const std::array<const Four*, 4>& ones, const std::array<const Four*, 4>& others) {
  Eigen::Matrix4f moves;
  Eigen::Matrix4f spreads;
  for (std::size_t k = 0; k < 4; ++k) {
    moves.col(static_cast<Eigen::Index>(k)) = *ones[k] - *others[k];
    spreads.col(static_cast<Eigen::Index>(k)) = *ones[k] + *others[k];
  }
  moves.transposeInPlace();
  spreads.transposeInPlace();
  const Four squared = moves.col(0).array().square() + moves.col(1).array().square() + moves.col(2).array().square();
  return (1 + lane_rounding) * (squared.sqrt() + spreads.col(3).array());
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

bool is_far(float apart, const LaneOf& one, const LaneOf& other) {
  return apart > far_share * std::abs(one.lanes.radius_m[one.lane] + other.lanes.radius_m[other.lane]);
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
    : m_first(first), m_second(second), m_levels(at_index(first.tree().top())) {
  (void)open(top(), -1, 0);
}

int NearPairs::open(int level, int above, int slot) {
  Level& all = at(level);
  std::size_t index = all.open.size();
  if (all.free.empty()) {
    all.open.emplace_back();
    all.blocks.emplace_back();
    if (level > 1) all.below.emplace_back();
  } else {
    index = at_index(all.free.back());
    all.free.pop_back();
  }
  NearBlock& block = all.blocks[index] = {};
  if (above >= 0) {
    const NearBlock& parents = at(level + 1).blocks[at_index(above)];
    block.first = parents.first * bvh_width + at_index(slot) / bvh_width;
    block.second = parents.second * bvh_width + at_index(slot) % bvh_width;
  }
  all.open[index] = {
      .above = above, .slot = slot, .first = static_cast<int>(block.first), .second = static_cast<int>(block.second)};
  if (level > 1) all.below[index].fill(-1);
  if (&m_first == &m_second && block.first == block.second) {
    // Each pair once, and no triangle with itself.
    for (std::size_t i = 0; i < bvh_width; ++i) {
      for (std::size_t j = 0; j < i + (level == 1 ? 1 : 0); ++j) block.left_m[i][j] = nowhere_m;
    }
  }
  return static_cast<int>(index);
}

/// Where the spheres of a pair tell enough from now on, and nothing below it is open.
bool NearPairs::close_if_far(int level, int index, float least_m) {
  Level& all = at(level);
  Open& pair = all.open[at_index(index)];
  const LaneOf one = LaneOf::node(m_first, level, pair.first);
  const LaneOf other = LaneOf::node(m_second, level, pair.second);
  const float apart = apart_m(one, other);
  if (!(apart > approach_of(one, other) + least_m) || !is_far(apart, one, other)) return false;
  if (pair.open_below > 0) return false;
  const std::size_t above = at_index(pair.above);
  make_current(level + 1, pair.above);
  at(level + 1).blocks[above].left_m[at_index(pair.slot) / bvh_width][at_index(pair.slot) % bvh_width] = apart;
  at(level + 1).below[above][at_index(pair.slot)] = -1;
  Open& parents = at(level + 1).open[above];
  parents.left_m = std::min(parents.left_m, apart);
  parents.is_emptied = --parents.open_below == 0;
  pair.above = -1;
  all.free.push_back(index);
  return true;
}

void NearPairs::find(double least_m) {
  m_found.clear();
  if (m_first.tree().size(0) == 0 || m_second.tree().size(0) == 0) return;
  const auto least = (1 + lane_rounding) * static_cast<float>(least_m);
  look_into(top(), 0, least);
  for (int level = top() - 1; level >= 1; --level) {
    approach_all(level);
    // Those that are opened meanwhile are of the level below.
    for (std::size_t i = 0; i < at(level).open.size(); ++i) {
      Open& pair = at(level).open[i];
      if (pair.above < 0 || !is_changed(level, pair)) continue;
      const bool is_used_up = !(pair.left_at_end_m > least);
      if (!is_used_up && !pair.is_emptied) continue;
      pair.is_emptied = false;
      if (close_if_far(level, static_cast<int>(i), least) || !is_used_up) continue;
      if (level > 1) {
        look_into(level, static_cast<int>(i), least);
      } else {
        look_at_leaf(static_cast<int>(i), least);
      }
    }
  }
}

void NearPairs::approach_all(int level) {
  std::vector<Open>& open = at(level).open;
  if (!m_first.is_all_changed()) {
    for (Open& pair : open) {
      if (!is_changed(level, pair)) continue;
      const Four& one = m_first.motion(level, at_index(pair.first));
      const Four& other = m_second.motion(level, at_index(pair.second));
      pair.left_at_end_m =
          left_after(pair.left_m, approach_of({&one, &one, &one, &one}, {&other, &other, &other, &other})[0]);
    }
    return;
  }
  for (std::size_t first = 0; first < open.size(); first += 4) {
    std::array<const Four*, 4> ones;
    std::array<const Four*, 4> others;
    for (std::size_t k = 0; k < 4; ++k) {
      const Open& pair = open[std::min(first + k, open.size() - 1)];
      ones[k] = &m_first.motion(level, at_index(pair.first));
      others[k] = &m_second.motion(level, at_index(pair.second));
    }
    const Four approach = approach_of(ones, others);
    for (std::size_t k = 0; k < std::min<std::size_t>(4, open.size() - first); ++k) {
      open[first + k].left_at_end_m = left_after(open[first + k].left_m, approach[static_cast<Eigen::Index>(k)]);
    }
  }
}

void NearPairs::make_current(int level, int index) {
  Open& pair = at(level).open[at_index(index)];
  if (std::exchange(pair.is_current, true)) return;
  at(level).current.push_back(index);
  const float gone_m = (1 + lane_rounding) * (pair.left_when_current_m - pair.left_m);
  for (BvhLanes& row : at(level).blocks[at_index(index)].left_m) {
    for (float& left_m : row) left_m = left_after(left_m, gone_m);
  }
}

void NearPairs::look_into(int level, int index, float least_m) {
  Level& all = at(level);
  NearBlock& block = all.blocks[at_index(index)];
  make_current(level, index);
  const SphereLanes& first = m_first.below(level, block.first);
  const SphereLanes& second = m_second.below(level, block.second);
  const Open& pair = all.open[at_index(index)];
  const float soon_m = level < top() ? soon_steps * (pair.left_m - pair.left_at_end_m) : 0;
  for_each_bit(find_used_up(first, second, least_m, soon_m, block.left_m), [&](std::size_t slot) {
    const LaneOf one{first, slot / bvh_width};
    const LaneOf other{second, slot % bvh_width};
    float& left_m = block.left_m[one.lane][other.lane];
    if (is_far(left_m, one, other) && left_m > approach_of(one, other) + least_m) return;
    if (closest_m(one, other) > least_m || all.below[at_index(index)][slot] >= 0) return;
    left_m = nowhere_m;
    all.below[at_index(index)][slot] = open(level - 1, index, static_cast<int>(slot));
    ++all.open[at_index(index)].open_below;
  });
  all.open[at_index(index)].left_m = least_of(block.left_m);
}

void NearPairs::look_at_leaf(int index, float least_m) {
  NearBlock& block = leaf(index);
  const Open& pair = at(1).open[at_index(index)];
  if (closest_m(LaneOf::node(m_first, 1, pair.first), LaneOf::node(m_second, 1, pair.second)) > least_m) return;
  make_current(1, index);
  // What slides on another surface is as close again at once.
  const float soon_m = &m_first == &m_second ? soon_steps * (pair.left_m - pair.left_at_end_m) : 0;
  block.found =
      find_used_up(m_first.below(1, block.first), m_second.below(1, block.second), least_m, soon_m, block.left_m);
  m_found.push_back(index);
}

float NearPairs::approach_m(const NearBlock& leaf, std::size_t row, std::size_t column) {
  return approach_of({m_first.below(1, leaf.first), row}, {m_second.below(1, leaf.second), column});
}

void NearPairs::tell() {
  for (const int index : m_found) at(1).open[at_index(index)].left_m = least_of(leaf(index).left_m);
}

void NearPairs::move_on() {
  for (int level = 1; level <= top(); ++level) {
    Level& all = at(level);
    for (Open& pair : all.open) {
      if (!pair.is_current) pair.left_m = pair.left_at_end_m;
    }
    for (const int index : all.current) {
      NearBlock& block = all.blocks[at_index(index)];
      Open& pair = all.open[at_index(index)];
      pair.is_current = false;
      pair.left_m = pair.left_when_current_m =
          take_off_approach(m_first.below(level, block.first), m_second.below(level, block.second), block.left_m);
    }
    all.current.clear();
    constexpr std::size_t few = 64;
    if (all.free.size() > few && 2 * all.free.size() > all.open.size()) compact(level);
  }
}

std::size_t NearPairs::bytes() const {
  std::size_t bytes = 0;
  for (const Level& level : m_levels) {
    bytes += level.open.size() * (sizeof(Open) + sizeof(NearBlock)) + level.below.size() * sizeof(level.below[0]);
  }
  return bytes;
}

/// Gives back what a flight opened and has closed since.
void NearPairs::compact(int level) {
  Level& all = at(level);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all.open.size(); ++i) {
    if (all.open[i].above < 0) continue;
    all.open[kept] = all.open[i];
    all.blocks[kept] = all.blocks[i];
    at(level + 1).below[at_index(all.open[kept].above)][at_index(all.open[kept].slot)] = static_cast<int>(kept);
    if (level > 1) {
      all.below[kept] = all.below[i];
      for (const int below : all.below[kept]) {
        if (below >= 0) at(level - 1).open[at_index(below)].above = static_cast<int>(kept);
      }
    }
    ++kept;
  }
  all.open.resize(kept);
  all.blocks.resize(kept);
  if (level > 1) all.below.resize(kept);
  all.free.clear();
}

}  // namespace musclebench

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/effects/no_passage/path_spheres.hpp"
#include "core/effects/no_passage/sphere_lanes.hpp"

namespace musclebench {

/// A node of one tree and a node of another one, of the same level from 1 on, with how far apart each two of their
/// children are at least where the paths start, m.
struct NearBlock {
  std::size_t first = 0;
  std::size_t second = 0;
  alignas(32) PairDistances left_m = {};
  std::uint64_t found = 0;  ///< of a leaf: pairs to be looked at, bit 8 i + j for row i and column j
};

/// Finds pairs of triangles of two surfaces that may come close on their paths, and remembers from step to step how far
/// apart they were, so that a step looks only at what has used its distance up: at the front of the tree of all pairs
/// of nodes, between those that are looked into and those that are too far apart (Li and Chen 1998, "Incremental 3D
/// collision detection with hierarchical data structures").
///
/// A step: set the paths, `find`, look at the pairs that `leaves` name and write how far apart they are into `left_m`,
/// `tell`; all of this again for other paths from the same start; and `move_on` once the last of them are taken.
class NearPairs {
 public:
  /// Two trees of as many levels, or one twice: then each pair of triangles is there once. Kept by reference.
  NearPairs(PathSpheres& first, PathSpheres& second);

  /// Finds triangles that may come closer than `least_m` on the paths, and some more; only those with a vertex whose
  /// path has changed, where some have since the last time.
  void find(double least_m);
  [[nodiscard]] std::span<const int> leaves() const { return m_found; }
  /// Its nodes are of level 1, so that its pairs are of triangles.
  [[nodiscard]] NearBlock& leaf(int index) { return m_levels[0].blocks[static_cast<std::size_t>(index)]; }
  /// How far the triangles of a pair of `leaves` come closer at most, m. Safe from several threads for leaves of the
  /// last `find`, as long as the paths are those.
  [[nodiscard]] float approach_m(const NearBlock& leaf, std::size_t row, std::size_t column);
  /// Takes over what was found out about leaves.
  void tell();
  /// The ends of the paths become starts.
  void move_on();
  /// Of what is open.
  [[nodiscard]] std::size_t bytes() const;

 private:
  /// A pair of nodes that is looked into.
  struct Open {
    int above = -1;  ///< index of the block of their parents; -1: not used
    int slot = 0;    ///< in that block
    int first = 0;
    int second = 0;
    float left_m = 0;               ///< least distance where the paths start of what its block has not open in turn
    float left_when_current_m = 0;  ///< the same when the block was last current: its distances are too large by more
    float left_at_end_m = 0;        ///< where the paths end
    int open_below = 0;             ///< how many pairs of its block are open in turn
    bool is_emptied = false;        ///< whether the last of them was closed since the last time
    bool is_current = false;        ///< whether distances in its block are those where the paths start
  };
  /// All open pairs of nodes of a level.
  struct Level {
    std::vector<Open> open;
    std::vector<NearBlock> blocks;
    std::vector<std::array<int, bvh_width * bvh_width>> below;  ///< by slot: index of what is open in turn, or -1
    std::vector<int> free;
    std::vector<int> current;  ///< whose blocks are, since `move_on`
  };

  [[nodiscard]] Level& at(int level) { return m_levels[static_cast<std::size_t>(level) - 1]; }
  [[nodiscard]] int top() const { return static_cast<int>(m_levels.size()); }
  [[nodiscard]] int open(int level, int above, int slot);
  /// What is left where the paths end, of all open pairs.
  void approach_all(int level);
  bool close_if_far(int level, int index, float least_m);
  void compact(int level);
  void look_into(int level, int index, float least_m);
  void look_at_leaf(int index, float least_m);
  [[nodiscard]] bool is_changed(int level, const Open& pair) const {
    return m_first.is_changed(level, pair.first) || m_second.is_changed(level, pair.second);
  }
  void make_current(int level, int index);

  PathSpheres& m_first;
  PathSpheres& m_second;
  std::vector<Level> m_levels;  ///< from 1 on; the last has the roots, which are always looked into
  std::vector<int> m_found;     ///< leaves, by the last `find`
};

}  // namespace musclebench

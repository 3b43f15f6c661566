#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/effects/no_passage/path_spheres.hpp"
#include "core/effects/no_passage/sphere_lanes.hpp"

namespace musclebench {

/// Two triangles that may come close on their paths.
struct NearPair {
  std::size_t first = 0;  ///< places in their trees
  std::size_t second = 0;
  float approach_m = 0;  ///< no more than this do they come closer
  float left_m = 0;      ///< how far apart they are at least where the paths start
};

/// Finds pairs of triangles of two surfaces that may come close on their paths, and remembers from step to step how far
/// apart they were, so that a step looks only at what has used its distance up: at the front of the tree of all pairs
/// of nodes, between those that are looked into and those that are too far apart (Li and Chen 1998, "Incremental 3D
/// collision detection with hierarchical data structures"). Triangles that touch or slide along each other are in the
/// front one by one, so that most steps need not look at what is around them.
///
/// A step: set the paths, `find`, look at the pairs of `found` and raise their `left_m`, `tell`; all of this again for
/// other paths from the same start; and `move_on` once the last of them are taken. Where only some paths are others,
/// the same `least_m` has to be asked for, as only what they changed is looked at.
class NearPairs {
 public:
  /// Two trees of as many levels, or one twice: then each pair of triangles is there once. Kept by reference.
  NearPairs(PathSpheres& first, PathSpheres& second);

  /// Finds triangles that may come closer than `least_m` on the paths, and some more; only those with a vertex whose
  /// path has changed, where some have since the last time.
  void find(double least_m);
  /// By the last `find`, each pair once.
  [[nodiscard]] std::span<NearPair> found() { return m_found; }
  /// Takes over what was found out about them.
  void tell();
  /// The ends of the paths become starts.
  void move_on();
  /// Of what is open.
  [[nodiscard]] std::size_t bytes() const;

 private:
  /// A pair of nodes that is looked into or, on level 0, of triangles. What each step reads of all pairs is in arrays
  /// of its own.
  struct Open {
    bool is_used = false;     ///< or closed, and to be used again
    bool is_emptied = false;  ///< whether the last pair below was closed since the last time
    bool is_current = false;  ///< whether distances in its block are those where the paths start
    int above = -1;           ///< index of the pair of their parents; -1: the roots
    int slot = 0;             ///< in its block
    int open_below = 0;       ///< how many pairs of its block are open in turn
    /// `left_m` when the block was last current: its distances are too large by what `left_m` has lost since.
    float left_when_current_m = 0;
  };
  /// How far each two children are apart at least where the paths start, m; `nowhere_m`: open.
  struct alignas(32) Block {
    PairDistances left_m = {};
  };
  /// All open pairs of a level.
  struct Level {
    std::vector<int> first;  ///< node of the first tree
    std::vector<int> second;
    std::vector<float> left_m;  ///< least distance where the paths start of what its block has not open in turn
    std::vector<float> left_at_end_m;
    std::vector<Open> open;
    std::vector<Block> blocks;                                  ///< from level 1 on
    std::vector<std::array<int, bvh_width * bvh_width>> below;  ///< from level 2 on, by slot: what is open, or -1
    std::vector<int> free;
    std::vector<int> current;  ///< whose blocks are, since `move_on`
    std::vector<int> emptied;  ///< whose last pair below was closed since the last time
  };
  /// Where a found pair is kept: open by itself, or in a slot of a leaf.
  struct Source {
    int index;
    int slot;       ///< -1: open by itself
    bool may_open;  ///< by itself from now on
  };

  [[nodiscard]] Level& at(int level) { return m_levels[static_cast<std::size_t>(level)]; }
  [[nodiscard]] int top() const { return static_cast<int>(m_levels.size()) - 1; }
  [[nodiscard]] int open(int level, int above, int slot);
  /// Gives what it knows back to the block of its parents.
  void close(int level, int index, float left_m);
  bool close_if_far(int level, int index);
  void find_used_up(int level);
  void compact(int level);
  void look_into(int level, int index);
  void look_at_leaf(int index);
  void look_at_pair(int index);
  void make_current(int level, int index);
  /// Whether what is left is enough for so many steps.
  [[nodiscard]] bool lasts(const NearPair& pair, float steps) const;
  void keep_or_close(int index, const NearPair& pair);

  PathSpheres& m_first;
  PathSpheres& m_second;
  std::vector<Level> m_levels;  ///< the last has the roots, which are always looked into
  float m_least_m = 0;          ///< of the last `find`
  std::vector<int> m_used_up;   ///< open pairs of the level that is looked at
  std::vector<NearPair> m_found;
  std::vector<Source> m_sources;  ///< of `m_found`
  std::vector<int> m_leaves;      ///< that have some of them
};

}  // namespace musclebench

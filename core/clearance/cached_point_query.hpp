#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/bvh/triangle_bvh.hpp"
#include "core/clearance/clearance_cache.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/mesh/morton_order.hpp"

namespace musclebench {

/// Detection node by node on exact surfaces, one a bone. With clearance cache, what is known of a node from before is
/// used: its ball, and about nodes in or near a bone the triangles that were nearest. The contacts are the same to the
/// bit, for any number of threads.
///
/// A `Surface` answers for points in its bone's rest frame, from several threads at once:
/// - `bool is_outside(point, clearance_m)`: free for certain, told cheaply; how far it may move. True for what is not
///   finite. `fetch_clearance(point)`: what that will need begins to come from memory.
/// - `ClosestPoint closest(point)`, `closest_from(point, triangle)` (faster the closer that triangle is): of all
///   triangles at the smallest squared distance the one with the smallest index.
/// - `CandidateList`: what is near a place; `empty()` where nothing is known, as after `clear()`;
///   `list_candidates(point, bound_m, list)` fills it, where the surface is no farther than `bound_m`;
///   `begin_candidate_search(point, list, search)` and `ClosestCandidate finish_candidate_search(point, list, enough_m,
///   search)` use it, by way of a `CandidateSearch`.
/// - `fetch(list)`: what `begin_candidate_search` will need begins to come from memory.
/// - `Clearance clearance_from(point, triangle)`: faster than `closest_from`, and less.
/// - `double distance_m(point, triangle)`.
/// - `bool contains(point, closest)`; `Vec3 outward(point, closest)`: unit, for a point that it contains.
/// - `double free_m(closest)`: about a point that it does not contain, how far it contains nothing.
/// - `double touching_m()`: it contains nothing that is closer to the surface.
/// - `double near_m()`: closer to the surface than this a list saves searches.
template <typename Surface>
class CachedPointQuery {
 public:
  /// `bones` and `surfaces` (in the same order) outlive the detection or its next `reset`. `nodes` is the number of
  /// positions that calls will have.
  void reset(std::span<const Bone> bones, std::span<const Surface> surfaces, std::size_t nodes, bool clearance_cache,
             int threads) {
    m_bones = bones;
    m_surfaces = surfaces;
    m_uses_cache = clearance_cache;
    m_threads = threads;
    forget(nodes);
  }

  void detect(std::span<const RigidMotion> poses, std::span<const Vec3> positions, std::span<const int> nodes,
              std::vector<Contact>& contacts) {
    if (m_uses_cache && positions.size() != m_nodes) {
      forget(positions.size());
    }
    if (m_uses_cache) {
      m_clearance_cache.collect_spent(poses, positions, nodes);
    } else if (!std::equal(nodes.begin(), nodes.end(), m_planned.begin(), m_planned.end())) {
      plan_visits(positions, nodes);
    }
    for (int bone = 0; bone < static_cast<int>(m_surfaces.size()); ++bone) {
      const std::span<const int> asked = m_uses_cache ? m_clearance_cache.spent(bone) : m_visited;
      ask(bone, poses[static_cast<std::size_t>(bone)], positions, asked);
      const auto first_of_bone = static_cast<std::ptrdiff_t>(contacts.size());
      for (std::size_t block = 0; block < m_found_count.size(); ++block) {
        const std::span<const Contact> found = std::span(m_found).subspan(block * block_size, m_found_count[block]);
        contacts.insert(contacts.end(), found.begin(), found.end());
      }
      if (!m_uses_cache) {
        std::sort(contacts.begin() + first_of_bone, contacts.end(),
                  [](const Contact& a, const Contact& b) { return a.node < b.node; });
      }
    }
  }

  [[nodiscard]] std::size_t bytes() const {
    return m_clearance_cache.bytes() + m_node_caches.size() * sizeof(NodeCache) + m_exit_points.size() * sizeof(Vec3);
  }

 private:
  void forget(std::size_t nodes) {
    m_nodes = nodes;
    m_planned.clear();
    m_found.reserve(nodes);
    m_found_count.reserve(blocks_of(nodes));
    if (!m_uses_cache) {
      return;
    }
    m_clearance_cache.reset(m_bones, nodes);
    m_node_caches.assign(m_surfaces.size() * nodes, {});
    m_exit_points.assign(m_node_caches.size(), Vec3::Zero());
  }

  /// Neighbours after each other, which are answered from the same part of a tree. (With clearance cache memory
  /// decides, and balls and lists lie in the order of the nodes.)
  void plan_visits(std::span<const Vec3> positions, std::span<const int> nodes) {
    m_planned.assign(nodes.begin(), nodes.end());
    std::vector<Vec3> points;
    points.reserve(nodes.size());
    for (const int node : nodes) {
      points.push_back(positions[static_cast<std::size_t>(node)]);
    }
    const std::vector<int> order = morton_order(points);
    m_visited.clear();
    for (const int place : order) {
      m_visited.push_back(nodes[static_cast<std::size_t>(place)]);
    }
  }

  /// Every node for itself, so that the answer does not depend on how many threads share them.
  void ask(int bone, const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes) {
    const std::size_t blocks = blocks_of(nodes.size());
    m_found.resize(nodes.size());
    m_found_count.resize(blocks);
    if (m_threads == 1 || blocks < 2) {  // without OpenMP, which allocates even a team of one
      Block scratch;
      for (std::size_t block = 0; block < blocks; ++block) {
        query_block(bone, pose, positions, nodes, block, scratch);
      }
      return;
    }
#pragma omp parallel num_threads(m_threads)
    {
      Block scratch;
#pragma omp for schedule(dynamic, 2)
      for (std::ptrdiff_t block = 0; block < static_cast<std::ptrdiff_t>(blocks); ++block) {
        query_block(bone, pose, positions, nodes, static_cast<std::size_t>(block), scratch);
      }
    }
  }

  /// A node that is asked about.
  struct Asked {
    int node = 0;
    Vec3 point = Vec3::Zero();  ///< rest frame
    bool outside = false;       ///< known to be
    double free_m = 0;          ///< of one that is outside
    /// Where nothing is nearer than this, no surface is between the point and the node's ball.
    double gap_m = 0;
    bool listed = false;  ///< what is near is known from before
  };

  using CandidateSearch = typename Surface::CandidateSearch;

  static constexpr std::size_t block_size = 16;
  static constexpr std::size_t blocks_of(std::size_t nodes) { return (nodes + block_size - 1) / block_size; }

  /// Made once for all blocks of a call.
  struct Block {
    std::array<Asked, block_size> asked;
    std::array<CandidateSearch, block_size> searches;
  };

  /// What a node's answer needs lies in memory that the constraints have just driven out of the caches. So each part of
  /// the work is done for a whole block before the next: the nodes' ways through memory overlap.
  void query_block(int bone, const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes,
                   std::size_t block, Block& scratch) {
    const Surface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    const std::size_t first = block * block_size;
    const std::size_t count = std::min(block_size, nodes.size() - first);
    auto& [asked, searches] = scratch;
    if (m_uses_cache) {
      for (std::size_t next = first + count; next < std::min(first + count + block_size, nodes.size()); ++next) {
        __builtin_prefetch(&node_cache_of(bone, nodes[next]));
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const int node = nodes[first + i];
      Asked& ask = asked[i] = {.node = node, .point = pose.apply_inverse(positions[static_cast<std::size_t>(node)])};
      if (m_uses_cache) {
        __builtin_prefetch(&node_cache_of(bone, ask.node));
      } else {
        ask.outside = surface.is_outside(ask.point, ask.free_m);
      }
    }
    if (m_uses_cache) {
      for (Asked& ask : std::span(asked).first(count)) {
        if (node_cache_of(bone, ask.node).near.empty()) {
          surface.fetch_clearance(ask.point);
        }
      }
      for (Asked& ask : std::span(asked).first(count)) {
        look_up(bone, ask);
      }
      for (std::size_t i = 0; i < count; ++i) {
        if (asked[i].listed) {
          surface.begin_candidate_search(asked[i].point, node_cache_of(bone, asked[i].node).near, searches[i]);
        }
      }
    }
    std::size_t found = 0;
    for (std::size_t i = 0; i < count; ++i) {
      Contact& contact = m_found[first + found];
      if (answer(bone, asked[i], searches[i], contact)) {
        contact.normal = pose.apply_to_direction(contact.normal);
        ++found;
      }
    }
    m_found_count[block] = found;
  }

  void look_up(int bone, Asked& asked) {
    const Surface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    NodeCache& memory = node_cache_of(bone, asked.node);
    if (memory.in_contact) {
      memory.in_contact = false;
      const double touching_m = surface.touching_m();
      // By the triangle itself, whose distance a search would find, too.
      if ((asked.point - m_exit_points[index_of(bone, asked.node)]).squaredNorm() < touching_m * touching_m &&
          surface.distance_m(asked.point, memory.triangle) <= touching_m) {
        asked.outside = true;
        return;
      }
    }
    asked.listed = !memory.near.empty();
    if (!asked.listed && surface.is_outside(asked.point, asked.free_m)) {
      asked.outside = true;
      return;
    }
    asked.gap_m = m_clearance_cache.gap_m(bone, asked.node, asked.point);
    asked.outside = asked.gap_m < 0;  // the sweep is coarser
    asked.listed = asked.listed && !asked.outside;
    if (asked.listed) {
      surface.fetch(memory.near);
    }
  }

  /// Whether the node is in contact. The normal of the contact is left in the rest frame.
  bool answer(int bone, const Asked& asked, CandidateSearch& started, Contact& contact) {
    const Surface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    double free_m = asked.free_m;
    if (!asked.outside) {
      const Answer answer = m_uses_cache ? query_with_cache(bone, asked, started) : search(surface, asked.point);
      free_m = answer.free_m;
      if (answer.inside) {
        contact = {asked.node, bone, answer.closest.distance_m, surface.outward(asked.point, answer.closest)};
        if (m_uses_cache) {
          node_cache_of(bone, asked.node).in_contact = true;
          m_exit_points[index_of(bone, asked.node)] = asked.point + contact.depth_m * contact.normal;
        }
        return true;
      }
    }
    // A ball that it has left stays true, and is better than none.
    if (m_uses_cache && free_m > 0) {
      m_clearance_cache.grant(bone, asked.node, asked.point, free_m);
    }
    return false;
  }

  struct Answer {
    ClosestPoint closest;
    bool inside = false;
    double free_m = 0;  ///< of what is not inside
  };

  static Answer search(const Surface& surface, const Vec3& point) {
    const ClosestPoint closest = surface.closest(point);
    return {closest, surface.contains(point, closest)};
  }

  /// What is remembered of a node and a bone, from the start of a cache line.
  struct alignas(64) NodeCache {
    typename Surface::CandidateList near;
    int triangle = -1;        ///< one that was near at the last search
    bool in_contact = false;  ///< when it was last searched for: a response puts it to `m_exit_points`
    // Where a node moves farther in a step than its lists reach, they are made for nothing: after each that was, twice
    // as many searches go without.
    bool has_served = false;
    std::uint8_t wasted = 0;  ///< lists in a row
    std::uint8_t pause = 0;   ///< searches that are still to go without a list

    /// Before a search; `had_one`: a list, which did not answer. Returns whether the next one is worth its making.
    bool forget_list(bool had_one) {
      constexpr std::uint8_t most_wasted = 5;
      near.clear();
      if (had_one) {
        wasted = has_served ? 0 : std::min<std::uint8_t>(wasted + 1, most_wasted);
        pause = static_cast<std::uint8_t>((1U << wasted) - 1);
      }
      has_served = false;
      const bool is_list_worth_it = pause == 0;
      pause -= is_list_worth_it ? 0 : 1;
      return is_list_worth_it;
    }
  };

  static_assert(sizeof(NodeCache) == 64 || sizeof(typename Surface::CandidateList) > 56);

  [[nodiscard]] std::size_t index_of(int bone, int node) const {
    return static_cast<std::size_t>(bone) * m_nodes + static_cast<std::size_t>(node);
  }
  NodeCache& node_cache_of(int bone, int node) { return m_node_caches[index_of(bone, node)]; }

  /// From what was near when the node was last searched for, where that is enough. `started` is where it is listed.
  Answer query_with_cache(int bone, const Asked& asked, CandidateSearch& started) {
    const Surface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    const Vec3& point = asked.point;
    NodeCache& memory = node_cache_of(bone, asked.node);
    Answer answer;
    const auto take_listed = [&](CandidateSearch& begun) {
      const ClosestCandidate listed = surface.finish_candidate_search(point, memory.near, asked.gap_m, begun);
      if (listed.clearance_m > 0) {
        answer.free_m = listed.clearance_m;
        return true;
      }
      memory.triangle = listed.closest.triangle;
      if (listed.certain) {
        answer = {listed.closest, surface.contains(point, listed.closest)};
        answer.free_m = answer.inside ? 0 : surface.free_m(listed.closest);
      }
      return listed.certain;
    };
    if (asked.listed && take_listed(started)) {
      memory.has_served = true;
      return answer;
    }
    const bool is_list_worth_it = memory.forget_list(asked.listed);
    if (asked.listed && surface.is_outside(point, answer.free_m)) {
      return answer;
    }
    const auto take_new_list = [&] {
      const double bound_m =
          !is_list_worth_it || memory.triangle < 0 ? unknown : surface.distance_m(point, memory.triangle);
      if (bound_m < surface.near_m()) {
        surface.list_candidates(point, bound_m, memory.near);
      }
      if (memory.near.empty()) {
        return false;
      }
      CandidateSearch begun;
      surface.begin_candidate_search(point, memory.near, begun);
      return take_listed(begun);
    };
    // A list is worth its making for a node that stays near; of the others it need not be known what is closest.
    const bool stays_near = m_clearance_cache.radius_m(bone, asked.node) < surface.near_m();
    if (stays_near && take_new_list()) {
      return answer;
    }
    if (asked.gap_m < unknown) {
      const Clearance clearance = surface.clearance_from(point, std::max(memory.triangle, 0));
      if (clearance.distance_m > 0) {
        memory.triangle = clearance.triangle;
      }
      if (clearance.distance_m > asked.gap_m) {
        answer.free_m = clearance.distance_m;
        return answer;
      }
    }
    if (!stays_near && take_new_list()) {
      return answer;
    }
    answer.closest = memory.triangle < 0 ? surface.closest(point) : surface.closest_from(point, memory.triangle);
    answer.inside = surface.contains(point, answer.closest);
    answer.free_m = answer.inside ? 0 : surface.free_m(answer.closest);
    memory.triangle = answer.closest.triangle;
    memory.near.clear();
    // A node that leaves a larger ball is too far from here for a list.
    if (is_list_worth_it && (answer.inside || answer.closest.distance_m < surface.near_m())) {
      surface.list_candidates(point, answer.closest.distance_m, memory.near);
    }
    return answer;
  }

  std::span<const Bone> m_bones;
  std::span<const Surface> m_surfaces;
  bool m_uses_cache = false;
  int m_threads = 1;
  std::size_t m_nodes = 0;  ///< that the budgets are for
  ClearanceCache m_clearance_cache;
  std::vector<NodeCache> m_node_caches;  ///< by bone, then node
  /// In the same order, of those in contact: the point of the surface that was closest, in the rest frame.
  std::vector<Vec3> m_exit_points;
  static constexpr double unknown = std::numeric_limits<double>::infinity();
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<int> m_planned;  ///< the nodes that the visits are of
  std::vector<int> m_visited;  ///< the same in the order of the visits
  /// Of each block of the nodes that are asked about the contacts, from the place of its first node on.
  std::vector<Contact> m_found;
  std::vector<std::size_t> m_found_count;
};

}  // namespace musclebench

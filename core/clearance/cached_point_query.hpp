#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/query_surface.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/mesh/morton_order.hpp"

namespace musclebench {

/// Contacts of single nodes with exact surfaces, one a bone. With the clearance cache a query starts from what earlier
/// queries of the same node and bone have left: a safe sphere, and for nodes in or near a bone a list of candidate
/// triangles. The cache changes the time only: the contacts are the same to the bit, for any number of threads.
/// reports/performance/clearance_cache.md describes the steps of a query and why each is exact.
template <QuerySurface Surface>
class CachedPointQuery {
 public:
  /// `bones` and `surfaces` (in the same order) outlive this object or its next `reset`. `nodes` is the number of
  /// positions that calls will have.
  void reset(std::span<const Bone> bones, std::span<const Surface> surfaces, std::size_t nodes, bool clearance_cache,
             int threads) {
    m_bones = bones;
    m_surfaces = surfaces;
    m_uses_cache = clearance_cache;
    m_threads = threads;
    clear_caches(nodes);
  }

  /// Appends the contacts of `nodes` (ascending), ordered by bone, then node. `positions` in the world frame, in
  /// metres; a position that is not finite has no contact.
  void detect(std::span<const RigidMotion> poses, std::span<const Vec3> positions, std::span<const int> nodes,
              std::vector<Contact>& contacts) {
    if (m_uses_cache && positions.size() != m_nodes) {
      clear_caches(positions.size());
    }
    if (m_uses_cache) {
      m_clearance_cache.collect_expired(poses, positions, nodes);
    } else if (!std::equal(nodes.begin(), nodes.end(), m_ordered.begin(), m_ordered.end())) {
      order_nodes(positions, nodes);
    }
    for (int bone = 0; bone < static_cast<int>(m_surfaces.size()); ++bone) {
      const std::span<const int> queried = m_uses_cache ? m_clearance_cache.expired(bone) : m_query_order;
      query_bone(bone, poses[static_cast<std::size_t>(bone)], positions, queried);
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
  using CandidateSearch = typename Surface::CandidateSearch;

  /// One query of a node against a bone.
  struct NodeQuery {
    int node = 0;
    Vec3 point = Vec3::Zero();      ///< rest frame
    bool outside = false;           ///< settled without a search
    double clearance_m = 0;         ///< where `outside`; 0: unknown
    double distance_outside_m = 0;  ///< ClearanceCache::distance_outside_m
    bool has_candidates = false;    ///< the node's candidate list is to be searched
  };

  struct Answer {
    ClosestPoint closest;
    PointSide side;
  };

  /// What earlier queries of a node and a bone have left; starts at a cache line.
  struct alignas(64) NodeCache {
    typename Surface::CandidateList candidates;
    int triangle = -1;        ///< a triangle that was near the node
    bool in_contact = false;  ///< in the last query, whose contact leads to `m_exit_points`
    // Exponential back-off: after k unused candidate lists in a row, skip building one for 2^k - 1 searches. A node
    // that moves farther in a step than its list reaches would build each of them in vain.
    bool list_was_used = false;
    std::uint8_t unused_lists = 0;
    std::uint8_t searches_to_skip = 0;

    /// Drops the list before a search. `has_failed`: there was one and it did not answer. Returns whether to build
    /// another.
    bool drop_list(bool has_failed) {
      constexpr std::uint8_t most_unused = 5;
      candidates.clear();
      if (has_failed) {
        unused_lists = list_was_used ? 0 : std::min<std::uint8_t>(unused_lists + 1, most_unused);
        searches_to_skip = static_cast<std::uint8_t>((1U << unused_lists) - 1);
      }
      list_was_used = false;
      const bool builds_list = searches_to_skip == 0;
      searches_to_skip -= builds_list ? 0 : 1;
      return builds_list;
    }
  };
  static_assert(sizeof(NodeCache) == 64 || sizeof(typename Surface::CandidateList) > 56);

  static constexpr int no_triangle = -1;
  static constexpr double unknown_m = std::numeric_limits<double>::infinity();
  static constexpr std::size_t block_size = 16;
  static constexpr std::size_t blocks_of(std::size_t nodes) { return (nodes + block_size - 1) / block_size; }

  /// Scratch memory of a thread.
  struct Block {
    std::array<NodeQuery, block_size> queries;
    std::array<CandidateSearch, block_size> searches;
  };

  [[nodiscard]] std::size_t index_of(int bone, int node) const {
    return static_cast<std::size_t>(bone) * m_nodes + static_cast<std::size_t>(node);
  }
  NodeCache& node_cache_of(int bone, int node) { return m_node_caches[index_of(bone, node)]; }

  void clear_caches(std::size_t nodes) {
    m_nodes = nodes;
    m_ordered.clear();
    m_found.reserve(nodes);
    m_found_count.reserve(blocks_of(nodes));
    if (!m_uses_cache) {
      return;
    }
    m_clearance_cache.reset(m_bones, nodes);
    m_node_caches.assign(m_surfaces.size() * nodes, {});
    m_exit_points.assign(m_node_caches.size(), Vec3::Zero());
  }

  /// Morton order, so that successive searches go through the same part of the tree. With the cache the order of the
  /// nodes is better: spheres and candidate lists lie in memory in that order.
  void order_nodes(std::span<const Vec3> positions, std::span<const int> nodes) {
    m_ordered.assign(nodes.begin(), nodes.end());
    std::vector<Vec3> points;
    points.reserve(nodes.size());
    for (const int node : nodes) {
      points.push_back(positions[static_cast<std::size_t>(node)]);
    }
    m_query_order.clear();
    for (const int index : morton_order(points)) {
      m_query_order.push_back(nodes[static_cast<std::size_t>(index)]);
    }
  }

  /// No query depends on another, so that the answers do not depend on the number of threads.
  void query_bone(int bone, const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes) {
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

  /// The constraints have just driven all that a query reads out of the CPU's caches. Each stage is therefore done for
  /// a whole block before the next one and prefetches for it, so that cache misses overlap.
  void query_block(int bone, const RigidMotion& pose, std::span<const Vec3> positions, std::span<const int> nodes,
                   std::size_t block, Block& scratch) {
    const Surface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    const std::size_t first = block * block_size;
    const std::size_t count = std::min(block_size, nodes.size() - first);
    auto& [queries, searches] = scratch;
    if (m_uses_cache) {
      for (std::size_t next = first + count; next < std::min(first + count + block_size, nodes.size()); ++next) {
        __builtin_prefetch(&node_cache_of(bone, nodes[next]));
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const int node = nodes[first + i];
      NodeQuery& query =
          queries[i] = {.node = node, .point = pose.apply_inverse(positions[static_cast<std::size_t>(node)])};
      if (m_uses_cache) {
        __builtin_prefetch(&node_cache_of(bone, query.node));
      } else {
        query.outside = surface.is_outside(query.point, query.clearance_m);
      }
    }
    if (m_uses_cache) {
      for (const NodeQuery& query : std::span(queries).first(count)) {
        const auto& candidates = node_cache_of(bone, query.node).candidates;
        if (candidates.empty()) {
          surface.prefetch(query.point, candidates);
        }
      }
      for (NodeQuery& query : std::span(queries).first(count)) {
        look_up(bone, query);
      }
      for (std::size_t i = 0; i < count; ++i) {
        if (queries[i].has_candidates) {
          surface.begin_candidate_search(queries[i].point, node_cache_of(bone, queries[i].node).candidates,
                                         searches[i]);
        }
      }
    }
    std::size_t found = 0;
    for (std::size_t i = 0; i < count; ++i) {
      Contact& contact = m_found[first + found];
      if (answer_query(bone, queries[i], searches[i], contact)) {
        contact.normal = pose.apply_to_direction(contact.normal);
        ++found;
      }
    }
    m_found_count[block] = found;
  }

  /// Settles the query from the cache alone where that is possible, else prefetches its candidates.
  void look_up(int bone, NodeQuery& query) {
    const Surface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    NodeCache& cache = node_cache_of(bone, query.node);
    if (cache.in_contact) {
      cache.in_contact = false;
      const double touching_m = surface.touching_m();
      // A response has moved the node to the surface. One triangle within the touching distance proves that: a search
      // would find none that is farther away.
      if ((query.point - m_exit_points[index_of(bone, query.node)]).squaredNorm() < touching_m * touching_m &&
          surface.distance_m(query.point, cache.triangle) <= touching_m) {
        query.outside = true;
        return;
      }
    }
    query.has_candidates = !cache.candidates.empty();
    if (!query.has_candidates && surface.is_outside(query.point, query.clearance_m)) {
      query.outside = true;
      return;
    }
    query.distance_outside_m = m_clearance_cache.distance_outside_m(bone, query.node, query.point);
    query.outside = query.distance_outside_m < 0;  // in double precision; the sweep's test is coarser
    query.has_candidates = query.has_candidates && !query.outside;
    if (query.has_candidates) {
      surface.prefetch(query.point, cache.candidates);
    }
  }

  /// Returns whether the node is in contact; the normal of `contact` is in the rest frame.
  bool answer_query(int bone, const NodeQuery& query, CandidateSearch& begun, Contact& contact) {
    const Surface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    double clearance_m = query.clearance_m;
    if (!query.outside) {
      const Answer answer = m_uses_cache ? query_with_cache(bone, query, begun) : search(surface, query.point);
      clearance_m = answer.side.clearance_m;
      if (answer.side.inside) {
        contact = {query.node, bone, answer.closest.distance_m, surface.outward(query.point, answer.closest)};
        if (m_uses_cache) {
          node_cache_of(bone, query.node).in_contact = true;
          m_exit_points[index_of(bone, query.node)] = query.point + contact.depth_m * contact.normal;
        }
        return true;
      }
    }
    // Without a new sphere the old one is kept: it still holds if the node returns.
    if (m_uses_cache && clearance_m > 0) {
      m_clearance_cache.store(bone, query.node, query.point, clearance_m);
    }
    return false;
  }

  static Answer search(const Surface& surface, const Vec3& point, int triangle = no_triangle) {
    const ClosestPoint closest = surface.closest(point, triangle);
    return {closest, surface.side(point, closest)};
  }

  /// Takes the answer from a begun search among the node's candidates, if they are enough to tell.
  static bool answer_from_candidates(const Surface& surface, const NodeQuery& query, NodeCache& cache,
                                     CandidateSearch& begun, Answer& answer) {
    const ClosestCandidate found = surface.finish_candidate_search(cache.candidates, query.distance_outside_m, begun);
    if (found.clearance_m > 0) {
      answer.side.clearance_m = found.clearance_m;
      return true;
    }
    cache.triangle = found.closest.triangle;
    if (found.certain) {
      answer = {found.closest, surface.side(query.point, found.closest)};
    }
    return found.certain;
  }

  /// Lists candidates about the query point, if it is near the surface for certain, and takes the answer from them.
  static bool answer_from_new_candidates(const Surface& surface, const NodeQuery& query, NodeCache& cache,
                                         Answer& answer) {
    const double bound_m = cache.triangle < 0 ? unknown_m : surface.distance_m(query.point, cache.triangle);
    if (bound_m < surface.near_m()) {
      surface.list_candidates(query.point, bound_m, cache.candidates);
    }
    if (cache.candidates.empty()) {
      return false;
    }
    CandidateSearch begun;
    surface.begin_candidate_search(query.point, cache.candidates, begun);
    return answer_from_candidates(surface, query, cache, begun, answer);
  }

  /// From the cheapest source to the dearest: candidates, clearance grid, new candidates, clearance, full search.
  /// `begun` is the search among the candidates, if there are any.
  Answer query_with_cache(int bone, const NodeQuery& query, CandidateSearch& begun) {
    const Surface& surface = m_surfaces[static_cast<std::size_t>(bone)];
    NodeCache& cache = node_cache_of(bone, query.node);
    Answer answer;
    if (query.has_candidates && answer_from_candidates(surface, query, cache, begun, answer)) {
      cache.list_was_used = true;
      return answer;
    }
    const bool builds_list = cache.drop_list(query.has_candidates);
    if (query.has_candidates && surface.is_outside(query.point, answer.side.clearance_m)) {
      return answer;
    }
    // A node that leaves a large safe sphere was far from the surface: a lower bound of the distance may do, which is
    // cheaper than a list.
    const bool stays_near = m_clearance_cache.radius_m(bone, query.node) < surface.near_m();
    if (stays_near && builds_list && answer_from_new_candidates(surface, query, cache, answer)) {
      return answer;
    }
    if (query.distance_outside_m < unknown_m) {
      const Clearance clearance = surface.clearance(query.point, std::max(cache.triangle, 0));
      if (clearance.distance_m > 0) {
        cache.triangle = clearance.triangle;
      }
      if (clearance.distance_m > query.distance_outside_m) {
        answer.side.clearance_m = clearance.distance_m;
        return answer;
      }
    }
    if (!stays_near && builds_list && answer_from_new_candidates(surface, query, cache, answer)) {
      return answer;
    }
    answer = search(surface, query.point, cache.triangle);
    cache.triangle = answer.closest.triangle;
    cache.candidates.clear();
    // A node that leaves a larger safe sphere is too far from here for a list.
    if (builds_list && (answer.side.inside || answer.closest.distance_m < surface.near_m())) {
      surface.list_candidates(query.point, answer.closest.distance_m, cache.candidates);
    }
    return answer;
  }

  std::span<const Bone> m_bones;
  std::span<const Surface> m_surfaces;
  bool m_uses_cache = false;
  int m_threads = 1;
  std::size_t m_nodes = 0;  ///< number of nodes in the caches
  ClearanceCache m_clearance_cache;
  std::vector<NodeCache> m_node_caches;  ///< by bone, then node
  std::vector<Vec3> m_exit_points;       ///< in the same order: where the last contact leads, rest frame
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<int> m_ordered;              ///< the nodes that m_query_order was made of
  std::vector<int> m_query_order;          ///< without the cache
  std::vector<Contact> m_found;            ///< of a block from the index of its first node on
  std::vector<std::size_t> m_found_count;  ///< by block
};

}  // namespace musclebench

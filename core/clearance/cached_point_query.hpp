#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/clearance/bone_structure.hpp"
#include "core/clearance/query_surface.hpp"

namespace musclebench {

/// Finds contacts of single nodes with the exact surface of one bone. Depth is the distance to the surface, in metres.
///
/// With the clearance cache, a query starts from earlier results of the same node. These are its safe sphere, and for
/// nodes in or near the bone a list of candidate triangles. The cache changes the time and no bit of the contacts.
/// reports/performance/clearance_cache.md describes the steps of a query and why each is exact.
///
/// Several threads may call `detect` at once with different nodes.
template <QuerySurface Surface>
class CachedPointQuery final : public BoneStructure {
 public:
  explicit CachedPointQuery(Surface surface) : m_surface(std::move(surface)) {}

  [[nodiscard]] AnswerBound answer_bound() const override { return m_surface.answer_bound(); }
  [[nodiscard]] std::size_t bytes() const override {
    return m_surface.bytes() + m_node_caches.size() * sizeof(NodeCache) + m_exit_points.size() * sizeof(Vec3);
  }

  void reset_nodes(std::size_t nodes) override {
    m_node_caches.assign(nodes, {});
    m_exit_points.assign(nodes, Vec3::Zero());
  }

  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) override {
    Scratch scratch;
    for (std::size_t first = 0; first < batch.nodes.size(); first += block_size) {
      query_block(batch, first, scratch, contacts);
    }
  }

 private:
  using CandidateSearch = typename Surface::CandidateSearch;

  /// A query of one node against the bone.
  struct NodeQuery {
    int node = 0;
    Vec3 point = Vec3::Zero();      ///< rest frame
    bool outside = false;           ///< known without a search
    double clearance_m = 0;         ///< if `outside`; 0: unknown
    double distance_outside_m = 0;  ///< ClearanceCache::distance_outside_m
    bool has_candidates = false;    ///< the node's candidate list is to be searched
  };

  struct Answer {
    ClosestPoint closest;
    PointSide side;
  };

  /// Results of earlier queries of a node. Aligned to a cache line.
  struct alignas(64) NodeCache {
    typename Surface::CandidateList candidates;
    int triangle = -1;        ///< a triangle that was near the node
    bool in_contact = false;  ///< the last query found a contact, which leads to `m_exit_points`
    // Exponential back-off: after k unused candidate lists in a row, skip building one for 2^k - 1 searches. A node
    // that moves farther in a step than its list reaches would build each of them in vain.
    bool list_was_used = false;
    std::uint8_t unused_lists = 0;
    std::uint8_t searches_to_skip = 0;

    /// Drops the list before a search. `has_failed`: there was a list and it did not suffice. Returns whether to build
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

  struct Scratch {
    std::array<NodeQuery, block_size> queries;
    std::array<CandidateSearch, block_size> searches;
  };

  NodeCache& cache_of(int node) { return m_node_caches[static_cast<std::size_t>(node)]; }
  Vec3& exit_point_of(int node) { return m_exit_points[static_cast<std::size_t>(node)]; }

  /// The constraints have just evicted from the CPU's caches all memory that a query reads. Each stage therefore
  /// handles a whole block and prefetches for the next stage, so that cache misses overlap.
  void query_block(const NodeBatch& batch, std::size_t first, Scratch& scratch, std::vector<Contact>& contacts) {
    const std::span<const int> nodes = batch.nodes.subspan(first, std::min(block_size, batch.nodes.size() - first));
    const std::span<NodeQuery> queries = std::span(scratch.queries).first(nodes.size());
    if (batch.clearances != nullptr) {
      const std::span<const int> after = batch.nodes.subspan(first + nodes.size());
      for (const int node : after.first(std::min(block_size, after.size()))) {
        __builtin_prefetch(&cache_of(node));
      }
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      NodeQuery& query = queries[i] = {
          .node = nodes[i], .point = batch.pose.apply_inverse(batch.positions[static_cast<std::size_t>(nodes[i])])};
      if (batch.clearances != nullptr) {
        __builtin_prefetch(&cache_of(query.node));
      } else {
        query.outside = m_surface.is_outside(query.point, query.clearance_m);
      }
    }
    if (batch.clearances != nullptr) {
      for (const NodeQuery& query : queries) {
        const auto& candidates = cache_of(query.node).candidates;
        if (candidates.empty()) {
          m_surface.prefetch(query.point, candidates);
        }
      }
      for (NodeQuery& query : queries) {
        look_up(batch, query);
      }
      for (std::size_t i = 0; i < queries.size(); ++i) {
        if (queries[i].has_candidates) {
          m_surface.begin_candidate_search(queries[i].point, cache_of(queries[i].node).candidates, scratch.searches[i]);
        }
      }
    }
    for (std::size_t i = 0; i < queries.size(); ++i) {
      answer_query(batch, queries[i], scratch.searches[i], contacts);
    }
  }

  /// Answers the query from the cache alone if possible, otherwise prefetches its candidates.
  void look_up(const NodeBatch& batch, NodeQuery& query) {
    NodeCache& cache = cache_of(query.node);
    if (cache.in_contact) {
      cache.in_contact = false;
      const double touching_m = m_surface.touching_m();
      // A response has moved the node to the surface. One triangle within the touching distance proves it: a search
      // would find a triangle at most as far away.
      if ((query.point - exit_point_of(query.node)).squaredNorm() < touching_m * touching_m &&
          m_surface.distance_m(query.point, cache.triangle) <= touching_m) {
        query.outside = true;
        return;
      }
    }
    query.has_candidates = !cache.candidates.empty();
    if (!query.has_candidates && m_surface.is_outside(query.point, query.clearance_m)) {
      query.outside = true;
      return;
    }
    query.distance_outside_m = batch.clearances->distance_outside_m(batch.bone, query.node, query.point);
    query.outside = query.distance_outside_m < 0;  // in double precision; the sweep's test is coarser
    query.has_candidates = query.has_candidates && !query.outside;
    if (query.has_candidates) {
      m_surface.prefetch(query.point, cache.candidates);
    }
  }

  void answer_query(const NodeBatch& batch, const NodeQuery& query, CandidateSearch& begun,
                    std::vector<Contact>& contacts) {
    const bool uses_cache = batch.clearances != nullptr;
    double clearance_m = query.clearance_m;
    if (!query.outside) {
      const Answer answer = uses_cache ? query_with_cache(batch, query, begun) : search(query.point);
      clearance_m = answer.side.clearance_m;
      if (answer.side.inside) {
        const double depth_m = answer.closest.distance_m;
        const Vec3 normal = m_surface.outward(query.point, answer.closest);
        if (uses_cache) {
          cache_of(query.node).in_contact = true;
          exit_point_of(query.node) = query.point + depth_m * normal;
        }
        contacts.push_back({query.node, batch.bone, depth_m, batch.pose.apply_to_direction(normal)});
        return;
      }
    }
    // Without a new sphere the old one stays: it is still valid if the node returns.
    if (uses_cache && clearance_m > 0) {
      batch.clearances->store(batch.bone, query.node, query.point, clearance_m);
    }
  }

  [[nodiscard]] Answer search(const Vec3& point, int triangle = no_triangle) const {
    const ClosestPoint closest = m_surface.closest(point, triangle);
    return {closest, m_surface.side(point, closest)};
  }

  /// Takes the answer from a search among the node's candidates that was begun, if the candidates suffice.
  bool answer_from_candidates(const NodeQuery& query, NodeCache& cache, CandidateSearch& begun, Answer& answer) const {
    const ClosestCandidate found = m_surface.finish_candidate_search(cache.candidates, query.distance_outside_m, begun);
    if (found.clearance_m > 0) {
      answer.side.clearance_m = found.clearance_m;
      return true;
    }
    cache.triangle = found.closest.triangle;
    if (found.certain) {
      answer = {found.closest, m_surface.side(query.point, found.closest)};
    }
    return found.certain;
  }

  /// Lists candidates around the query point if it is certainly near the surface, and takes the answer from them.
  bool answer_from_new_candidates(const NodeQuery& query, NodeCache& cache, Answer& answer) const {
    const double bound_m = cache.triangle < 0 ? unknown_m : m_surface.distance_m(query.point, cache.triangle);
    if (bound_m < m_surface.near_m()) {
      m_surface.list_candidates(query.point, bound_m, cache.candidates);
    }
    if (cache.candidates.empty()) {
      return false;
    }
    CandidateSearch begun;
    m_surface.begin_candidate_search(query.point, cache.candidates, begun);
    return answer_from_candidates(query, cache, begun, answer);
  }

  /// Tries sources from the cheapest to the most expensive: candidates, clearance grid, new candidates, clearance, full
  /// search. `begun` is the search among the candidates, if there are any.
  Answer query_with_cache(const NodeBatch& batch, const NodeQuery& query, CandidateSearch& begun) {
    NodeCache& cache = cache_of(query.node);
    Answer answer;
    if (query.has_candidates && answer_from_candidates(query, cache, begun, answer)) {
      cache.list_was_used = true;
      return answer;
    }
    const bool builds_list = cache.drop_list(query.has_candidates);
    if (query.has_candidates && m_surface.is_outside(query.point, answer.side.clearance_m)) {
      return answer;
    }
    // A node that leaves a large safe sphere was far from the surface. A lower bound of the distance may then suffice,
    // which is cheaper than a list.
    const bool stays_near = batch.clearances->radius_m(batch.bone, query.node) < m_surface.near_m();
    if (stays_near && builds_list && answer_from_new_candidates(query, cache, answer)) {
      return answer;
    }
    if (query.distance_outside_m < unknown_m) {
      const Clearance clearance = m_surface.clearance(query.point, std::max(cache.triangle, 0));
      if (clearance.distance_m > 0) {
        cache.triangle = clearance.triangle;
      }
      if (clearance.distance_m > query.distance_outside_m) {
        answer.side.clearance_m = clearance.distance_m;
        return answer;
      }
    }
    if (!stays_near && builds_list && answer_from_new_candidates(query, cache, answer)) {
      return answer;
    }
    answer = search(query.point, cache.triangle);
    cache.triangle = answer.closest.triangle;
    cache.candidates.clear();
    // A node that leaves a larger safe sphere is too far from here for a list.
    if (builds_list && (answer.side.inside || answer.closest.distance_m < m_surface.near_m())) {
      m_surface.list_candidates(query.point, answer.closest.distance_m, cache.candidates);
    }
    return answer;
  }

  Surface m_surface;
  std::vector<NodeCache> m_node_caches;  ///< by node
  std::vector<Vec3> m_exit_points;       ///< by node: the surface point to which the last contact leads, rest frame
};

}  // namespace musclebench

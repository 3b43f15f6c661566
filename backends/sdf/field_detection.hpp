#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/clearance/clearance_cache.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// Across a hole of a surface the side changes where no surface is: then a distance says nothing of how far it is free.
inline bool are_closed(std::span<const Bone> bones) {
  return std::all_of(bones.begin(), bones.end(), [](const Bone& bone) { return is_closed(bone.surface.mesh); });
}

/// Detection by fields, one a bone: finds the nodes that have to be queried and deals them out to threads. Its
/// memory is kept, so that a frame allocates nothing.
class FieldDetection {
 public:
  /// Nodes in ascending order that one thread queries in one bone's field.
  struct Share {
    int bone;
    std::span<const int> nodes;
  };

  /// `bones` outlive the detection or its next `reset`. `nodes`: positions that calls will have.
  void reset(std::span<const Bone> bones, std::size_t nodes, bool with_cache) {
    m_bones = bones;
    m_has_cache = with_cache;
    if (m_has_cache) {
      m_clearance_cache.reset(bones, nodes);
    }
  }

  /// Then all nodes that are queried have no clearance, or have left theirs, and are to be given a new one.
  [[nodiscard]] bool has_cache() const { return m_has_cache; }
  [[nodiscard]] ClearanceCache& clearance_cache() { return m_clearance_cache; }
  [[nodiscard]] std::size_t bytes() const { return m_has_cache ? m_clearance_cache.bytes() : 0; }

  /// Calls `detect(share, contacts)` for all nodes that have to be queried, from several threads at once where a
  /// thread more pays. Appends to `contacts` in the order of bones and nodes: the same for any number of threads.
  template <typename Detect>
  void detect(std::span<const RigidMotion> poses, std::span<const Vec3> positions, std::span<const int> nodes,
              int threads, const Detect& detect, std::vector<Contact>& contacts) {
    if (m_has_cache) {
      if (positions.size() != m_clearance_cache.nodes()) {
        m_clearance_cache.reset(m_bones, positions.size());
      }
      m_clearance_cache.collect_expired(poses, positions, nodes);
    }
    deal_out(nodes, threads);
    // Without OpenMP where a share a bone is all there is: it allocates even a team of one.
    if (m_shares.size() == m_bones.size()) {
      for (const Share& share : m_shares) {
        detect(share, contacts);
      }
      return;
    }
    while (m_found.size() < m_shares.size()) {
      m_found.emplace_back().reserve(nodes_a_share);
    }
    // Without a cache a thread gets the same shares in every step, whose cells are in its cache.
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (std::size_t n = 0; n < m_shares.size(); ++n) {
      m_found[n].clear();
      detect(m_shares[n], m_found[n]);
    }
    for (std::size_t n = 0; n < m_shares.size(); ++n) {
      contacts.insert(contacts.end(), m_found[n].begin(), m_found[n].end());
    }
  }

 private:
  /// Enough for a thread to be worth its start: some microseconds of work.
  static constexpr std::size_t nodes_a_share = 512;

  /// In the order of the contacts: a share a bone, or several where a thread more pays.
  void deal_out(std::span<const int> nodes, int threads) {
    m_shares.clear();
    for (int bone = 0; bone < static_cast<int>(m_bones.size()); ++bone) {
      std::span<const int> queried = m_has_cache ? m_clearance_cache.expired(bone) : nodes;
      while (threads > 1 && queried.size() > nodes_a_share) {
        m_shares.push_back({bone, queried.first(nodes_a_share)});
        queried = queried.subspan(nodes_a_share);
      }
      m_shares.push_back({bone, queried});
    }
  }

  std::span<const Bone> m_bones;
  bool m_has_cache = false;
  ClearanceCache m_clearance_cache;
  std::vector<Share> m_shares;
  std::vector<std::vector<Contact>> m_found;  ///< by share
};

}  // namespace musclebench

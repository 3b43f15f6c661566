#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Deals out the nodes that fields are asked about to threads. Its memory is kept, so that a frame allocates nothing.
class NodeShares {
 public:
  /// Nodes in ascending order that one thread asks one bone about.
  struct Share {
    int bone;
    std::span<const int> nodes;
  };

  /// Calls `detect(share, contacts)` for all nodes that `asked(bone)` names, from several threads at once where a
  /// thread more pays. Appends to `contacts` in the order of bones and nodes: the same for any number of threads.
  template <typename Asked, typename Detect>
  void detect(std::size_t bones, int threads, const Asked& asked, const Detect& detect,
              std::vector<Contact>& contacts) {
    deal_out(bones, threads, asked);
    // Without OpenMP where a share a bone is all there is: it allocates even a team of one.
    if (m_shares.size() == bones) {
      for (const Share& share : m_shares) {
        detect(share, contacts);
      }
      return;
    }
    while (m_found.size() < m_shares.size()) {
      m_found.emplace_back().reserve(nodes_a_share);
    }
    // Without budgets a thread gets the same shares in every step, whose cells are in its cache.
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
  template <typename Asked>
  void deal_out(std::size_t bones, int threads, const Asked& asked) {
    m_shares.clear();
    for (std::size_t bone = 0; bone < bones; ++bone) {
      std::span<const int> nodes = asked(static_cast<int>(bone));
      while (threads > 1 && nodes.size() > nodes_a_share) {
        m_shares.push_back({static_cast<int>(bone), nodes.first(nodes_a_share)});
        nodes = nodes.subspan(nodes_a_share);
      }
      m_shares.push_back({static_cast<int>(bone), nodes});
    }
  }

  std::vector<Share> m_shares;
  std::vector<std::vector<Contact>> m_found;  ///< by share
};

}  // namespace musclebench

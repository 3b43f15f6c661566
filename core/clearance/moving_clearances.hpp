#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// Clearance cache between deforming muscles: a node that was found at distance d from the muscles that touch its own
/// needs no query until it and the surfaces near it may have moved by d towards each other. Relative motion is bounded
/// for clusters of nodes, so that a motion that neighbouring muscles share costs nothing
/// (reports/performance/muscle_contact.md derives the bounds). It changes no contact.
class MovingClearances {
 public:
  /// Then no node has a clearance.
  explicit MovingClearances(const TouchingMuscles& muscles);

  /// Takes a step to `positions` (of all nodes, world frame, m) and finds the nodes that have no clearance left. The
  /// same for any number of threads.
  void update(std::span<const Vec3> positions, int threads);

  /// Those of muscles that touch others; by cluster, always in the same order. Valid until the next `update`.
  [[nodiscard]] std::span<const int> expired() const { return m_expired; }

  /// How far the relative motion of an expired node may exceed its clearance: where the surface is now farther away
  /// than this, the node is still free. Infinite for one that had none.
  [[nodiscard]] double excess_travel_m(int node) const {
    const Membership& membership = m_memberships[static_cast<std::size_t>(node)];
    return m_clusters[membership.cluster].travel_m - m_expires_at_m[membership.member];
  }

  /// The node is at least this far from all muscles beside its own; 0: it is in one. Different nodes may be stored by
  /// several threads at once.
  void store(int node, double clearance_m);

  [[nodiscard]] std::size_t bytes() const;

 private:
  /// The cluster of a node and its index in m_members; no cluster where its muscle touches no other.
  struct Membership {
    std::size_t cluster = std::numeric_limits<std::size_t>::max();
    std::size_t member = 0;
  };
  struct Cluster {
    std::size_t first = 0;  ///< in m_members: its own nodes, then the other corners of their triangles
    std::size_t last_own = 0;
    std::size_t last = 0;
    int muscle = 0;
    double travel_m = 0;            ///< sum over all steps of the largest relative motion to a cluster near it
    Eigen::AlignedBox3d box;        ///< at the last search for neighbours
    std::vector<std::size_t> near;  ///< of muscles beside its own, ascending
  };

  /// How the nodes of a cluster moved in the last step.
  struct Motion {
    Vec3 middle_m = Vec3::Zero();  ///< of the box around the displacements of all
    double spread_m = 0;           ///< no displacement is farther from the middle
  };

  [[nodiscard]] Motion measure(const Cluster& cluster);
  [[nodiscard]] double relative_motion_m(std::size_t cluster) const;
  void find_neighbours(int threads);
  void find_neighbours_of(Cluster& cluster);

  std::vector<std::vector<int>> m_beside;    ///< by muscle
  std::vector<Cluster> m_clusters;           ///< those of a muscle together
  std::vector<std::size_t> m_first_cluster;  ///< by muscle; at the end the number of all
  std::vector<int> m_members;
  std::vector<Membership> m_memberships;     ///< by node
  std::vector<double> m_expires_at_m;        ///< by member: travel of its cluster at which its clearance is used up
  std::vector<Motion> m_motions;             ///< by cluster
  std::vector<Eigen::AlignedBox3d> m_boxes;  ///< by muscle, at the last search for neighbours
  std::vector<Vec3> m_last;                  ///< by member: its position in the step before
  std::span<const Vec3> m_positions;
  double m_near_m = 0;      ///< clusters closer than this are neighbours
  double m_approach_m = 0;  ///< bound of how much closer two clusters came since that search
  bool m_has_neighbours = false;
  std::vector<int> m_expired;
};

}  // namespace musclebench

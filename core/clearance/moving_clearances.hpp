#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// By which most nodes of muscles that deform are known to be free of the muscles beside them without a query.
///
/// A node that was found at distance d from all of these is free until it and the surfaces near it have moved by d
/// towards each other. What counts is how they move *relative to each other*: tissue that lies side by side travels
/// together. Nodes are therefore taken in clusters, small parts of one muscle. Two clusters a and b move relative to
/// each other by at most |middle(a) - middle(b)| + spread(a) + spread(b) in a step, where middle is that of the box
/// around the displacements of their nodes, and spread the farthest any of them can be from it. A cluster adds up the
/// largest such step over all clusters near it; a node of it has expired when that sum has grown by its distance.
/// Clusters that are not near are farther away than both have moved since that was found out.
///
/// The cost of a step so grows with the relative motion at the places where muscles lie side by side, and not with how
/// fast a limb swings. It changes no contact.
class MovingClearances {
 public:
  /// Then no node has a clearance.
  explicit MovingClearances(const TouchingMuscles& muscles);

  /// Takes a step to `positions` (of all nodes, world frame, m) and finds the nodes that have no clearance left. The
  /// same for any number of threads.
  void update(std::span<const Vec3> positions, int threads);

  /// Those of muscles that touch others; by cluster, always in the same order. Valid until the next `update`.
  [[nodiscard]] std::span<const int> expired() const { return m_expired; }

  /// How far an expired node may have gone beyond its clearance: where the surface is now farther away than this, the
  /// node is still free. Infinite for one that had none.
  [[nodiscard]] double beyond_m(int node) const {
    const Place& place = m_places[static_cast<std::size_t>(node)];
    return m_clusters[place.cluster].travel_m - m_reach_m[place.member];
  }

  /// The node is at least this far from all muscles beside its own; 0: it is in one. Different nodes may be stored by
  /// several threads at once.
  void store(int node, double clearance_m);

  [[nodiscard]] std::size_t bytes() const;

 private:
  /// Where a node is a member; nowhere in a muscle that touches no other.
  struct Place {
    std::size_t cluster = std::numeric_limits<std::size_t>::max();
    std::size_t member = 0;
  };
  struct Cluster {
    std::size_t first = 0;  ///< of m_members: nodes of its own, then those of their triangles
    std::size_t last_own = 0;
    std::size_t last = 0;
    int muscle = 0;
    double travel_m = 0;            ///< sum over all steps of the largest relative motion to a cluster near it
    Eigen::AlignedBox3d box;        ///< when neighbours were last looked for
    std::vector<std::size_t> near;  ///< of muscles beside its own, ascending
  };

  /// How the nodes of a cluster moved in the last step.
  struct Motion {
    Vec3 middle_m = Vec3::Zero();  ///< of the box around the ways of all
    double spread_m = 0;           ///< none departs farther from the middle
  };

  [[nodiscard]] Motion measure(const Cluster& cluster);
  [[nodiscard]] double relative_motion_m(std::size_t cluster) const;
  void find_neighbours(int threads);
  void find_neighbours_of(Cluster& cluster);

  std::vector<std::vector<int>> m_beside;    ///< by muscle
  std::vector<Cluster> m_clusters;           ///< a muscle's one after the other
  std::vector<std::size_t> m_first_cluster;  ///< by muscle; and the number of all
  std::vector<int> m_members;
  std::vector<Place> m_places;               ///< by node
  std::vector<double> m_reach_m;             ///< by member: it is free while the travel of its cluster is less
  std::vector<Motion> m_motions;             ///< by cluster
  std::vector<Eigen::AlignedBox3d> m_boxes;  ///< by muscle, when neighbours were last looked for
  std::vector<Vec3> m_last;                  ///< by member: its position in the step before
  std::span<const Vec3> m_positions;
  double m_near_m = 0;         ///< clusters closer than this are neighbours
  double m_moved_apart_m = 0;  ///< by which two clusters may have come closer since neighbours were looked for
  bool m_has_neighbours = false;
  std::vector<int> m_expired;
};

}  // namespace musclebench

#include "core/clearance/moving_clearances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh/mesh_size.hpp"
#include "core/mesh/morton_order.hpp"

namespace musclebench {

namespace {

/// More than the relative rounding errors of lengths.
constexpr double rounding = 1e-9;
constexpr std::size_t cluster_size = 32;
/// Neighbours are looked for within this many mean diameters of a cluster. A smaller radius has to be searched more
/// often; a larger one holds more clusters, and the farthest of them move most.
constexpr double neighbourhood = 0.25;
/// Expiry of a node without a clearance.
constexpr double unknown_m = -std::numeric_limits<double>::infinity();

/// Calls `work(i)` for all i below `count`.
template <typename Work>
void for_each_index(std::size_t count, [[maybe_unused]] int threads, const Work& work) {
  if (threads > 1) {  // OpenMP allocates even a team of one
#pragma omp parallel for schedule(static) num_threads(threads)
    for (std::size_t i = 0; i < count; ++i) work(i);
  } else {
    for (std::size_t i = 0; i < count; ++i) work(i);
  }
}

double squared_gap_m2(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  return (a.min() - b.max()).cwiseMax(b.min() - a.max()).cwiseMax(0).squaredNorm();
}

}  // namespace

MovingClearances::MovingClearances(const TouchingMuscles& muscles) : m_memberships(muscles.mesh.vertices.size()) {
  std::vector<std::vector<int>> around(m_memberships.size());  // nodes that share a triangle
  for (const Triangle& triangle : muscles.mesh.triangles) {
    for (const int node : triangle) {
      auto& own = around[static_cast<std::size_t>(node)];
      own.insert(own.end(), triangle.begin(), triangle.end());
    }
  }
  double diameters_m = 0;
  for (int muscle = 0; muscle < static_cast<int>(muscles.bodies.size()); ++muscle) {
    const Body& body = muscles.bodies[static_cast<std::size_t>(muscle)];
    m_beside.push_back(muscles_beside(muscles.pairs, muscle));
    m_first_cluster.push_back(m_clusters.size());
    if (m_beside.back().empty()) {
      continue;
    }
    const std::vector<Vec3> own(muscles.mesh.vertices.begin() + body.first_node,
                                muscles.mesh.vertices.begin() + body.last_node);
    const std::vector<int> order = morton_order(own);
    for (std::size_t first = 0; first < order.size(); first += cluster_size) {
      Cluster cluster;
      cluster.muscle = muscle;
      cluster.first = m_members.size();
      for (std::size_t i = first; i < std::min(first + cluster_size, order.size()); ++i) {
        const int node = body.first_node + order[i];
        m_memberships[static_cast<std::size_t>(node)] = {m_clusters.size(), m_members.size()};
        m_members.push_back(node);
      }
      cluster.last_own = m_members.size();
      std::vector<int> others;
      for (std::size_t i = cluster.first; i < cluster.last_own; ++i) {
        const auto& about = around[static_cast<std::size_t>(m_members[i])];
        others.insert(others.end(), about.begin(), about.end());
      }
      std::ranges::sort(others);
      others.erase(std::unique(others.begin(), others.end()), others.end());
      std::erase_if(
          others, [&](int node) { return m_memberships[static_cast<std::size_t>(node)].cluster == m_clusters.size(); });
      m_members.insert(m_members.end(), others.begin(), others.end());
      cluster.last = m_members.size();
      for (std::size_t i = cluster.first; i < cluster.last; ++i) {
        cluster.box.extend(muscles.mesh.vertices[static_cast<std::size_t>(m_members[i])]);
      }
      diameters_m += cluster.box.diagonal().norm();
      m_clusters.push_back(std::move(cluster));
    }
  }
  m_first_cluster.push_back(m_clusters.size());
  m_motions.resize(m_clusters.size());
  m_expires_at_m.assign(m_members.size(), unknown_m);
  for (const int node : m_members) m_last.push_back(muscles.mesh.vertices[static_cast<std::size_t>(node)]);
  m_near_m = m_clusters.empty() ? 0 : neighbourhood * diameters_m / static_cast<double>(m_clusters.size());
}

MovingClearances::Motion MovingClearances::measure(const Cluster& cluster) {
  Eigen::AlignedBox3d displacements;
  for (std::size_t i = cluster.first; i < cluster.last; ++i) {
    const Vec3& position = m_positions[static_cast<std::size_t>(m_members[i])];
    displacements.extend(position - m_last[i]);
    m_last[i] = position;
  }
  return {displacements.center(), 0.5 * displacements.diagonal().norm()};
}

/// Upper bound over all clusters near it, in the last step.
double MovingClearances::relative_motion_m(std::size_t cluster) const {
  const Motion& own = m_motions[cluster];
  double largest_m = -own.spread_m;
  for (const std::size_t other : m_clusters[cluster].near) {
    const Motion& motion = m_motions[other];
    const double squared_m2 = (own.middle_m - motion.middle_m).squaredNorm();
    const double missing_m = largest_m - motion.spread_m;
    if (!(missing_m > 0 && squared_m2 <= missing_m * missing_m)) {
      largest_m = std::max(largest_m, std::sqrt(squared_m2) + motion.spread_m);
    }
  }
  return largest_m + own.spread_m;
}

void MovingClearances::update(std::span<const Vec3> positions, int threads) {
  m_positions = positions;
  for_each_index(m_clusters.size(), threads, [&](std::size_t i) { m_motions[i] = measure(m_clusters[i]); });
  double moved_m = 0;
  for (const Motion& motion : m_motions) moved_m = std::max(moved_m, motion.middle_m.norm() + motion.spread_m);
  m_approach_m += 2 * moved_m * (1 + rounding);
  for_each_index(m_clusters.size(), threads,
                 [&](std::size_t i) { m_clusters[i].travel_m += relative_motion_m(i) * (1 + rounding); });
  if (!(m_approach_m < m_near_m * (1 - rounding))) {  // a leap: clusters that were not near may have met
    std::ranges::fill(m_expires_at_m, unknown_m);
  }
  // At half of the radius, so that a new neighbour is still at least the other half away.
  if (!m_has_neighbours || !(m_approach_m < 0.5 * m_near_m)) {
    find_neighbours(threads);
  }
  m_expired.clear();
  for (const Cluster& cluster : m_clusters) {
    for (std::size_t i = cluster.first; i < cluster.last_own; ++i) {
      // Not `>=`: a NaN has expired.
      if (!(cluster.travel_m < m_expires_at_m[i])) m_expired.push_back(m_members[i]);
    }
  }
}

void MovingClearances::find_neighbours(int threads) {
  for_each_index(m_clusters.size(), threads, [&](std::size_t i) {
    Cluster& cluster = m_clusters[i];
    cluster.box.setEmpty();
    for (std::size_t k = cluster.first; k < cluster.last; ++k) {
      cluster.box.extend(m_positions[static_cast<std::size_t>(m_members[k])]);
    }
  });
  m_boxes.assign(m_beside.size(), Eigen::AlignedBox3d());
  for (const Cluster& cluster : m_clusters) m_boxes[static_cast<std::size_t>(cluster.muscle)].extend(cluster.box);
  for_each_index(m_clusters.size(), threads, [&](std::size_t i) { find_neighbours_of(m_clusters[i]); });
  m_approach_m = 0;
  m_has_neighbours = true;
}

void MovingClearances::find_neighbours_of(Cluster& cluster) {
  std::vector<std::size_t> near;
  double least_new_gap_m = std::numeric_limits<double>::infinity();
  for (const int muscle : m_beside[static_cast<std::size_t>(cluster.muscle)]) {
    const auto beside = static_cast<std::size_t>(muscle);
    if (!(squared_gap_m2(cluster.box, m_boxes[beside]) < m_near_m * m_near_m)) {
      continue;
    }
    for (std::size_t other = m_first_cluster[beside]; other < m_first_cluster[beside + 1]; ++other) {
      const double squared_m2 = squared_gap_m2(cluster.box, m_clusters[other].box);
      if (!(squared_m2 < m_near_m * m_near_m)) {
        continue;
      }
      near.push_back(other);
      if (!std::ranges::binary_search(cluster.near, other)) {
        least_new_gap_m = std::min(least_new_gap_m, std::sqrt(squared_m2));
      }
    }
  }
  // Motion of a new neighbour was not counted in travel_m: cap every clearance at the distance to it.
  const double expires_at_m = cluster.travel_m + least_new_gap_m * (1 - rounding);
  for (std::size_t i = cluster.first; i < cluster.last_own; ++i) {
    m_expires_at_m[i] = std::min(m_expires_at_m[i], expires_at_m);
  }
  cluster.near = std::move(near);
}

void MovingClearances::store(int node, double clearance_m) {
  const Membership& membership = m_memberships[static_cast<std::size_t>(node)];
  m_expires_at_m[membership.member] =
      clearance_m > 0 ? m_clusters[membership.cluster].travel_m + clearance_m * (1 - rounding) : unknown_m;
}

std::size_t MovingClearances::bytes() const {
  std::size_t sum = m_clusters.capacity() * sizeof(Cluster) + m_members.capacity() * sizeof(int) +
                    m_memberships.capacity() * sizeof(Membership) + m_expires_at_m.capacity() * sizeof(double) +
                    m_last.capacity() * sizeof(Vec3) + m_motions.capacity() * sizeof(Motion);
  for (const Cluster& cluster : m_clusters) sum += cluster.near.capacity() * sizeof(std::size_t);
  return sum;
}

}  // namespace musclebench

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
/// Neighbours are looked for within this many mean diameters of a cluster. Fewer: they are looked for more often. More:
/// they are more, and the farthest of them moves most.
constexpr double neighbourhood = 1;

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

double gap_m(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  return (a.min() - b.max()).cwiseMax(b.min() - a.max()).cwiseMax(0).norm();
}

}  // namespace

MovingClearances::MovingClearances(const TouchingMuscles& muscles)
    : m_nodes(muscles.mesh.vertices.size()), m_last(muscles.mesh.vertices) {
  std::vector<std::vector<int>> around(m_nodes.size());  // nodes that share a triangle
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
        m_nodes[static_cast<std::size_t>(node)].cluster = m_clusters.size();
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
      std::erase_if(others,
                    [&](int node) { return m_nodes[static_cast<std::size_t>(node)].cluster == m_clusters.size(); });
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
  m_near_m = m_clusters.empty() ? 0 : neighbourhood * diameters_m / static_cast<double>(m_clusters.size());
}

void MovingClearances::measure(Cluster& cluster) {
  Vec3 sum = Vec3::Zero();
  double squared_m2 = 0;
  for (std::size_t i = cluster.first; i < cluster.last; ++i) {
    const auto node = static_cast<std::size_t>(m_members[i]);
    const Vec3 moved = m_positions[node] - m_last[node];
    sum += moved;
    squared_m2 = std::max(squared_m2, moved.squaredNorm());
  }
  cluster.mean_m = sum / static_cast<double>(cluster.last - cluster.first);
  cluster.moved_m = std::sqrt(squared_m2);
  double spread_m2 = 0;
  for (std::size_t i = cluster.first; i < cluster.last; ++i) {
    const auto node = static_cast<std::size_t>(m_members[i]);
    spread_m2 = std::max(spread_m2, (m_positions[node] - m_last[node] - cluster.mean_m).squaredNorm());
  }
  cluster.spread_m = std::sqrt(spread_m2);
}

void MovingClearances::update(std::span<const Vec3> positions, int threads) {
  m_positions = positions;
  for_each_index(m_clusters.size(), threads, [&](std::size_t i) { measure(m_clusters[i]); });
  double moved_m = 0;
  for (const Cluster& cluster : m_clusters) moved_m = std::max(moved_m, cluster.moved_m);
  m_moved_apart_m += 2 * moved_m * (1 + rounding);
  if (!(m_moved_apart_m < m_near_m * (1 - rounding))) {  // a leap: clusters that were not near may have met
    for (NodeState& state : m_nodes) state.reach_m = -std::numeric_limits<double>::infinity();
  }
  // At half of the distance, so that a cluster that becomes a neighbour is still as far away as the other half.
  const bool looks_for_neighbours = !m_has_neighbours || !(m_moved_apart_m < 0.5 * m_near_m);
  for_each_index(m_clusters.size(), threads, [&](std::size_t i) {
    Cluster& cluster = m_clusters[i];
    double relative_m = 0;
    for (const std::size_t other : cluster.near) {
      const Cluster& b = m_clusters[other];
      relative_m = std::max(relative_m, (cluster.mean_m - b.mean_m).norm() + b.spread_m);
    }
    if (!cluster.near.empty()) cluster.travel_m += (relative_m + cluster.spread_m) * (1 + rounding);
  });
  if (looks_for_neighbours) {
    find_neighbours(threads);
  }
  std::copy(positions.begin(), positions.end(), m_last.begin());
  m_expired.clear();
  for (const Cluster& cluster : m_clusters) {
    for (std::size_t i = cluster.first; i < cluster.last_own; ++i) {
      const int node = m_members[i];
      // Not `>=`: what is not a number has expired.
      if (!(cluster.travel_m < m_nodes[static_cast<std::size_t>(node)].reach_m)) m_expired.push_back(node);
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
  for_each_index(m_clusters.size(), threads, [&](std::size_t i) { find_neighbours_of(m_clusters[i]); });
  m_moved_apart_m = 0;
  m_has_neighbours = true;
}

void MovingClearances::find_neighbours_of(Cluster& cluster) {
  std::vector<std::size_t> near;
  double least_new_gap_m = std::numeric_limits<double>::infinity();
  for (const int muscle : m_beside[static_cast<std::size_t>(cluster.muscle)]) {
    const auto beside = static_cast<std::size_t>(muscle);
    for (std::size_t other = m_first_cluster[beside]; other < m_first_cluster[beside + 1]; ++other) {
      const double gap = gap_m(cluster.box, m_clusters[other].box);
      if (!(gap < m_near_m)) {
        continue;
      }
      near.push_back(other);
      if (!std::ranges::binary_search(cluster.near, other)) least_new_gap_m = std::min(least_new_gap_m, gap);
    }
  }
  // How a new neighbour came nearer was not added to the travel: no node of this cluster is farther from it than that.
  const double reach_m = cluster.travel_m + least_new_gap_m * (1 - rounding);
  for (std::size_t i = cluster.first; i < cluster.last_own; ++i) {
    NodeState& state = m_nodes[static_cast<std::size_t>(m_members[i])];
    state.reach_m = std::min(state.reach_m, reach_m);
  }
  cluster.near = std::move(near);
}

void MovingClearances::store(int node, double clearance_m) {
  NodeState& state = m_nodes[static_cast<std::size_t>(node)];
  state.reach_m = clearance_m > 0 ? m_clusters[state.cluster].travel_m + clearance_m * (1 - rounding)
                                  : -std::numeric_limits<double>::infinity();
}

std::size_t MovingClearances::bytes() const {
  std::size_t sum = m_clusters.capacity() * sizeof(Cluster) + m_members.capacity() * sizeof(int) +
                    m_nodes.capacity() * sizeof(NodeState) + m_last.capacity() * sizeof(Vec3);
  for (const Cluster& cluster : m_clusters) sum += cluster.near.capacity() * sizeof(std::size_t);
  return sum;
}

}  // namespace musclebench

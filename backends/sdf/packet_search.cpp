#include "backends/sdf/packet_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "backends/sdf/packet_kernel.hpp"

namespace musclebench {

namespace {

/// Its square is still a float.
constexpr float widest_limit = 1e18F;

/// A packet with what has been decided in double so far.
struct DecidedPacket : PacketTask {
  const TriangleTree* tree = nullptr;
  double scale = 1;
  std::span<const Vec3> exact_points;
  std::array<ClosestOnTriangle, most_points> best;
  std::array<int, most_points> best_triangle{};

  void offer(std::size_t point, int index) {
    const ClosestOnTriangle found = tree->closest_on(exact_points[point], index);
    ClosestOnTriangle& known = best[point];
    int& known_triangle = best_triangle[point];
    if (found.squared_distance_m2 < known.squared_distance_m2 ||
        (found.squared_distance_m2 == known.squared_distance_m2 && (known_triangle < 0 || index < known_triangle))) {
      known = found;
      known_triangle = index;
    }
  }

  void decide_listed(std::size_t point) {
    Point& asked = points[point];
    const float squared_limit = asked.limit * asked.limit;
    for (std::size_t i = 0; i < asked.count; ++i) {
      if (asked.squared[i] <= squared_limit) {
        offer(point, asked.triangle[i]);
      }
    }
    asked.count = 0;
  }

  void narrow(std::size_t point) {
    const double farthest = std::sqrt(best[point].squared_distance_m2) * scale + static_cast<double>(slack);
    points[point].limit =
        std::min(points[point].limit, static_cast<float>(std::min<double>(farthest * 1.000001, widest_limit)));
  }
};

}  // namespace

void PacketSearch::closest_points(std::span<const Vec3> points, int seed, std::span<ClosestPoint> answers) const {
  static_assert(most_points == PacketTask::most_points);
  constexpr double float_rounding = 0x1p-24;
  constexpr double double_rounding = 0x1p-53;
  DecidedPacket packet;
  packet.tree = m_tree;
  packet.scale = m_tree->m_scale;
  packet.exact_points = points;
  packet.nodes = m_tree->m_nodes.data();
  packet.leaves = m_tree->m_leaves.data();
  packet.first_leaf = m_tree->m_leaf_of[static_cast<std::size_t>(seed)];
  packet.longest_side = static_cast<float>(m_tree->m_longest_side);
  packet.count = points.size();
  packet.decide = [](PacketTask& self, std::size_t point) {
    auto& full = static_cast<DecidedPacket&>(self);
    full.decide_listed(point);
    full.narrow(point);
  };

  // About the mean most points of a record are nearer than about the middle of its box.
  Vec3 lower = points.front();
  Vec3 upper = lower;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& point : points) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
    middle += point / static_cast<double>(points.size());
  }
  const auto own = [&](const Vec3& point) {
    const Vec3 place = m_tree->m_scale * (point - m_tree->m_centre_m);
    return std::array<float, 3>{static_cast<float>(place.x()), static_cast<float>(place.y()),
                                static_cast<float>(place.z())};
  };
  packet.middle = own(middle);
  packet.reach = static_cast<float>(m_tree->m_scale * (upper - lower).norm());
  // As TriangleTree has it, for the farthest of the points.
  const double reach =
      m_tree->m_scale *
      (upper - m_tree->m_centre_m).cwiseAbs().cwiseMax((lower - m_tree->m_centre_m).cwiseAbs()).maxCoeff();
  const double coordinates =
      std::max(m_tree->m_reach, m_tree->m_scale * upper.cwiseAbs().cwiseMax(lower.cwiseAbs()).maxCoeff());
  packet.slack = static_cast<float>(float_rounding * (49 * (1 + reach) + 17 * m_tree->m_longest_side) +
                                    32 * double_rounding * coordinates);
  for (std::size_t n = 0; n < points.size(); ++n) {
    PacketTask::Point& point = packet.points[n];
    point.at = own(points[n]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      point.from_middle[axis] = point.at[axis] - packet.middle[axis];
    }
    point.limit = widest_limit;
    packet.best[n].squared_distance_m2 = std::numeric_limits<double>::infinity();
    packet.best_triangle[n] = -1;
  }

  search_packet(packet);
  for (std::size_t n = 0; n < points.size(); ++n) {
    packet.decide_listed(n);
    const ClosestOnTriangle& best = packet.best[n];
    answers[n] = {best.point, std::sqrt(best.squared_distance_m2), packet.best_triangle[n], best.feature};
  }
}

}  // namespace musclebench

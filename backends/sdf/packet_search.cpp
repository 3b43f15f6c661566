#include "backends/sdf/packet_search.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace musclebench {

namespace {

constexpr std::size_t most_points = PacketSearch::bundle * PointPacket::capacity;

struct Corners {
  Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 upper = -lower;

  [[nodiscard]] bool is_empty() const { return !(lower.x() <= upper.x()); }
  [[nodiscard]] Vec3 middle() const { return 0.5 * (lower + upper); }
};

Corners corners_of(std::span<const PointPacket> packets) {
  Corners corners;
  for (const PointPacket& packet : packets) {
    for (std::size_t n = 0; n < packet.count; ++n) {
      corners.lower = corners.lower.cwiseMin(packet.point[n]);
      corners.upper = corners.upper.cwiseMax(packet.point[n]);
    }
  }
  return corners;
}

}  // namespace

std::array<float, 3> PacketSearch::to_own(const Vec3& point) const {
  const Vec3 own = m_tree->m_scale * (point - m_tree->m_centre_m);
  return {static_cast<float>(own.x()), static_cast<float>(own.y()), static_cast<float>(own.z())};
}

PlaceBox PacketSearch::box_about(const Vec3& lower, const Vec3& upper, float slack) const {
  PlaceBox box;
  box.middle = to_own(0.5 * (lower + upper));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    box.half[axis] = static_cast<float>(0.5 * m_tree->m_scale * (upper[a] - lower[a])) * 1.000001F + slack;
  }
  return box;
}

TreeView PacketSearch::view(const Vec3& lower, const Vec3& upper) const {
  const Vec3 middle = m_tree->m_centre_m;
  const double reach = m_tree->m_scale * (upper - middle).cwiseAbs().cwiseMax((lower - middle).cwiseAbs()).maxCoeff();
  const double coordinate = m_tree->m_scale * upper.cwiseAbs().cwiseMax(lower.cwiseAbs()).maxCoeff();
  return {m_tree->m_nodes.data(), m_tree->m_leaves.data(), static_cast<float>(m_tree->m_longest_side),
          m_tree->slack_for(reach, coordinate)};
}

void PacketSearch::closest_points(std::span<PointPacket> packets, int seed) {
  const Corners corners = corners_of(packets);
  if (corners.is_empty()) {
    return;
  }
  const TreeView tree = view(corners.lower, corners.upper);
  PlaceBox block = box_about(corners.lower, corners.upper, tree.slack);
  const int nearest = packets.size() > 1 ? m_tree->closest_point_from(corners.middle(), seed).triangle : seed;
  for (const int triangle : {nearest, seed}) {
    const int index = m_tree->m_leaf_of[static_cast<std::size_t>(triangle)];
    const TreeLeaf& leaf = tree.leaves[index];
    if (!m_tree->is_needle(triangle)) {
      bound_by_triangle(
          tree, static_cast<std::int32_t>(static_cast<std::size_t>(index) * tree_width + leaf.place_of(triangle)),
          block);
      break;
    }
  }
  list_nodes(tree, block, m_nodes);
  for (std::size_t first = 0; first < packets.size(); first += bundle) {
    search_bundle(packets.subspan(first, std::min(bundle, packets.size() - first)), tree, block);
  }
}

void PacketSearch::search_bundle(std::span<PointPacket> packets, const TreeView& tree, const PlaceBox& block) {
  const Corners corners = corners_of(packets);
  if (corners.is_empty()) {
    return;
  }
  PlaceBox box = box_about(corners.lower, corners.upper, tree.slack);
  list_leaves(tree, m_nodes, block, box, m_near, m_leaves);
  m_pairs.count = 0;
  for (std::size_t p = 0; p < packets.size(); ++p) {
    const PointPacket& packet = packets[p];
    if (packet.count == 0) {
      continue;
    }
    m_points.count = packet.count;
    for (std::size_t n = 0; n < PointPacket::capacity; ++n) {
      const std::array<float, 3> own = to_own(packet.point[n < packet.count ? n : 0]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        m_points.at[axis][n] = own[axis];
      }
    }
    list_pairs(tree, m_leaves, box, m_points, static_cast<std::int32_t>(p * PointPacket::capacity), m_pairs);
  }
  decide(packets);
}

void PacketSearch::decide(std::span<PointPacket> packets) {
  constexpr std::size_t width = ClosestOnTriangles::width;
  assert(m_pairs.count > 0);
  std::array<Vec3, most_points> points;
  for (std::size_t p = 0; p < packets.size(); ++p) {
    std::copy_n(packets[p].point.begin(), packets[p].count,
                points.begin() + static_cast<std::ptrdiff_t>(p * PointPacket::capacity));
  }
  const std::size_t rounded_up = (m_pairs.count + width - 1) / width * width;
  m_pairs.make_room(rounded_up - m_pairs.count);
  for (std::size_t pair = m_pairs.count; pair < rounded_up; ++pair) {
    m_pairs.point[pair] = m_pairs.point[0];
    m_pairs.triangle[pair] = m_pairs.triangle[0];
  }
  m_found.resize(std::max(m_found.size(), rounded_up / width));
  closest_on_triangles(points.data(), m_tree->m_corners.data(), {m_pairs.point.data(), rounded_up},
                       {m_pairs.triangle.data(), rounded_up}, m_found);
  // Most pairs are ties, so that no branch could be foreseen: first the least distance, then the first triangle there.
  const auto squared_of = [&](std::size_t pair) { return m_found[pair / width].squared_distance_m2[pair % width]; };
  std::array<double, most_points> least;
  least.fill(std::numeric_limits<double>::infinity());
  for (std::size_t pair = 0; pair < m_pairs.count; ++pair) {
    double& of_point = least[static_cast<std::size_t>(m_pairs.point[pair])];
    of_point = std::min(of_point, squared_of(pair));
  }
  constexpr auto none = std::numeric_limits<std::uint64_t>::max();
  std::array<std::uint64_t, most_points> first;  // triangle, and its pair in the lower half
  first.fill(none);
  for (std::size_t pair = 0; pair < m_pairs.count; ++pair) {
    const auto point = static_cast<std::size_t>(m_pairs.point[pair]);
    const std::uint64_t not_least = 0 - static_cast<std::uint64_t>(squared_of(pair) > least[point]);
    first[point] = std::min(first[point], static_cast<std::uint64_t>(m_pairs.triangle[pair]) << 32U | pair | not_least);
  }
  for (std::size_t p = 0; p < packets.size(); ++p) {
    for (std::size_t n = 0; n < packets[p].count; ++n) {
      assert(first[p * PointPacket::capacity + n] != none);
      const auto pair = static_cast<std::uint32_t>(first[p * PointPacket::capacity + n]);
      const ClosestOnTriangle closest = m_found[pair / width].at(pair % width);
      packets[p].closest[n] = {closest.point, std::sqrt(closest.squared_distance_m2), m_pairs.triangle[pair],
                               closest.feature};
    }
  }
}

}  // namespace musclebench

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "core/bvh/batch/packet_pairs.hpp"
#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/closest_on_triangles.hpp"

namespace musclebench {

/// A few points that lie close together, and their closest points.
struct PointPacket {
  static constexpr std::size_t capacity = 8;

  std::size_t count = 0;
  std::array<Vec3, capacity> point;
  std::array<ClosestPoint, capacity> closest;

  void add(const Vec3& position) { point[count++] = position; }
};

/// Finds the closest points of many points that lie close together in one walk through a TriangleBvh: bounds of a
/// squared distance that are linear in the place (packet_bounds-inl.hpp derives them) answer for all points of a box,
/// and are the tighter the farther the surface is. The walk lists nodes for all packets; from these, for each bundle of
/// packets, leaves are listed; from these, for every two packets, those that may matter to any of their points.
///
/// The floats only prune; `closest_on_triangle` decides. So the answers are those of TriangleBvh::closest_point, to
/// the bit. One thread at a time: lists are kept for the next search.
class PacketSearch {
 public:
  /// Packets that follow each other and should lie close together; some may be empty.
  static constexpr std::size_t bundle = 8;

  explicit PacketSearch(const TriangleBvh& tree);

  /// The box, within 1e12 times the mesh's size, that all points lie in until the next call. `triangle` is any; the
  /// search is the faster the nearer it is to the box's middle.
  void enter(const Eigen::AlignedBox3d& box, int triangle);

  void closest_points(std::span<PointPacket> packets);

 private:
  /// A place in a leaf of a triangle that is no sliver, near the one that is given where that can be; as
  /// `bound_by_triangle` has it, negative where there is none.
  [[nodiscard]] std::int32_t bounding_place(int triangle) const;
  void search_bundle(std::span<PointPacket> packets);
  /// To those that are searched for next; `number` is the packet's in its bundle.
  void add_points(const PointPacket& packet, std::size_t number);
  void search_points(const PlaceBox& box);
  void decide(std::span<PointPacket> packets);
  [[nodiscard]] PlaceBox place_box(const Eigen::AlignedBox3d& box) const;
  [[nodiscard]] std::array<float, 3> to_own(const Vec3& point) const;
  [[nodiscard]] TreeView view_from(const Eigen::AlignedBox3d& box) const;

  const TriangleBvh* m_tree;
  std::int32_t m_any_place = -1;  ///< of a triangle that is no sliver
  Eigen::AlignedBox3d m_entered;
  TreeView m_view{};
  PlaceBox m_box;  ///< the same
  BoundList m_nodes;
  BoundList m_near;
  BoundList m_leaves;
  PacketPoints m_points;
  CandidatePairs m_pairs;
  std::vector<ClosestOnTriangles> m_found;
};

}  // namespace musclebench

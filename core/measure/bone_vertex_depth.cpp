#include "core/measure/bone_vertex_depth.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/mesh/surface_volume.hpp"

namespace musclebench {
namespace {

constexpr int cluster_size = 24;
/// Rounding errors of a distance or a movement stay far below this share of the lengths that they come from.
constexpr double rounding_share = 0x1p-40;

std::vector<Triangle> wound_outwards(const TriangleMesh& mesh) {
  std::vector<Triangle> triangles = mesh.triangles;
  if (surface_volume_m3(mesh.vertices, mesh.triangles) < 0) {
    for (Triangle& triangle : triangles) std::swap(triangle[1], triangle[2]);
  }
  return triangles;
}

}  // namespace

BoneVertexDepthMeter::BoneVertexDepthMeter(std::span<const Bone> bones, const TriangleMesh& muscle,
                                           std::span<const int> carriers)
    : m_triangles(wound_outwards(muscle)),
      m_carriers(carriers.begin(), carriers.end()),
      m_tree({muscle.vertices, m_triangles}),
      m_bones(bones.size()) {
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const TriangleMesh& mesh = bones[i].surface.mesh;
    std::vector<char> used(mesh.vertices.size(), 0);
    for (const Triangle& triangle : mesh.triangles) {
      for (const int vertex : triangle) used[static_cast<std::size_t>(vertex)] = 1;
    }
    for (std::size_t vertex = 0; vertex < used.size(); ++vertex) {
      if (used[vertex] != 0) m_bones[i].vertices.push_back({mesh.vertices[vertex], static_cast<int>(vertex)});
    }
    divide(m_bones[i], 0, static_cast<int>(m_bones[i].vertices.size()));
  }
}

void BoneVertexDepthMeter::divide(BoneVertices& bone, int first, int last) {
  Eigen::AlignedBox3d box;
  const auto begin = bone.vertices.begin();
  std::for_each(begin + first, begin + last, [&](const Vertex& vertex) { box.extend(vertex.point_m); });
  if (last - first <= cluster_size) {
    Cluster cluster{first, last, box.center(), 0};
    std::for_each(begin + first, begin + last, [&](const Vertex& vertex) {
      cluster.radius_m = std::max(cluster.radius_m, (vertex.point_m - cluster.centre_m).norm());
    });
    if (first < last) bone.clusters.push_back(cluster);
    return;
  }
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const int middle = (first + last) / 2;
  std::nth_element(begin + first, begin + middle, begin + last, [axis](const Vertex& one, const Vertex& other) {
    return std::pair(one.point_m[axis], one.index) < std::pair(other.point_m[axis], other.index);
  });
  divide(bone, first, middle);
  divide(bone, middle, last);
}

DeepestBoneVertex BoneVertexDepthMeter::measure(std::span<const RigidMotion> poses, std::span<const Vec3> positions) {
  assert(poses.size() == m_bones.size() && positions.size() == m_carriers.size());
  m_queries = 0;
  m_best = {};
  m_tree.refit(m_triangles, positions);
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
    follow(m_bones[bone], poses[bone], positions);
    for (Cluster& cluster : m_bones[bone].clusters) {
      if (m_bones[bone].way_m >= cluster.safe_until_m) measure_cluster(static_cast<int>(bone), poses[bone], cluster);
    }
  }
  return m_best;
}

void BoneVertexDepthMeter::follow(BoneVertices& bone, const RigidMotion& pose, std::span<const Vec3> positions) const {
  const bool first = bone.last_m.empty();
  bone.last_m.resize(positions.size());
  double farthest2 = 0;
  for (std::size_t node = 0; node < positions.size(); ++node) {
    const Vec3 rest_point = pose.apply_inverse(positions[node]);
    if (!first) farthest2 = std::max(farthest2, (rest_point - bone.last_m[node]).squaredNorm());
    bone.last_m[node] = rest_point;
  }
  bone.way_m += std::sqrt(farthest2) + rounding_share * m_tree.diagonal_m();
}

void BoneVertexDepthMeter::measure_cluster(int bone, const RigidMotion& pose, Cluster& cluster) {
  BoneVertices& vertices = m_bones[static_cast<std::size_t>(bone)];
  const double way_m = vertices.way_m;
  Place centre{pose.apply(cluster.centre_m) - m_tree.centre_m(), 0, false};
  ++m_queries;
  const ClosestSurfacePoint nearest = m_tree.closest(centre.point_m, cluster.place);
  cluster.place = nearest.place;
  centre.distance_m = std::sqrt(nearest.squared_distance_m2);
  if (centre.distance_m + cluster.radius_m <= m_best.depth_m) return;
  centre.inside = m_tree.winding_number(centre.point_m) > 0.5;
  if (!centre.inside && m_tree.closed() && centre.distance_m > cluster.radius_m) {
    cluster.safe_until_m = way_m + (centre.distance_m - cluster.radius_m) * (1 - rounding_share);
    return;
  }
  for (int i = cluster.first; i < cluster.last; ++i) {
    Vertex& vertex = vertices.vertices[static_cast<std::size_t>(i)];
    if (way_m >= vertex.safe_until_m) measure_vertex(bone, pose, vertex, centre);
  }
}

/// `near`: a point near the vertex, whose side is known.
void BoneVertexDepthMeter::measure_vertex(int bone, const RigidMotion& pose, Vertex& vertex, const Place& near) {
  const Vec3 point = pose.apply(vertex.point_m) - m_tree.centre_m();
  ++m_queries;
  const ClosestSurfacePoint nearest = m_tree.closest(point, vertex.place);
  vertex.place = nearest.place;
  const double distance = std::sqrt(nearest.squared_distance_m2);
  if (distance <= m_best.depth_m || is_attached(bone, nearest.place)) return;
  const double rounding_m = rounding_share * m_tree.diagonal_m();
  const bool near_known = m_tree.closed() && (point - near.point_m).norm() < distance - rounding_m;
  if (near_known ? near.inside : m_tree.winding_number(point) > 0.5) {
    m_best = {distance, bone, vertex.index};
  } else if (m_tree.closed()) {
    vertex.safe_until_m = m_bones[static_cast<std::size_t>(bone)].way_m + distance * (1 - rounding_share);
  }
}

bool BoneVertexDepthMeter::is_attached(int bone, int place) const {
  const Triangle& nodes = m_triangles[static_cast<std::size_t>(m_tree.triangle_index(place))];
  return std::any_of(nodes.begin(), nodes.end(),
                     [&](int node) { return m_carriers[static_cast<std::size_t>(node)] == bone; });
}

std::size_t BoneVertexDepthMeter::bytes() const {
  std::size_t sum = m_triangles.capacity() * sizeof(Triangle) + m_carriers.capacity() * sizeof(int) + m_tree.bytes();
  for (const BoneVertices& bone : m_bones) {
    sum += bone.vertices.capacity() * sizeof(Vertex) + bone.clusters.capacity() * sizeof(Cluster) +
           bone.last_m.capacity() * sizeof(Vec3);
  }
  return sum;
}

}  // namespace musclebench

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

DeepestBoneVertex BoneVertexDepthMeter::measure(std::span<const RigidMotion> poses, std::span<const Vec3> positions,
                                                long budget) {
  assert(poses.size() == m_bones.size() && positions.size() == m_carriers.size());
  m_work = 0;
  m_best = {};
  m_unmeasured_m = 0;
  m_tree.refit(m_triangles, positions);
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
    follow(m_bones[bone], poses[bone], positions);
    measure_bone(static_cast<int>(bone), poses[bone], budget);
  }
  m_best.bound_m = std::max(m_best.depth_m, m_unmeasured_m);
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
  bone.travel_m += std::sqrt(farthest2) + rounding_share * m_tree.diagonal_m();
}

void BoneVertexDepthMeter::measure_bone(int bone, const RigidMotion& pose, long budget) {
  BoneVertices& vertices = m_bones[static_cast<std::size_t>(bone)];
  const std::size_t count = vertices.clusters.size();
  const std::size_t start = vertices.start;
  vertices.start = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t index = (start + i) % count;
    Cluster& cluster = vertices.clusters[index];
    if (vertices.travel_m < cluster.safe_until_m) continue;
    if (m_work < budget) {
      measure_cluster(bone, pose, cluster);
      continue;
    }
    const double bound_m = bound_of(cluster, pose);
    if (bound_m > 0 && m_unmeasured_m == 0) vertices.start = index;
    m_unmeasured_m = std::max(m_unmeasured_m, bound_m);
  }
}

/// Without a query: nothing outside the muscle's box is inside a closed muscle, and nothing inside is farther from the
/// surface than half of the box's shortest side.
double BoneVertexDepthMeter::bound_of(const Cluster& cluster, const RigidMotion& pose) const {
  if (!m_tree.closed()) return m_tree.diagonal_m();
  const double to_box_m = m_tree.box_distance(pose.apply(cluster.centre_m) - m_tree.centre_m());
  return to_box_m > cluster.radius_m ? 0 : m_tree.inradius_bound_m();
}

void BoneVertexDepthMeter::measure_cluster(int bone, const RigidMotion& pose, Cluster& cluster) {
  BoneVertices& vertices = m_bones[static_cast<std::size_t>(bone)];
  const double travel_m = vertices.travel_m;
  KnownPoint centre{pose.apply(cluster.centre_m) - m_tree.centre_m(), 0, {}};
  const ClosestSurfacePoint nearest = m_tree.closest(centre.point_m, cluster.slot, &m_work);
  cluster.slot = nearest.slot;
  centre.distance_m = std::sqrt(nearest.squared_distance_m2);
  if (centre.distance_m + cluster.radius_m <= m_best.depth_m) return;
  centre.winding = m_tree.winding(centre.point_m, &m_work);
  const double safe_m = std::min(centre.distance_m, centre.winding.steady_m);
  if (!centre.inside() && safe_m > cluster.radius_m) {
    cluster.safe_until_m = travel_m + (safe_m - cluster.radius_m) * (1 - rounding_share);
    return;
  }
  for (int i = cluster.first; i < cluster.last; ++i) {
    Vertex& vertex = vertices.vertices[static_cast<std::size_t>(i)];
    if (travel_m >= vertex.safe_until_m) measure_vertex(bone, pose, vertex, centre);
  }
}

/// `near`: a point near the vertex.
void BoneVertexDepthMeter::measure_vertex(int bone, const RigidMotion& pose, Vertex& vertex, const KnownPoint& near) {
  const Vec3 point = pose.apply(vertex.point_m) - m_tree.centre_m();
  const ClosestSurfacePoint nearest = m_tree.closest(point, vertex.slot, &m_work);
  vertex.slot = nearest.slot;
  const double distance = std::sqrt(nearest.squared_distance_m2);
  if (distance <= m_best.depth_m || is_attached(bone, nearest.slot)) return;
  const double from_near = (point - near.point_m).norm() + rounding_share * m_tree.diagonal_m();
  SurfaceWinding winding{near.winding.number, near.winding.steady_m - from_near};
  if (from_near >= std::min(distance, near.winding.steady_m)) winding = m_tree.winding(point, &m_work);
  if (winding.number > 0.5) {
    m_best = {distance, distance, bone, vertex.index, m_tree.triangle_index(nearest.slot)};
  } else {
    const double safe_m = std::min(distance, winding.steady_m) * (1 - rounding_share);
    vertex.safe_until_m = m_bones[static_cast<std::size_t>(bone)].travel_m + safe_m;
  }
}

bool BoneVertexDepthMeter::is_attached(int bone, int slot) const {
  const Triangle& nodes = m_triangles[static_cast<std::size_t>(m_tree.triangle_index(slot))];
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

#include "backends/fcl/node_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace musclebench {

namespace {

/// A sum of unit normals and angles that is shorter than this is rounding.
constexpr double smallest_normal = 1e-9;

}  // namespace

NodeContacts::NodeContacts(std::span<const Bone> bones, std::vector<Triangle> muscle_triangles, std::size_t nodes)
    : m_bones(bones), m_triangles(std::move(muscle_triangles)), m_rounds(nodes, 0), m_closest(nodes) {
  m_normals.reserve(bones.size());
  for (const Bone& bone : bones) {
    m_normals.emplace_back(bone.surface.mesh);
  }
}

void NodeContacts::append(int bone, const RigidMotion& pose, std::span<const TrianglePair> pairs,
                          std::span<const Vec3> positions, std::span<const int> wanted,
                          std::vector<Contact>& contacts) {
  if (pairs.empty()) {
    return;
  }
  const auto index = static_cast<std::size_t>(bone);
  start_round();
  measure_pairs(m_bones[index].surface.mesh, pose, pairs, positions);
  for (const int node : wanted) {
    if (m_rounds[static_cast<std::size_t>(node)] != m_round) {
      continue;
    }
    const Closest& closest = m_closest[static_cast<std::size_t>(node)];
    const Vec3 normal = m_normals[index].at(closest.triangle, closest.feature);
    const double length = normal.norm();
    // Where the faces about an edge or a corner cancel, as in a fin without thickness, there is no inside.
    if (length > smallest_normal && normal.dot(closest.rest_position - closest.point) < 0) {
      contacts.push_back(
          {node, bone, std::sqrt(closest.squared_distance_m2), pose.apply_to_direction(normal / length)});
    }
  }
}

void NodeContacts::start_round() {
  if (++m_round == 0) {  // the counter has come round: marks of 4 billion calls ago would count as new
    std::fill(m_rounds.begin(), m_rounds.end(), 0);
    m_round = 1;
  }
}

void NodeContacts::measure_pairs(const TriangleMesh& bone, const RigidMotion& pose, std::span<const TrianglePair> pairs,
                                 std::span<const Vec3> positions) {
  for (const TrianglePair& pair : pairs) {
    for (const int node : m_triangles[static_cast<std::size_t>(pair.muscle_triangle)]) {
      const auto i = static_cast<std::size_t>(node);
      Closest& closest = m_closest[i];
      if (m_rounds[i] != m_round) {
        m_rounds[i] = m_round;
        closest = {pose.apply_inverse(positions[i]), Vec3::Zero(), std::numeric_limits<double>::infinity(), -1,
                   Feature::face};
      }
      measure(bone, pair.bone_triangle, closest);
    }
  }
}

void NodeContacts::measure(const TriangleMesh& bone, int triangle, Closest& closest) const {
  const Triangle& corners = bone.triangles[static_cast<std::size_t>(triangle)];
  const ClosestOnTriangle found = closest_on_triangle(
      closest.rest_position, bone.vertices[static_cast<std::size_t>(corners[0])],
      bone.vertices[static_cast<std::size_t>(corners[1])], bone.vertices[static_cast<std::size_t>(corners[2])]);
  // At equal distances the smallest index, so that the order of the pairs does not matter.
  if (found.squared_distance_m2 < closest.squared_distance_m2 ||
      (found.squared_distance_m2 == closest.squared_distance_m2 && triangle < closest.triangle)) {
    closest.point = found.point;
    closest.squared_distance_m2 = found.squared_distance_m2;
    closest.triangle = triangle;
    closest.feature = found.feature;
  }
}

std::size_t NodeContacts::bytes() const {
  std::size_t sum = sizeof(*this) + m_triangles.size() * sizeof(Triangle) + m_rounds.size() * sizeof(std::uint32_t) +
                    m_closest.size() * sizeof(Closest);
  for (const Bone& bone : m_bones) {
    // The copies in PseudoNormals: corners, normal and neighbours of a triangle, normal of a vertex.
    const TriangleMesh& mesh = bone.surface.mesh;
    sum += sizeof(PseudoNormals) + mesh.triangles.size() * (2 * sizeof(Triangle) + sizeof(Vec3)) +
           mesh.vertices.size() * sizeof(Vec3);
  }
  return sum;
}

}  // namespace musclebench

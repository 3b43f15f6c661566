#include "backends/fcl/surfaces/node_contacts.hpp"

#include <cmath>
#include <utility>

namespace musclebench {

namespace {

/// A sum of unit normals and angles that is shorter than this is rounding.
constexpr double smallest_normal = 1e-9;

}  // namespace

NodeContacts::NodeContacts(std::vector<const Bone*> bones, std::vector<Triangle> muscle_triangles, std::size_t nodes)
    : m_bones(std::move(bones)), m_triangles(std::move(muscle_triangles)), m_met(nodes) {
  m_normals.reserve(m_bones.size());
  for (const Bone* bone : m_bones) {
    m_normals.emplace_back(bone->surface.mesh);
  }
}

void NodeContacts::append(int bone, const RigidMotion& pose, std::span<const TrianglePair> pairs,
                          std::span<const Vec3> positions, std::span<const int> wanted,
                          std::vector<Contact>& contacts) {
  if (pairs.empty()) {
    return;
  }
  const auto index = static_cast<std::size_t>(bone);
  m_met.start_round();
  measure_pairs(m_bones[index]->surface.mesh, pose, pairs, positions);
  for (const int node : wanted) {
    const MetTriangles::Closest* closest = m_met.find(node);
    if (closest == nullptr) {
      continue;
    }
    const Vec3 normal = m_normals[index].at(closest->triangle, closest->found.feature);
    const double length = normal.norm();
    // Where the faces about an edge or a corner cancel, as in a fin without thickness, there is no inside.
    if (length > smallest_normal && normal.dot(closest->point - closest->found.point) < 0) {
      contacts.push_back(
          {node, bone, std::sqrt(closest->found.squared_distance_m2), pose.apply_to_direction(normal / length)});
    }
  }
}

void NodeContacts::measure_pairs(const TriangleMesh& bone, const RigidMotion& pose, std::span<const TrianglePair> pairs,
                                 std::span<const Vec3> positions) {
  for (const TrianglePair& pair : pairs) {
    const auto& [a, b, c] = bone.triangles[static_cast<std::size_t>(pair.other_triangle)];
    for (const int node : m_triangles[static_cast<std::size_t>(pair.muscle_triangle)]) {
      m_met.meet(
          node, [&] { return pose.apply_inverse(positions[static_cast<std::size_t>(node)]); }, pair.other_triangle,
          bone.vertices[static_cast<std::size_t>(a)], bone.vertices[static_cast<std::size_t>(b)],
          bone.vertices[static_cast<std::size_t>(c)]);
    }
  }
}

std::size_t NodeContacts::bytes() const {
  std::size_t sum = sizeof(*this) + m_triangles.size() * sizeof(Triangle) + m_met.bytes();
  for (const Bone* bone : m_bones) {
    // The copies in PseudoNormals: corners, normal and neighbours of a triangle, normal of a vertex.
    const TriangleMesh& mesh = bone->surface.mesh;
    sum += sizeof(PseudoNormals) + mesh.triangles.size() * (2 * sizeof(Triangle) + sizeof(Vec3)) +
           mesh.vertices.size() * sizeof(Vec3);
  }
  return sum;
}

}  // namespace musclebench

#include "core/effects/no_passage/passage_paths.hpp"

#include <algorithm>

namespace musclebench {

namespace {

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

/// Levels that a tree of so many triangles needs.
int levels_for(std::size_t triangles) {
  int levels = 2;
  for (std::size_t below = bvh_width * bvh_width; below < triangles; below *= bvh_width) ++levels;
  return levels;
}

int levels_for_all(const TriangleMesh& mesh, std::span<const Bone> bones) {
  int levels = levels_for(mesh.triangles.size());
  for (const Bone& bone : bones) levels = std::max(levels, levels_for(bone.surface.mesh.triangles.size()));
  return levels;
}

std::vector<int> carriers_of(std::span<const BoundNode> bound_nodes, std::size_t nodes) {
  std::vector<int> carriers(nodes, -1);
  for (const BoundNode& bound : bound_nodes) carriers[at_index(bound.node)] = bound.bone;
  return carriers;
}

Vec3 middle_of(std::span<const Vec3> points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& point : points) sum += point;
  return sum / static_cast<double>(std::max<std::size_t>(points.size(), 1));
}

}  // namespace

PassagePaths::Muscle::Muscle(const TriangleMesh& mesh, const Body& body, int levels)
    : tree(mesh.triangles, mesh.vertices, body.first_triangle, body.last_triangle, levels),
      paths(tree, mesh.triangles) {}

PassagePaths::BoneSurface::BoneSurface(const TriangleMesh& surface, int levels)
    : mesh(surface),
      origin(middle_of(surface.vertices)),
      features(surface.triangles, surface.vertices.size()),
      around(surface.triangles, surface.vertices.size()),
      tree(surface.triangles, surface.vertices, 0, surface.triangles.size(), levels),
      still(tree, surface.triangles) {
  for (const Vec3& vertex : surface.vertices) vertices.emplace_back(vertex, vertex, origin);
  still.set(vertices, origin);
  still.change({});
}

PassagePaths::PassagePaths(const TriangleMesh& mesh, std::span<const Body> bodies, std::span<const Bone> bones,
                           std::span<const BoundNode> bound_nodes, bool with_itself, int threads)
    : m_mesh(mesh),
      m_bodies(bodies.begin(), bodies.end()),
      m_carriers(carriers_of(bound_nodes, mesh.vertices.size())),
      m_threads(threads),
      m_features(mesh.triangles, mesh.vertices.size()),
      m_around(mesh.triangles, mesh.vertices.size()),
      m_vertices(mesh.vertices.size()) {
  const int levels = levels_for_all(mesh, bones);
  for (const Body& body : m_bodies) m_muscles.emplace_back(mesh, body, levels);
  for (std::size_t one = 0; one < m_muscles.size(); ++one) {
    Muscle& first = m_muscles[one];
    for (std::size_t other = one + (with_itself ? 0 : 1); other < m_muscles.size(); ++other) {
      Muscle& second = m_muscles[other];
      m_meetings.push_back({-1, first.tree, second.tree, NearPairs(first.paths, second.paths)});
    }
  }
  std::vector<char> is_carried(m_carriers.size());
  for (std::size_t b = 0; b < bones.size(); ++b) {
    for (std::size_t node = 0; node < m_carriers.size(); ++node) {
      is_carried[node] = static_cast<char>(m_carriers[node] == static_cast<int>(b));
    }
    BoneSurface& bone = m_bones.emplace_back(bones[b].surface.mesh, levels);
    for (std::size_t body = 0; body < m_bodies.size(); ++body) {
      PathsInBone& muscle = bone.muscles.emplace_back(m_muscles[body].paths, mesh.triangles, is_carried,
                                                      at_index(m_bodies[body].first_node),
                                                      at_index(m_bodies[body].last_node), bone.origin);
      m_meetings.push_back({static_cast<int>(b), m_muscles[body].tree, bone.tree, NearPairs(muscle, bone.still)});
    }
  }
}

void PassagePaths::set(std::span<const Vec3> start, std::span<const Vec3> end,
                       std::span<const RigidMotion> previous_poses, std::span<const RigidMotion> poses) {
  m_start = start;
  m_end = end;
  m_origin = middle_of(start);  // distances that are known stay what they are
  for (std::size_t node = 0; node < start.size(); ++node) {
    m_vertices[node] = VertexPath(start[node], end[node], m_origin);
  }
  for (Muscle& muscle : m_muscles) muscle.paths.set(m_vertices, m_origin);
  for (std::size_t b = 0; b < m_bones.size(); ++b) {
    for (PathsInBone& muscle : m_bones[b].muscles) muscle.set(start, end, previous_poses[b], poses[b]);
  }
}

void PassagePaths::change(std::span<const int> nodes) {
  for (const int node : nodes) {
    m_vertices[at_index(node)] = VertexPath(m_start[at_index(node)], m_end[at_index(node)], m_origin);
  }
  for (std::size_t body = 0; body < m_bodies.size(); ++body) {
    const auto first = std::ranges::lower_bound(nodes, m_bodies[body].first_node);
    const auto last = std::ranges::lower_bound(nodes, m_bodies[body].last_node);
    m_muscles[body].paths.change({first, last});
    for (BoneSurface& bone : m_bones) bone.muscles[body].change({first, last});
  }
}

void PassagePaths::move_on() {
  for_each_meeting([](NearPairs& pairs) { pairs.move_on(); });
}

bool PassagePaths::is_held(const PassageStencil& stencil) const {
  bool are_all_carried = true;
  for (std::size_t k = 0; k < 4; ++k) {
    if (stencil.is_of_bone(k)) continue;
    const int carrier = m_carriers[at_index(stencil.corners[k])];
    are_all_carried = are_all_carried && carrier >= 0;
    if (stencil.bone >= 0 && carrier == stencil.bone) return false;
  }
  if (are_all_carried) return false;
  return stencil.bone >= 0 || !stencil.shares_a_vertex();
}

TrianglePath PassagePaths::path_of(int bone, std::size_t triangle) const {
  const int node = m_mesh.triangles[triangle][0];
  return bone < 0 ? m_muscles[body_of(m_bodies, node)].paths.triangle(triangle)
                  : paths_in(bone, node).triangle(triangle);
}

TrianglePath PassagePaths::path_of_other(int bone, std::size_t triangle) const {
  return bone < 0 ? path_of(-1, triangle) : m_bones[at_index(bone)].still.triangle(triangle);
}

PassagePaths::Corners PassagePaths::corners_of(int bone, std::size_t triangle) const {
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const int vertex = m_mesh.triangles[triangle][k];
    corners[k] = bone < 0 ? m_start[at_index(vertex)] : paths_in(bone, vertex).start(vertex);
  }
  return corners;
}

PassagePaths::Corners PassagePaths::corners_of_other(int bone, std::size_t triangle) const {
  if (bone < 0) return corners_of(-1, triangle);
  const TriangleMesh& mesh = m_bones[at_index(bone)].mesh;
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {mesh.vertices[at_index(a)], mesh.vertices[at_index(b)], mesh.vertices[at_index(c)]};
}

StencilCorners PassagePaths::starts_of(const PassageStencil& stencil) const {
  return corners_of(stencil, m_start, &PathsInBone::start);
}

StencilCorners PassagePaths::ends_of(const PassageStencil& stencil) const {
  return corners_of(stencil, m_end, &PathsInBone::end);
}

StencilCorners PassagePaths::corners_of(const PassageStencil& stencil, std::span<const Vec3> in_world,
                                        Vec3 (PathsInBone::*in_bone)(int) const) const {
  StencilCorners corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const int corner = stencil.corners[k];
    if (stencil.is_of_bone(k)) {
      corners[k] = m_bones[at_index(stencil.bone)].mesh.vertices[at_index(corner)];
    } else {
      corners[k] = stencil.bone < 0 ? in_world[at_index(corner)] : (paths_in(stencil.bone, corner).*in_bone)(corner);
    }
  }
  return corners;
}

Vec3 PassagePaths::normal_of(const PassageStencil& stencil, std::size_t corner) const {
  const int vertex = stencil.corners[corner];
  if (stencil.is_of_bone(corner)) {
    const BoneSurface& bone = m_bones[at_index(stencil.bone)];
    return bone.around.normal(vertex, bone.mesh.triangles, bone.mesh.vertices);
  }
  const Vec3 normal = m_around.normal(vertex, m_mesh.triangles, m_start);
  return stencil.bone < 0 ? normal : Vec3(paths_in(stencil.bone, vertex).from_world() * normal);
}

double PassagePaths::most_facing(const PassageStencil& stencil, bool of_first_side, const Vec3& direction) const {
  const bool is_edge = stencil.kind == StencilKind::edge_edge;
  const std::size_t second = is_edge ? 2 : 1;
  const std::size_t first = of_first_side ? 0 : second;
  const std::size_t last = is_edge ? first + 1 : (of_first_side ? second : 4);
  double most = -1;
  for (std::size_t k = first; k < last; ++k) {
    const int vertex = stencil.corners[k];
    const int other = is_edge ? stencil.corners[k + 1] : vertex;
    if (stencil.is_of_bone(k)) {
      const BoneSurface& bone = m_bones[at_index(stencil.bone)];
      most = std::max(most, bone.around.most_facing(vertex, other, bone.mesh.triangles, bone.mesh.vertices, direction));
    } else {
      const Vec3 in_world =
          stencil.bone < 0 ? direction : Vec3(paths_in(stencil.bone, vertex).from_world().transpose() * direction);
      most = std::max(most, m_around.most_facing(vertex, other, m_mesh.triangles, m_start, in_world));
    }
  }
  return most;
}

}  // namespace musclebench

#include "core/measure/crossings.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <iterator>
#include <set>

#include "core/mesh/mesh_size.hpp"
#include "core/referee/referee_sign.hpp"

namespace musclebench {
namespace {

/// Of two triangles whose boxes meet, in the unit of RefereeTree: up to eight exact predicates.
constexpr long work_of_a_pair = 5;

TriangleCorners corners_of(const Triangle& triangle, std::span<const Vec3> points) {
  const auto& [a, b, c] = triangle;
  return {points[static_cast<std::size_t>(a)], points[static_cast<std::size_t>(b)],
          points[static_cast<std::size_t>(c)]};
}

Eigen::AlignedBox3d box_of(const TriangleCorners& corners) {
  return {corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]), corners[0].cwiseMax(corners[1]).cwiseMax(corners[2])};
}

bool share_an_edge(const Triangle& one, const Triangle& other) {
  const auto shared = [&](int vertex) { return vertex == other[0] || vertex == other[1] || vertex == other[2]; };
  return shared(one[0]) + shared(one[1]) + shared(one[2]) >= 2;
}

Eigen::AlignedBox3d relative_to(const Vec3& centre, const Eigen::AlignedBox3d& box) {
  return {box.min() - centre, box.max() - centre};
}

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

}  // namespace

CrossingSums sums_of(std::span<const CrossingPair> pairs, std::span<const int> counts) {
  CrossingSums sums;
  for (std::size_t pair = 0; pair < counts.size(); ++pair) {
    if (pairs[pair].kind == CrossedSurface::bone) sums.in_bones += counts[pair];
    if (pairs[pair].kind == CrossedSurface::muscle) sums.in_muscles = sums.in_muscles.value_or(0) + counts[pair];
    if (pairs[pair].kind == CrossedSurface::itself) sums.in_itself += counts[pair];
  }
  return sums;
}

CrossingMeter::CrossingMeter(std::span<const Bone> bones, const TriangleMesh& muscles, std::span<const Body> bodies,
                             std::span<const int> carriers)
    : m_triangles(muscles.triangles),
      m_bodies(bodies.begin(), bodies.end()),
      m_carriers(carriers.begin(), carriers.end()),
      m_crosses_itself(muscles.triangles.size(), 0) {
  for (const Bone& bone : bones) {
    m_bones.push_back(bone.surface.mesh);
    m_bone_boxes.push_back(bounding_box(bone.surface.mesh.vertices));
  }
  for (int muscle = 0; muscle < std::ssize(m_bodies); ++muscle) {
    const Body& body = m_bodies[at_index(muscle)];
    for (int bone = 0; bone < std::ssize(m_bones); ++bone) {
      const auto first = m_triangles.begin() + static_cast<std::ptrdiff_t>(body.first_triangle);
      const auto last = m_triangles.begin() + static_cast<std::ptrdiff_t>(body.last_triangle);
      const auto left_out =
          std::count_if(first, last, [&](const Triangle& triangle) { return is_left_out(triangle, bone); });
      m_pairs.push_back({muscle, CrossedSurface::bone, bone, static_cast<int>(left_out)});
    }
    for (int other = muscle + 1; other < std::ssize(m_bodies); ++other) {
      m_pairs.push_back({muscle, CrossedSurface::muscle, other});
    }
    m_pairs.push_back({muscle, CrossedSurface::itself, muscle});
  }
}

bool CrossingMeter::is_left_out(const Triangle& triangle, int bone) const {
  const auto carrier = [&](int node) { return m_carriers[at_index(node)]; };
  return std::any_of(triangle.begin(), triangle.end(), [&](int node) { return carrier(node) == bone; }) ||
         std::all_of(triangle.begin(), triangle.end(), [&](int node) { return carrier(node) >= 0; });
}

std::vector<int> CrossingMeter::count(const Referee& referee, const RefereeTree& tree,
                                      std::span<const RigidMotion> poses, std::span<const Vec3> positions) {
  assert(poses.size() == m_bones.size() && positions.size() == m_carriers.size());
  m_work = 0;
  m_passing.clear();
  m_rest.resize(positions.size());
  for (int bone = 0; bone < std::ssize(m_bones); ++bone) {
    std::transform(positions.begin(), positions.end(), m_rest.begin(),
                   [&](const Vec3& point) { return poses[at_index(bone)].apply_inverse(point); });
    for (std::size_t pair = 0; pair < m_pairs.size(); ++pair) {
      if (m_pairs[pair].kind != CrossedSurface::bone || m_pairs[pair].other != bone) continue;
      find_in_bone(pair, referee.tree(bone));
    }
  }
  find_in_muscles(tree, positions);
  return counts_of_last();
}

std::vector<int> CrossingMeter::counts_of_last() const {
  std::vector<int> counts(m_pairs.size(), 0);
  for (const Passing& passing : m_passing) ++counts[passing.pair];
  return counts;
}

void CrossingMeter::take_as_rest() {
  m_at_rest = counts_of_last();
  std::vector<std::vector<char>> has_node(m_pairs.size());
  for (const Passing& passing : m_passing) {
    std::vector<char>& nodes = has_node[passing.pair];
    nodes.resize(m_carriers.size(), 0);
    for (const int node : m_triangles[at_index(passing.triangle)]) nodes[at_index(node)] = 1;
  }
  m_near_at_rest.assign(m_pairs.size(), {});
  for (std::size_t pair = 0; pair < m_pairs.size(); ++pair) {
    if (m_at_rest[pair] == 0) continue;
    std::vector<char>& near = m_near_at_rest[pair];
    std::transform(m_triangles.begin(), m_triangles.end(), std::back_inserter(near), [&](const Triangle& triangle) {
      return std::any_of(triangle.begin(), triangle.end(),
                         [&](int node) { return has_node[pair][at_index(node)] != 0; });
    });
  }
}

std::vector<int> CrossingMeter::beyond_rest() const {
  std::vector<int> beyond = counts_of_last();
  if (m_at_rest.empty()) return beyond;
  std::vector<int> near(m_pairs.size(), 0);
  for (const Passing& passing : m_passing) {
    const std::vector<char>& near_at_rest = m_near_at_rest[passing.pair];
    if (!near_at_rest.empty()) near[passing.pair] += near_at_rest[at_index(passing.triangle)];
  }
  for (std::size_t pair = 0; pair < beyond.size(); ++pair) beyond[pair] -= std::min(m_at_rest[pair], near[pair]);
  return beyond;
}

void CrossingMeter::find_in_bone(std::size_t pair, const RefereeTree& tree) {
  const Body& body = m_bodies[at_index(m_pairs[pair].muscle)];
  const int bone = m_pairs[pair].other;
  for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
    if (is_left_out(m_triangles[t], bone) || !passes_through_bone(m_triangles[t], bone, tree)) continue;
    m_passing.push_back({pair, static_cast<int>(t)});
  }
  m_work += static_cast<long>(body.last_triangle - body.first_triangle);
}

bool CrossingMeter::passes_through_bone(const Triangle& triangle, int bone, const RefereeTree& tree) {
  const TriangleCorners corners = corners_of(triangle, m_rest);
  const Eigen::AlignedBox3d box = box_of(corners);
  if (!m_bone_boxes[at_index(bone)].intersects(box)) return false;
  const TriangleMesh& mesh = m_bones[at_index(bone)];
  tree.find_near_box(relative_to(tree.centre_m(), box), m_near, &m_work);
  return std::any_of(m_near.begin(), m_near.end(), [&](int near) {
    const TriangleCorners other = corners_of(mesh.triangles[at_index(near)], mesh.vertices);
    if (!box.intersects(box_of(other))) return false;
    m_work += work_of_a_pair;
    return pass_through_each_other(corners, other);
  });
}

/// Each two triangles once: those of a muscle with later ones of it, and with those of later muscles.
void CrossingMeter::find_in_muscles(const RefereeTree& tree, std::span<const Vec3> positions) {
  std::fill(m_crosses_itself.begin(), m_crosses_itself.end(), 0);
  m_in_muscles.clear();
  std::vector<char> crosses(m_bodies.size());  // each later muscle
  for (std::size_t muscle = 0; muscle < m_bodies.size(); ++muscle) {
    const Body& body = m_bodies[muscle];
    for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
      const TriangleCorners corners = corners_of(m_triangles[t], positions);
      const Eigen::AlignedBox3d box = box_of(corners);
      tree.find_near_box(relative_to(tree.centre_m(), box), m_near, &m_work);
      std::fill(crosses.begin(), crosses.end(), 0);
      for (const int near : m_near) {
        const std::size_t other = at_index(near);
        if (other <= t) continue;
        const bool same = other < body.last_triangle;
        const std::size_t of = same ? muscle : body_of(m_bodies, m_triangles[other][0]);
        if (same && m_crosses_itself[t] != 0 && m_crosses_itself[other] != 0) continue;
        if (same && share_an_edge(m_triangles[t], m_triangles[other])) continue;
        const TriangleCorners corners_of_other = corners_of(m_triangles[other], positions);
        if (!box.intersects(box_of(corners_of_other))) continue;
        m_work += work_of_a_pair;
        if (!pass_through_each_other(corners, corners_of_other)) continue;
        if (same) m_crosses_itself[t] = m_crosses_itself[other] = 1;
        crosses[of] = 1;
        if (same) continue;
        m_in_muscles.push_back({static_cast<int>(t), static_cast<int>(of)});
        m_in_muscles.push_back({near, static_cast<int>(muscle)});
      }
      for (std::size_t other = muscle + 1; other < m_bodies.size(); ++other) {
        if (crosses[other] != 0) m_passing.push_back({pair_of(muscle, other), static_cast<int>(t)});
      }
    }
    for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
      if (m_crosses_itself[t] != 0) m_passing.push_back({pair_of(muscle, muscle), static_cast<int>(t)});
    }
  }
  std::sort(m_in_muscles.begin(), m_in_muscles.end());
  m_in_muscles.erase(std::unique(m_in_muscles.begin(), m_in_muscles.end()), m_in_muscles.end());
}

/// Of two muscles, or of one and itself.
std::size_t CrossingMeter::pair_of(std::size_t muscle, std::size_t other) const {
  const std::size_t bones = m_bones.size(), bodies = m_bodies.size();
  const std::size_t before = muscle * bones + muscle * bodies - muscle * (muscle - 1) / 2;  // pairs of earlier muscles
  return before + bones + (other == muscle ? bodies - muscle - 1 : other - muscle - 1);
}

std::vector<SharedFaces> shared_faces(const TriangleMesh& muscles, std::span<const Body> bodies) {
  using Face = std::array<std::array<double, 3>, 3>;
  std::vector<std::set<Face>> faces;
  for (const Body& body : bodies) {
    std::set<Face>& own = faces.emplace_back();
    for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
      Face face;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& corner = muscles.vertices[at_index(muscles.triangles[t][k])];
        face[k] = {corner.x(), corner.y(), corner.z()};
      }
      std::sort(face.begin(), face.end());
      own.insert(face);
    }
  }
  std::vector<SharedFaces> found;
  for (std::size_t one = 0; one < faces.size(); ++one) {
    for (std::size_t other = one + 1; other < faces.size(); ++other) {
      const auto shared =
          std::ranges::count_if(faces[one], [&](const Face& face) { return faces[other].contains(face); });
      if (shared > 0) found.push_back({static_cast<int>(one), static_cast<int>(other), static_cast<int>(shared)});
    }
  }
  return found;
}

int count_self_crossings(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return 0;
  const Body all{"", 0, static_cast<int>(mesh.vertices.size()), 0, mesh.triangles.size()};
  CrossingMeter meter({}, mesh, std::span(&all, 1), std::vector<int>(mesh.vertices.size(), -1));
  return meter.count(Referee({}, 0), RefereeTree(mesh), {}, mesh.vertices).back();
}

}  // namespace musclebench

#include "core/effects/no_passage/left_out.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "core/distance/winding_number.hpp"
#include "core/effects/no_passage/passage_overlaps.hpp"

namespace musclebench {

namespace {

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

}  // namespace

LeftOut::LeftOut(PassagePaths& paths, std::span<const Bone> bones, std::span<const Body> bodies, double touching_m)
    : m_paths(paths), m_bones(bones), m_bodies(bodies), m_touching_m(touching_m) {
  m_is_out.assign((bones.size() + bodies.size()) * nodes(), 0);
}

void LeftOut::update(std::span<const Vec3> at, std::span<const RigidMotion> poses) {
  const bool is_first = std::exchange(m_is_first, false);
  m_paths.set(at, at, poses, poses);
  const std::vector<char> intersects = intersecting(is_first);
  m_is_still_out = intersects;
  for (std::size_t collider = 0; collider < m_bones.size() + m_bodies.size(); ++collider) {
    const auto out = std::span(m_is_out).subspan(collider * nodes(), nodes());
    if (!is_first && std::ranges::find(out, 1) == out.end()) continue;
    add_enclosed(collider, intersects, is_first, at, poses);
  }
  m_is_out.swap(m_is_still_out);
  m_is_any = std::ranges::find(m_is_out, 1) != m_is_out.end();
}

bool LeftOut::has(const PassageStencil& stencil) const {
  if (!m_is_any) return false;
  const std::size_t second = stencil.kind == StencilKind::node_face ? 1 : 2;
  for (std::size_t k = 0; k < 4; ++k) {
    if (stencil.is_of_bone(k)) continue;
    const std::size_t collider = stencil.bone >= 0
                                     ? at_index(stencil.bone)
                                     : m_bones.size() + m_paths.body_of_node(stencil.corners[k < second ? 3 : 0]);
    if (m_is_out[slot(collider, stencil.corners[k])] != 0) return true;
  }
  return false;
}

bool LeftOut::concerns(int bone, std::size_t triangle, std::size_t other) const {
  if (!m_is_any) return false;
  if (bone >= 0) return has_any(at_index(bone), triangle);
  return has_any(muscle_of(other), triangle) || has_any(muscle_of(triangle), other);
}

bool LeftOut::has_any(std::size_t collider, std::size_t triangle) const {
  return std::ranges::any_of(m_paths.mesh().triangles[triangle],
                             [&](int node) { return m_is_out[slot(collider, node)] != 0; });
}

/// By collider and node: of a triangle that intersects the collider, and after the first time was left out.
std::vector<char> LeftOut::intersecting(bool is_first) {
  std::vector<char> intersects(m_is_out.size(), 0);
  const auto mark = [&](std::size_t collider, std::size_t triangle) {
    for (const int node : m_paths.mesh().triangles[triangle]) {
      if (is_first || m_is_out[slot(collider, node)] != 0) intersects[slot(collider, node)] = 1;
    }
  };
  const auto collider_of = [&](const PassageOverlap& pair) {
    return pair.bone >= 0 ? at_index(pair.bone) : muscle_of(pair.other);
  };
  const auto is_wanted = [&](const PassageOverlap& pair) {
    return is_first || concerns(pair.bone, pair.triangle, pair.other);
  };
  for (const PassageOverlap& pair : find_overlaps(m_paths, m_touching_m, is_wanted)) {
    mark(collider_of(pair), pair.triangle);
    if (pair.bone < 0) mark(muscle_of(pair.triangle), pair.other);
  }
  return intersects;
}

/// Parts of muscles without such nodes that lie inside a collider; after the first time parts of those that were left
/// out that hang together with what intersects it, or lie inside.
void LeftOut::add_enclosed(std::size_t collider, std::span<const char> intersects, bool is_first,
                           std::span<const Vec3> at, std::span<const RigidMotion> poses) {
  const auto is_of_part = [&](int node) {
    const std::size_t i = slot(collider, node);
    return is_first ? intersects[i] == 0 : m_is_out[i] != 0;
  };
  const std::size_t own = collider - m_bones.size();  // where it is a muscle
  m_parts.reset(nodes());
  for (const Triangle& triangle : m_paths.mesh().triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int next = triangle[(k + 1) % 3];
      if (is_of_part(triangle[k]) && is_of_part(next)) m_parts.join(triangle[k], next);
    }
  }
  std::map<int, std::vector<int>> parts;
  for (int node = 0; node < static_cast<int>(nodes()); ++node) {
    if (!is_of_part(node)) continue;
    if (is_first && collider >= m_bones.size() && m_bodies[own].has_node(node)) continue;
    parts[m_parts.find(node)].push_back(node);
  }
  for (const auto& [first, part] : parts) {
    const bool hangs_together =
        std::ranges::any_of(part, [&](int node) { return intersects[slot(collider, node)] != 0; });
    const bool is_own = collider >= m_bones.size() && m_bodies[own].has_node(first);
    if (!hangs_together && (is_own || !is_inside(collider, part, at, poses))) continue;
    for (const int node : part) m_is_still_out[slot(collider, node)] = 1;
  }
}

/// Whether most of some nodes are, by the collider's winding number: about 1 inside, less at its surface.
bool LeftOut::is_inside(std::size_t collider, std::span<const int> nodes, std::span<const Vec3> at,
                        std::span<const RigidMotion> poses) const {
  constexpr std::size_t most_asked = 5;
  constexpr double least_winding = 0.75;
  const std::size_t asked = std::min(most_asked, nodes.size());
  std::size_t inside = 0;
  for (std::size_t i = 0; i < asked; ++i) {
    const Vec3& node = at[at_index(nodes[i * nodes.size() / asked])];
    double winding = 0;
    if (collider < m_bones.size()) {
      winding = m_bones[collider].tree().winding_number(poses[collider].apply_inverse(node));
    } else {
      const Body& body = m_bodies[collider - m_bones.size()];
      winding = winding_number(
          std::span(m_paths.mesh().triangles).subspan(body.first_triangle, body.last_triangle - body.first_triangle),
          at, node);
    }
    inside += winding > least_winding ? 1 : 0;
  }
  return 2 * inside > asked;
}

}  // namespace musclebench

#include "core/effects/no_passage/left_out.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "core/distance/winding_number.hpp"
#include "core/effects/no_passage/joined_sets.hpp"

namespace musclebench {

namespace {

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

}  // namespace

LeftOut::LeftOut(PassagePaths& paths, std::span<const Bone> bones, std::span<const Body> bodies, double touching_m)
    : m_paths(paths),
      m_bones(bones),
      m_bodies(bodies),
      m_touching_m(touching_m),
      m_part_of((bones.size() + bodies.size()) * nodes(), -1) {}

void LeftOut::begin(std::span<const Vec3> at, std::span<const RigidMotion> poses) {
  m_paths.set(at, at, poses, poses);
  std::vector<char> is_out(m_part_of.size(), 0);
  for (const TrianglePair& pair : find_overlaps(m_paths, m_touching_m)) {
    for_each_node(pair, [&](std::size_t collider, int node) { is_out[slot(collider, node)] = 1; });
  }
  for (std::size_t collider = 0; collider < m_bones.size() + m_bodies.size(); ++collider) {
    const auto is_part = [&](int node) { return is_out[slot(collider, node)] != 0; };
    const auto is_other = [&](int node) { return !is_part(node) && !is_of(collider, node); };
    for (const std::vector<int>& inner : joined(is_other)) {
      if (!is_inside(collider, inner, at, poses)) continue;
      for (const int node : inner) is_out[slot(collider, node)] = 1;
    }
    for (std::vector<int>& part : joined(is_part)) {
      for (const int node : part) m_part_of[slot(collider, node)] = static_cast<int>(m_parts.size());
      m_parts.push_back({collider, std::move(part)});
    }
  }
  m_left = m_parts.size();
}

void LeftOut::update(std::span<const TrianglePair> through, std::span<const Vec3> at,
                     std::span<const RigidMotion> poses) {
  std::vector<char> goes_through(m_parts.size(), 0);
  for (const TrianglePair& pair : through) {
    for_each_node(pair, [&](std::size_t collider, int node) {
      const int part = m_part_of[slot(collider, node)];
      if (part >= 0) goes_through[at_index(part)] = 1;
    });
  }
  for (std::size_t i = 0; i < m_parts.size(); ++i) {
    auto& [collider, part] = m_parts[i];
    // What hangs together with what goes through is inside of it.
    if (part.empty() || goes_through[i] != 0) continue;
    if (!is_of(collider, part.front()) && is_inside(collider, part, at, poses)) continue;
    for (const int node : part) m_part_of[slot(collider, node)] = -1;
    part.clear();
    --m_left;
  }
}

bool LeftOut::has(const PassageStencil& stencil) const {
  if (!is_any()) return false;
  const std::size_t second = stencil.kind == StencilKind::node_face ? 1 : 2;
  for (std::size_t k = 0; k < 4; ++k) {
    if (stencil.is_of_bone(k)) continue;
    const std::size_t collider = stencil.bone >= 0
                                     ? at_index(stencil.bone)
                                     : m_bones.size() + m_paths.body_of_node(stencil.corners[k < second ? 3 : 0]);
    if (m_part_of[slot(collider, stencil.corners[k])] >= 0) return true;
  }
  return false;
}

bool LeftOut::concerns(const TrianglePair& pair) const {
  if (!is_any()) return false;
  if (pair.bone >= 0) return has_any(at_index(pair.bone), pair.triangle);
  return has_any(muscle_of(pair.other), pair.triangle) || has_any(muscle_of(pair.triangle), pair.other);
}

bool LeftOut::has_any(std::size_t collider, std::size_t triangle) const {
  return std::ranges::any_of(m_paths.mesh().triangles[triangle],
                             [&](int node) { return m_part_of[slot(collider, node)] >= 0; });
}

template <typename Mark>
void LeftOut::for_each_node(const TrianglePair& pair, const Mark& mark) const {
  const std::vector<Triangle>& triangles = m_paths.mesh().triangles;
  const std::size_t collider = pair.bone >= 0 ? at_index(pair.bone) : muscle_of(pair.other);
  for (const int node : triangles[pair.triangle]) mark(collider, node);
  if (pair.bone >= 0) return;
  for (const int node : triangles[pair.other]) mark(muscle_of(pair.triangle), node);
}

template <typename IsWanted>
std::vector<std::vector<int>> LeftOut::joined(const IsWanted& is_wanted) const {
  JoinedSets sets;
  sets.reset(nodes());
  for (const Triangle& triangle : m_paths.mesh().triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int next = triangle[(k + 1) % 3];
      if (is_wanted(triangle[k]) && is_wanted(next)) sets.join(triangle[k], next);
    }
  }
  std::map<int, std::vector<int>> by_first;
  for (int node = 0; node < static_cast<int>(nodes()); ++node) {
    if (is_wanted(node)) by_first[sets.find(node)].push_back(node);
  }
  std::vector<std::vector<int>> parts;
  for (auto& [first, part] : by_first) parts.push_back(std::move(part));
  return parts;
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

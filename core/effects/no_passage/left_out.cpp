#include "core/effects/no_passage/left_out.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "core/distance/winding_number.hpp"

namespace musclebench {

namespace {

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

}  // namespace

LeftOut::LeftOut(PassagePaths& paths, std::span<const Bone> bones, std::span<const Body> bodies, double touching_m)
    : m_paths(paths), m_bones(bones), m_bodies(bodies), m_touching_m(touching_m) {
  m_is_out.assign((bones.size() + bodies.size()) * nodes(), 0);
  m_goes_through = m_is_out;
  m_parts.resize(bones.size() + bodies.size());
}

void LeftOut::begin(std::span<const Vec3> at, std::span<const RigidMotion> poses) {
  m_paths.set(at, at, poses, poses);
  for (const PassageOverlap& pair : find_overlaps(m_paths, m_touching_m)) {
    for_each_node(pair, [&](std::size_t collider, int node) { m_is_out[slot(collider, node)] = 1; });
  }
  std::vector<int> all_nodes(nodes());
  std::iota(all_nodes.begin(), all_nodes.end(), 0);
  const std::vector<Triangle>& triangles = m_paths.mesh().triangles;
  std::vector<std::size_t> all_triangles(triangles.size());
  std::iota(all_triangles.begin(), all_triangles.end(), std::size_t{0});
  for (std::size_t collider = 0; collider < m_parts.size(); ++collider) {
    const auto is_other = [&](int node) { return m_is_out[slot(collider, node)] == 0 && !is_of(collider, node); };
    for (const std::vector<int>& part : joined(all_nodes, all_triangles, is_other)) {
      if (!is_inside(collider, part, at, poses)) continue;
      for (const int node : part) m_is_out[slot(collider, node)] = 1;
    }
    for (const int node : all_nodes) {
      if (m_is_out[slot(collider, node)] != 0) m_parts[collider].nodes.push_back(node);
    }
    for (const std::size_t t : all_triangles) {
      if (has_any(collider, t)) m_parts[collider].triangles.push_back(t);
    }
    m_is_any = m_is_any || !m_parts[collider].nodes.empty();
  }
}

void LeftOut::update(std::span<const PassageOverlap> through, std::span<const Vec3> at,
                     std::span<const RigidMotion> poses) {
  for (const PassageOverlap& pair : through) {
    for_each_node(pair, [&](std::size_t collider, int node) { m_goes_through[slot(collider, node)] = 1; });
  }
  m_is_any = false;
  for (std::size_t collider = 0; collider < m_parts.size(); ++collider) {
    auto& [out, triangles] = m_parts[collider];
    const auto goes_through = [&](int node) { return m_goes_through[slot(collider, node)] != 0; };
    const auto is_out = [&](int node) { return m_is_out[slot(collider, node)] != 0; };
    for (const std::vector<int>& part : joined(out, triangles, is_out)) {
      // What hangs together with what goes through is inside of it.
      const bool stays = std::ranges::any_of(part, goes_through) ||
                         (!is_of(collider, part.front()) && is_inside(collider, part, at, poses));
      if (stays) continue;
      for (const int node : part) m_is_out[slot(collider, node)] = 0;
    }
    std::erase_if(out, [&](int node) { return !is_out(node); });
    std::erase_if(triangles, [&](std::size_t t) { return !has_any(collider, t); });
    m_is_any = m_is_any || !out.empty();
  }
  for (const PassageOverlap& pair : through) {
    for_each_node(pair, [&](std::size_t collider, int node) { m_goes_through[slot(collider, node)] = 0; });
  }
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

bool LeftOut::concerns(const PassageOverlap& pair) const {
  if (!m_is_any) return false;
  if (pair.bone >= 0) return has_any(at_index(pair.bone), pair.triangle);
  return has_any(muscle_of(pair.other), pair.triangle) || has_any(muscle_of(pair.triangle), pair.other);
}

bool LeftOut::has_any(std::size_t collider, std::size_t triangle) const {
  return std::ranges::any_of(m_paths.mesh().triangles[triangle],
                             [&](int node) { return m_is_out[slot(collider, node)] != 0; });
}

template <typename Mark>
void LeftOut::for_each_node(const PassageOverlap& pair, const Mark& mark) const {
  const std::vector<Triangle>& triangles = m_paths.mesh().triangles;
  const std::size_t collider = pair.bone >= 0 ? at_index(pair.bone) : muscle_of(pair.other);
  for (const int node : triangles[pair.triangle]) mark(collider, node);
  if (pair.bone >= 0) return;
  for (const int node : triangles[pair.other]) mark(muscle_of(pair.triangle), node);
}

template <typename IsWanted>
std::vector<std::vector<int>> LeftOut::joined(std::span<const int> candidates, std::span<const std::size_t> triangles,
                                              const IsWanted& is_wanted) {
  if (candidates.empty()) return {};
  m_sets.reset(nodes());
  for (const std::size_t t : triangles) {
    const Triangle& triangle = m_paths.mesh().triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const int next = triangle[(k + 1) % 3];
      if (is_wanted(triangle[k]) && is_wanted(next)) m_sets.join(triangle[k], next);
    }
  }
  std::map<int, std::vector<int>> sets;
  for (const int node : candidates) {
    if (is_wanted(node)) sets[m_sets.find(node)].push_back(node);
  }
  std::vector<std::vector<int>> parts;
  for (auto& [first, part] : sets) parts.push_back(std::move(part));
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

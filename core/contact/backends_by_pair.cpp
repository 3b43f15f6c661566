#include "core/contact/backends_by_pair.hpp"

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

namespace musclebench {

namespace {

/// Some muscles of a mesh: all its vertices, so that nodes keep their numbers, and the triangles of these.
struct PartOfMesh {
  TriangleMesh surface;
  std::vector<Body> muscles;  ///< with their triangles' new places
};

PartOfMesh part_of(const TriangleMesh& mesh, std::span<const Body> muscles) {
  PartOfMesh part{{mesh.vertices, {}}, {muscles.begin(), muscles.end()}};
  std::vector<Triangle>& triangles = part.surface.triangles;
  for (Body& muscle : part.muscles) {
    const auto own =
        std::span(mesh.triangles).subspan(muscle.first_triangle, muscle.last_triangle - muscle.first_triangle);
    muscle.first_triangle = triangles.size();
    triangles.insert(triangles.end(), own.begin(), own.end());
    muscle.last_triangle = triangles.size();
  }
  return part;
}

bool by_bone_and_node(const Contact& a, const Contact& b) {
  return std::pair(a.bone, a.node) < std::pair(b.bone, b.node);
}

}  // namespace

BackendsByPair::BackendsByPair(std::vector<Part> parts) : m_parts(std::move(parts)) { assert(!m_parts.empty()); }

Capabilities BackendsByPair::capabilities() const {
  Capabilities all = m_parts.front().backend->capabilities();
  for (const Part& part : m_parts) {
    const Capabilities own = part.backend->capabilities();
    all.depth = all.depth && own.depth;
    all.point_queries = all.point_queries && own.point_queries;
    all.has_cache = all.has_cache || own.has_cache;
    all.has_step = all.has_step && own.has_step;
    all.steady_memory = all.steady_memory && own.steady_memory;
    all.times_pairs = all.times_pairs && own.times_pairs;
  }
  return all;
}

template <typename Look>
void BackendsByPair::for_each_part_of(int bone, const Look& look) const {
  for (const Part& part : m_parts) {
    const std::size_t index = static_cast<std::size_t>(bone) - part.first_bone;  // huge before the first
    if (index < part.bones) look(*part.backend, static_cast<int>(index));
  }
}

AnswerBound BackendsByPair::answer_bound(int bone) const {
  AnswerBound loosest;
  for_each_part_of(bone, [&](const CollisionBackend& backend, int own_bone) {
    const AnswerBound own = backend.answer_bound(own_bone);
    loosest.missed_depth_m = std::max(loosest.missed_depth_m, own.missed_depth_m);
    loosest.false_distance_m = std::max(loosest.false_distance_m, own.false_distance_m);
    loosest.storage_m = std::max(loosest.storage_m, own.storage_m);
  });
  return loosest;
}

double BackendsByPair::step_m(int bone) const {
  double smallest_m = 0;
  for_each_part_of(bone, [&](const CollisionBackend& backend, int own_bone) {
    const double own_m = backend.step_m(own_bone);
    if (own_m > 0 && (smallest_m == 0 || own_m < smallest_m)) smallest_m = own_m;
  });
  return smallest_m;
}

std::size_t BackendsByPair::structure_bytes() const {
  std::size_t bytes = 0;
  for (const Part& part : m_parts) bytes += part.backend->structure_bytes();
  return bytes;
}

StructureOrigin BackendsByPair::structure_origin() const {
  std::optional<StructureOrigin> all;
  for (const Part& part : m_parts) {
    const StructureOrigin own = part.backend->structure_origin();
    all = all ? all->with(own) : own;
  }
  return all.value_or(StructureOrigin{});
}

std::vector<StructureError> BackendsByPair::structure_errors() const {
  std::vector<StructureError> errors;
  for (const Part& part : m_parts) {
    const std::vector<StructureError> own = part.backend->structure_errors();
    errors.insert(errors.end(), own.begin(), own.end());
  }
  return errors;
}

void BackendsByPair::expect_within(std::vector<Eigen::AlignedBox3d> boxes) {
  for (const Part& part : m_parts) {
    const auto first = boxes.begin() + static_cast<std::ptrdiff_t>(part.first_bone);
    part.backend->expect_within({first, first + static_cast<std::ptrdiff_t>(part.bones)});
  }
  CollisionBackend::expect_within(std::move(boxes));
}

std::vector<PrunedBone> BackendsByPair::pruned_bones() const {
  std::vector<PrunedBone> all;
  for (const Part& part : m_parts) {
    for (PrunedBone pruned : part.backend->pruned_bones()) {
      pruned.bone += static_cast<int>(part.first_bone);
      all.push_back(pruned);
    }
  }
  return all;
}

void BackendsByPair::do_build() {
  double structures = 0;
  for (const Part& part : m_parts) structures += static_cast<double>(part.bones);
  double done = 0;
  m_surfaces.resize(m_parts.size());
  for (std::size_t i = 0; i < m_parts.size(); ++i) {
    const Part& part = m_parts[i];
    const auto own = static_cast<double>(part.bones);
    if (build_report()) {
      part.backend->report_build_to(
          [this, done, own, structures](double share) { build_report()((done + share * own) / structures); });
    }
    const bool has_all = part.muscles.empty();
    if (has_all) {
      part.backend->tell_apart({muscles().begin(), muscles().end()});
    } else {
      PartOfMesh own_part = part_of(muscle(), part.muscles);
      m_surfaces[i] = std::move(own_part.surface);
      if (!muscles().empty()) part.backend->tell_apart(std::move(own_part.muscles));
    }
    part.backend->build(bones().subspan(part.first_bone, part.bones), has_all ? muscle() : m_surfaces[i], threads());
    done += own;
  }
  m_nodes.reserve(muscle().vertices.size());
}

void BackendsByPair::do_update(std::span<const Vec3> positions) {
  for (const Part& part : m_parts) {
    part.backend->update(poses().subspan(part.first_bone, part.bones), positions);
  }
}

std::span<const int> BackendsByPair::nodes_of(const Part& part, std::span<const int> nodes) {
  if (part.muscles.empty()) {
    return nodes;
  }
  m_nodes.clear();
  for (const Body& muscle : part.muscles) {
    const auto first = std::ranges::lower_bound(nodes, muscle.first_node);
    m_nodes.insert(m_nodes.end(), first, std::lower_bound(first, nodes.end(), muscle.last_node));
  }
  return m_nodes;
}

void BackendsByPair::add_times_of(const Part& part) {
  const std::span<const Nanoseconds> times = part.backend->pair_times();
  if (times.empty() || muscles().empty()) {
    return;
  }
  const std::size_t own_muscles = times.size() / part.bones;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::size_t own = i % own_muscles;
    const std::size_t muscle = part.muscles.empty() ? own : body_of(muscles(), part.muscles[own].first_node);
    add_pair_time(part.first_bone + i / own_muscles, muscle, times[i]);
  }
}

void BackendsByPair::do_detect(std::span<const Vec3> positions, std::span<const int> nodes,
                               std::vector<Contact>& contacts) {
  for (const Part& part : m_parts) {
    const std::span<const int> own = nodes_of(part, nodes);
    if (own.empty()) continue;
    part.backend->detect(positions, own, m_found);
    for (Contact contact : m_found) {
      contact.bone += static_cast<int>(part.first_bone);
      contacts.push_back(contact);
    }
    add_times_of(part);
  }
  // Several parts may answer for a bone.
  if (!std::is_sorted(contacts.begin(), contacts.end(), by_bone_and_node)) {
    std::sort(contacts.begin(), contacts.end(), by_bone_and_node);
  }
}

}  // namespace musclebench

#include "core/contact/backends_by_bone.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace musclebench {

BackendsByBone::BackendsByBone(std::vector<Part> parts) : m_parts(std::move(parts)) { assert(!m_parts.empty()); }

Capabilities BackendsByBone::capabilities() const {
  Capabilities all = m_parts.front().backend->capabilities();
  for (const Part& part : m_parts) {
    const Capabilities own = part.backend->capabilities();
    all.depth = all.depth && own.depth;
    all.point_queries = all.point_queries && own.point_queries;
    all.has_cache = all.has_cache || own.has_cache;
    all.has_step = all.has_step && own.has_step;
    all.steady_memory = all.steady_memory && own.steady_memory;
  }
  return all;
}

BackendsByBone::Assignment BackendsByBone::assignment_of(int bone) const {
  std::size_t left = static_cast<std::size_t>(bone);
  for (const Part& part : m_parts) {
    if (left < part.bones) {
      return {*part.backend, static_cast<int>(left)};
    }
    left -= part.bones;
  }
  assert(false);
  return {*m_parts.back().backend, 0};
}

AnswerBound BackendsByBone::answer_bound(int bone) const {
  const Assignment assigned = assignment_of(bone);
  return assigned.backend.answer_bound(assigned.bone);
}

double BackendsByBone::step_m(int bone) const {
  const Assignment assigned = assignment_of(bone);
  return assigned.backend.step_m(assigned.bone);
}

std::size_t BackendsByBone::structure_bytes() const {
  std::size_t bytes = 0;
  for (const Part& part : m_parts) bytes += part.backend->structure_bytes();
  return bytes;
}

bool BackendsByBone::built_from_file() const {
  return std::all_of(m_parts.begin(), m_parts.end(), [](const Part& part) { return part.backend->built_from_file(); });
}

std::vector<StructureError> BackendsByBone::structure_errors() const {
  std::vector<StructureError> errors;
  for (const Part& part : m_parts) {
    const std::vector<StructureError> own = part.backend->structure_errors();
    errors.insert(errors.end(), own.begin(), own.end());
  }
  return errors;
}

void BackendsByBone::do_build() {
  std::size_t first = 0;
  for (const Part& part : m_parts) {
    const double before = static_cast<double>(first);
    const auto bones_of_part = static_cast<double>(part.bones);
    if (build_report()) {
      part.backend->report_build_to([this, before, bones_of_part](double share) {
        build_report()((before + share * bones_of_part) / static_cast<double>(bones().size()));
      });
    }
    part.backend->build(bones().subspan(first, part.bones), muscle(), threads());
    first += part.bones;
  }
  assert(first == bones().size());
}

void BackendsByBone::do_update(std::span<const Vec3> positions) {
  std::size_t first = 0;
  for (const Part& part : m_parts) {
    part.backend->update(poses().subspan(first, part.bones), positions);
    first += part.bones;
  }
}

void BackendsByBone::do_detect(std::span<const Vec3> positions, std::span<const int> nodes,
                               std::vector<Contact>& contacts) {
  int first = 0;
  for (const Part& part : m_parts) {
    part.backend->detect(positions, nodes, m_found);
    for (Contact contact : m_found) {
      contact.bone += first;
      contacts.push_back(contact);
    }
    first += static_cast<int>(part.bones);
  }
}

}  // namespace musclebench

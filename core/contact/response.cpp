#include "core/contact/response.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

void collect_nodes(std::span<const Contact> contacts, std::vector<int>& nodes) {
  nodes.clear();
  for (const Contact& contact : contacts) {
    nodes.push_back(contact.node);
  }
  // Of each bone in ascending order, and mostly of one bone.
  if (!std::is_sorted(nodes.begin(), nodes.end())) {
    std::sort(nodes.begin(), nodes.end());
  }
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

void push_out(std::span<const Contact> contacts, std::span<Vec3> positions) {
  for (const Contact& contact : contacts) {
    positions[contact.node] += contact.depth_m * contact.normal;
  }
}

}  // namespace

const std::vector<ResponseEntry>& response_registry() {
  static const std::vector<ResponseEntry> entries = {
      {ResponseKind::backtrack, "backtrack",
       "back to where the substep began, a cell at a time, until free; who began in the bone follows it"},
      {ResponseKind::project, "project",
       "along the contact's normal by its depth, at most three times or `[contact] steps`"},
  };
  return entries;
}

const std::string& name_of(ResponseKind kind) {
  const auto& entries = response_registry();
  return std::find_if(entries.begin(), entries.end(), [&](const ResponseEntry& e) { return e.kind == kind; })->name;
}

ResponseKind find_response(std::string_view name, std::string_view location) {
  std::vector<std::string> known;
  for (const ResponseEntry& entry : response_registry()) {
    if (entry.name == name) {
      return entry.kind;
    }
    known.push_back(entry.name);
  }
  const std::string word(name);
  throw InputError(std::string(location),
                   "'" + word + "' is not a response; did you mean '" + nearest_word(word, known) + "'?");
}

std::string_view lacks_for(ResponseKind kind, const Capabilities& capabilities) {
  if (kind == ResponseKind::project) {
    return capabilities.depth ? "" : "depth to project by";
  }
  if (!capabilities.point_queries) {
    return "answer about single nodes on their way back";
  }
  return capabilities.has_step ? "" : "cells whose size is the step back";
}

Response::Response(std::vector<BoneResponse> of_pairs, std::vector<Body> muscles)
    : m_of_pairs(std::move(of_pairs)), m_muscles(std::move(muscles)) {
  assert(!m_of_pairs.empty());
  if (std::ranges::all_of(m_of_pairs, [&](const BoneResponse& each) { return each == m_of_pairs.front(); })) {
    m_of_pairs.resize(1);
  }
  for (const BoneResponse& each : m_of_pairs) {
    m_most_steps = std::max(m_most_steps, each.steps);
  }
}

const BoneResponse& Response::of(const Contact& contact) const {
  if (m_of_pairs.size() == 1) {
    return m_of_pairs.front();
  }
  const auto bone = static_cast<std::size_t>(contact.bone);
  if (m_muscles.size() < 2) {
    return m_of_pairs[bone];
  }
  const std::size_t bones = m_of_pairs.size() / m_muscles.size();
  return m_of_pairs[body_of(m_muscles, contact.node) * bones + bone];
}

void Response::reserve(std::size_t nodes, std::size_t bones) {
  m_contacts.reserve(nodes * bones);
  m_nodes.reserve(nodes * bones);  // before those in contact with several bones become one
  if (m_joint_steps > 0) {
    m_joint_index.resize(nodes);
    m_joint_start.reserve(nodes);
    m_half_spaces.reserve(nodes * bones);
  }
  if (m_of_pairs.size() > 1) {
    m_backtracked.reserve(nodes * bones);
    m_projected.reserve(nodes * bones);
  }
  if (std::ranges::any_of(m_of_pairs, [](const BoneResponse& each) { return each.kind == ResponseKind::backtrack; })) {
    m_trial.reserve(nodes);
    m_corrections.reserve(nodes * bones);
  }
}

void Response::resolve(CollisionBackend& backend, const ResponseInput& input, std::span<const Contact> contacts,
                       std::span<Vec3> predicted) {
  std::span<const Contact> projected = contacts;
  std::span<const Contact> backtracked;
  if (m_of_pairs.size() > 1) {
    m_projected.clear();
    m_backtracked.clear();
    for (const Contact& contact : contacts) {
      (of(contact).kind == ResponseKind::project ? m_projected : m_backtracked).push_back(contact);
    }
    projected = m_projected;
    backtracked = m_backtracked;
  } else if (m_of_pairs.front().kind == ResponseKind::backtrack) {
    std::swap(projected, backtracked);
  }
  // Backtracking first: it needs p, and projection adds depths that were detected there.
  if (!backtracked.empty()) {
    backtrack(backend, input, backtracked, predicted);
  }
  if (!projected.empty()) {
    if (m_joint_steps > 0) {
      project_out_of_all(backend, projected, predicted, input.bone_poses.size());
    } else {
      project(backend, projected, predicted);
    }
  }
}

void Response::project(CollisionBackend& backend, std::span<const Contact> contacts, std::span<Vec3> predicted) {
  push_out(contacts, predicted);
  if (!backend.capabilities().point_queries) {
    return;
  }
  collect_nodes(contacts, m_nodes);
  for (int step = 1; step < m_most_steps; ++step) {
    backend.detect(predicted, m_nodes, m_contacts);
    if (m_of_pairs.size() > 1) {
      std::erase_if(m_contacts, [&](const Contact& contact) {
        const BoneResponse& own = of(contact);
        return own.kind != ResponseKind::project || own.steps <= step;
      });
    }
    if (m_contacts.empty()) {
      return;
    }
    for (Contact& contact : m_contacts) contact.depth_m += m_margin_m;
    push_out(m_contacts, predicted);
    collect_nodes(m_contacts, m_nodes);
  }
}

void Response::project_out_of_all(CollisionBackend& backend, std::span<const Contact> contacts,
                                  std::span<Vec3> predicted, std::size_t bones) {
  const HalfSpace not_met{Vec3::Zero(), -std::numeric_limits<double>::infinity()};
  m_joint_index.resize(predicted.size());
  collect_nodes(contacts, m_nodes);
  m_joint_start.clear();
  for (const int node : m_nodes) {
    m_joint_index[static_cast<std::size_t>(node)] = static_cast<int>(m_joint_start.size());
    m_joint_start.push_back(predicted[node]);
  }
  m_half_spaces.assign(m_nodes.size() * bones, not_met);
  for (int step = 1;; ++step) {
    for (const Contact& contact : contacts) {
      const auto index = static_cast<std::size_t>(m_joint_index[static_cast<std::size_t>(contact.node)]);
      const double moved_m = contact.normal.dot(predicted[contact.node] - m_joint_start[index]);
      m_half_spaces[index * bones + static_cast<std::size_t>(contact.bone)] = {contact.normal,
                                                                               contact.depth_m + moved_m};
    }
    for (const int node : m_nodes) move_out_of_all(node, predicted, bones);
    if (step >= m_joint_steps || !backend.capabilities().point_queries) {
      return;
    }
    backend.detect(predicted, m_nodes, m_contacts);
    std::erase_if(m_contacts, [&](const Contact& contact) { return of(contact).kind != ResponseKind::project; });
    if (m_contacts.empty()) {
      return;
    }
    for (Contact& contact : m_contacts) contact.depth_m += m_margin_m;
    contacts = m_contacts;
    collect_nodes(contacts, m_nodes);
  }
}

void Response::move_out_of_all(int node, std::span<Vec3> predicted, std::size_t bones) {
  const auto index = static_cast<std::size_t>(m_joint_index[static_cast<std::size_t>(node)]);
  HalfSpaces met;
  for (const HalfSpace& each : std::span(m_half_spaces).subspan(index * bones, bones)) {
    if (std::isfinite(each.depth_m)) met.add(each);
  }
  predicted[node] = m_joint_start[index] + least_displacement(met);
}

void Response::backtrack(CollisionBackend& backend, const ResponseInput& input, std::span<const Contact> contacts,
                         std::span<Vec3> predicted) {
  assert(backend.capabilities().point_queries);
  m_trial.resize(predicted.size());
  m_corrections.assign(contacts.size(), Vec3::Zero());
  for (std::size_t first = 0; first < contacts.size();) {
    std::size_t last = first;
    while (last < contacts.size() && contacts[last].bone == contacts[first].bone) {
      ++last;
    }
    const auto of_bone = contacts.subspan(first, last - first);
    backtrack_from_bone(backend, input, of_bone, predicted);
    for (std::size_t i = first; i < last; ++i) {
      m_corrections[i] = m_trial[contacts[i].node] - predicted[contacts[i].node];
    }
    first = last;
  }
  // Only now: every bone has to see the same p, else the answer would depend on the order of the bones.
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    predicted[contacts[i].node] += m_corrections[i];
  }
}

/// Leaves the freed positions of the nodes of `contacts` (all of one bone) in m_trial.
void Response::backtrack_from_bone(CollisionBackend& backend, const ResponseInput& input,
                                   std::span<const Contact> contacts, std::span<const Vec3> predicted) {
  const int bone = contacts.front().bone;
  m_nodes.clear();
  for (const Contact& contact : contacts) {
    m_nodes.push_back(contact.node);
    m_trial[contact.node] = input.substep_start[contact.node];
  }

  backend.detect(m_trial, m_nodes, m_contacts);
  const RigidMotion bone_motion = input.bone_poses[bone] * input.previous_bone_poses[bone].inverse();
  auto next_start_inside = m_contacts.begin();
  m_nodes.clear();
  for (const Contact& contact : contacts) {
    while (next_start_inside != m_contacts.end() &&
           (next_start_inside->bone < bone ||
            (next_start_inside->bone == bone && next_start_inside->node < contact.node))) {
      ++next_start_inside;
    }
    if (next_start_inside != m_contacts.end() && next_start_inside->bone == bone &&
        next_start_inside->node == contact.node) {
      m_trial[contact.node] = bone_motion.apply(input.substep_start[contact.node]);
    } else {
      m_nodes.push_back(contact.node);
    }
  }

  const double step_m = backend.step_m(bone);
  assert(step_m > 0);
  // Backtracking ends at x, which is free, so it is finite however far p is.
  for (double walked_m = step_m; !m_nodes.empty(); walked_m += step_m) {
    for (const int node : m_nodes) {
      const Vec3 back = input.substep_start[node] - predicted[node];
      const double length_m = back.norm();
      m_trial[node] =
          walked_m >= length_m ? input.substep_start[node] : Vec3(predicted[node] + (walked_m / length_m) * back);
    }
    std::erase_if(m_nodes, [&](int node) { return m_trial[node] == input.substep_start[node]; });
    backend.detect(m_trial, m_nodes, m_contacts);
    keep_nodes_in_contact_with(bone);
  }
}

void Response::keep_nodes_in_contact_with(int bone) {
  m_nodes.clear();
  for (const Contact& contact : m_contacts) {
    if (contact.bone == bone) {
      m_nodes.push_back(contact.node);
    }
  }
}

}  // namespace musclebench

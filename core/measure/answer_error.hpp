#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

/// How far answers are from the truth, gathered over any number of collision steps. Contacts are pairs of a bone and a
/// node.
struct AnswerErrors {
  long contacts = 0;  ///< answered
  long true_contacts = 0;
  long missed_contacts = 0;         ///< true ones that were not answered
  long false_contacts = 0;          ///< answered ones that are not true
  double max_missed_depth_m = 0;    ///< of the missed contacts, however deep
  double max_false_distance_m = 0;  ///< of the false contacts, however far
  /// One a contact that is true and answered, where the backend tells depths. What is missed or false has none: how
  /// deep a missed contact is says what one substep moves a node, and nothing of the backend (see SurfaceOffsets).
  std::vector<double> depth_errors_m;
  std::vector<double> normal_errors_deg;  ///< the same, where both sides know a normal

  void add(const AnswerErrors& other);
};

/// Input and answer of a backend in one collision step.
struct JudgedAnswer {
  std::span<const RigidMotion> bone_poses;
  std::span<const Vec3> positions;    ///< world frame, m
  std::span<const Contact> contacts;  ///< ordered by bone, then node
  bool depths_known = true;           ///< Capabilities::depth of the backend
};

/// The truth about the node of a contact and the surface that the contact is with: the normal is in the world frame.
using TrueSurface = std::function<SurfaceDistance(const Contact& contact)>;

/// Compares the answer, ordered by `Contact::bone`, then node, with `truth`, the Referee's of the same nodes in the
/// same order, and adds to `errors`. `surface_at` is asked where a contact is not true.
///
/// The depth error is the difference between the answered depth and the Referee's, the normal error the angle between
/// their normals, of contacts that both see and that are not deeper than `band_m`.
void measure_answer(const TrueSurface& surface_at, std::span<const Contact> answered, bool depths_known,
                    std::span<const Contact> truth, double band_m, AnswerErrors& errors);

/// The same of rigid bones.
void measure_answer(const Referee& referee, const JudgedAnswer& answer, std::span<const Contact> truth, double band_m,
                    AnswerErrors& errors);

}  // namespace musclebench

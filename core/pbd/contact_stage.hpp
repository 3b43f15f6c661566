#pragma once

#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Input and output of a contact stage: all nodes, world frame, m.
struct ContactStageInput {
  std::span<Vec3> start;      ///< x: positions at the start of the substep
  std::span<Vec3> predicted;  ///< p, after the constraints
  std::span<const int> free_nodes;
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const RigidMotion> bone_poses;
  std::span<const Contact> contacts;  ///< with bones, as they were found at p; none before the bones
  /// How far what overlaps as the run begins is laid out in this step at most (ContactRowSolver).
  double depenetration_m = std::numeric_limits<double>::infinity();
};

/// A part of the collision step besides the backend's detection and the response; like an effect it has a name and a
/// column of its own. At each of the points of the step below, stages run in the order that they were added in.
class ContactStage {
 public:
  ContactStage() = default;
  ContactStage(const ContactStage&) = delete;
  ContactStage& operator=(const ContactStage&) = delete;
  virtual ~ContactStage() = default;

  /// Its column in frames.csv is this with `_ns`.
  [[nodiscard]] virtual std::string_view name() const = 0;

  // Each of these may correct `predicted`, and `start` where a correction is to give no velocity, and returns the nodes
  // that it may have moved, valid until the next call.

  /// After the constraints, before the bone response: bones are rigid and have the last word.
  virtual std::span<const int> before_bones(const ContactStageInput& /*input*/) { return {}; }
  /// After the bone response.
  virtual std::span<const int> after_bones(const ContactStageInput& /*input*/) { return {}; }

  /// After the backend's detection: may add contacts with bones or change depths. Contacts stay ordered by bone, then
  /// node, at most one a node and bone.
  virtual void add_contacts(const ContactStageInput& /*input*/, std::vector<Contact>& /*contacts*/) {}
  /// After all contacts are known; moves nothing.
  virtual void before_response(const ContactStageInput& /*input*/) {}

  /// How many contacts the last step found, or nodes it acted on.
  [[nodiscard]] virtual int contact_count() const = 0;
};

}  // namespace musclebench

#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

class ContactImpulses;

/// The input and output of a contact stage. Positions are those of all nodes, in the world frame, in metres.
struct ContactStageInput {
  std::span<Vec3> start;      ///< x: positions at the start of the substep
  std::span<Vec3> predicted;  ///< p, after the constraints
  std::span<const int> free_nodes;
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const RigidMotion> bone_poses;
  std::span<const Contact> contacts;  ///< contacts with bones, found at p; empty in `before_bones`
  /// How far a node that overlapped at the start of the run may be moved out in this step, at most, m.
  double depenetration_m = std::numeric_limits<double>::infinity();
  ContactImpulses* impulses = nullptr;  ///< to which a stage adds what it does to nodes; null: nobody asks
};

/// An additional part of the collision step, such as contact between muscles. Derive from it and override what you
/// need. The loop calls the functions below at fixed points of the step, from one thread. Stages run in the order in
/// which they were added.
class ContactStage {
 public:
  ContactStage() = default;
  ContactStage(const ContactStage&) = delete;
  ContactStage& operator=(const ContactStage&) = delete;
  virtual ~ContactStage() = default;

  /// The name of the stage. Its column in frames.csv is this name with `_ns`.
  [[nodiscard]] virtual std::string_view name() const = 0;

  // These three may correct `predicted`. They correct `start` as well if the correction must not give the node a
  // velocity. They return the nodes that they may have moved. The span is valid until the next call.

  /// After the constraints and before the bone response. Bones are rigid, so their response comes later and wins.
  virtual std::span<const int> before_bones(const ContactStageInput& /*input*/) { return {}; }
  /// After the bone response.
  virtual std::span<const int> after_bones(const ContactStageInput& /*input*/) { return {}; }

  /// After the last collision step of a substep and before velocities are updated.
  virtual std::span<const int> end_substep(const ContactStageInput& /*input*/) { return {}; }

  /// After the backend's detection. May add contacts with bones or change depths. Keep contacts ordered by bone and
  /// then by node, with at most one for each node and bone.
  virtual void add_contacts(const ContactStageInput& /*input*/, std::vector<Contact>& /*contacts*/) {}
  /// After all contacts are known and before the response. Moves nothing.
  virtual void before_response(const ContactStageInput& /*input*/) {}

  /// The number of contacts that the last step found, or of nodes that it acted on.
  [[nodiscard]] virtual int contact_count() const = 0;
  /// What it promises and could not hold since the run began, in words; empty: nothing.
  [[nodiscard]] virtual std::string gave_up() const { return {}; }
};

}  // namespace musclebench

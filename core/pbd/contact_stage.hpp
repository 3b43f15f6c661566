#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What a contact stage works on: all nodes, world frame, m.
struct ContactStageInput {
  std::span<Vec3> start;      ///< x: positions at the start of the substep
  std::span<Vec3> predicted;  ///< p, after the constraints
  std::span<const int> free_nodes;
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const RigidMotion> bone_poses;
  std::span<const Contact> contacts;  ///< with bones, as they were found at p; none before the bones
};

/// A part of the collision step beside the backend's, as an effect is a part of the constraints: it has a name, a time
/// and a column of its own. Stages run in their order at the moments that concern them.
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

  /// After the constraints: bones come later, since they give way to nothing.
  virtual std::span<const int> before_bones(const ContactStageInput& /*input*/) { return {}; }
  /// When nodes have left the bones.
  virtual std::span<const int> after_bones(const ContactStageInput& /*input*/) { return {}; }

  /// After the backend's detection: more contacts with bones, or other depths. They stay ordered by bone, then node,
  /// and at most one a node and bone.
  virtual void add_contacts(const ContactStageInput& /*input*/, std::vector<Contact>& /*contacts*/) {}
  /// When all contacts are known; moves nothing.
  virtual void before_response(const ContactStageInput& /*input*/) {}

  /// How many contacts the last step found, or nodes it acted on.
  [[nodiscard]] virtual int contact_count() const = 0;
};

}  // namespace musclebench

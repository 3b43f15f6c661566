#pragma once

#include <span>
#include <string_view>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What a contact stage works on: all nodes, world frame, m.
struct ContactStageInput {
  std::span<Vec3> start;      ///< x: positions at the start of the substep
  std::span<Vec3> predicted;  ///< p, after the constraints
};

/// A part of the collision step beside the backend's, as an effect is a part of the constraints: it has a name, a time
/// and a column of its own. Stages run in their order after the constraints; bones come last, since they give way to
/// nothing.
class ContactStage {
 public:
  ContactStage() = default;
  ContactStage(const ContactStage&) = delete;
  ContactStage& operator=(const ContactStage&) = delete;
  virtual ~ContactStage() = default;

  /// Its column in frames.csv is this with `_ns`.
  [[nodiscard]] virtual std::string_view name() const = 0;

  /// Corrects `predicted`, and `start` where a correction is to give no velocity. Returns the nodes that it may have
  /// moved, valid until the next call.
  virtual std::span<const int> collide(const ContactStageInput& input) = 0;

  /// How many contacts the last step found.
  [[nodiscard]] virtual int contact_count() const = 0;
};

}  // namespace musclebench

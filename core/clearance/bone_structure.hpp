#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/clearance/clearance_cache.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// Nodes that one thread queries against one bone.
struct NodeBatch {
  int bone;
  const RigidMotion& pose;          ///< of the bone
  std::span<const Vec3> positions;  ///< of all nodes: world frame, metres
  std::span<const int> nodes;       ///< indices into `positions`
  /// Where not null: each of `nodes` has left its safe sphere of this bone or has none, and may be given a new one.
  ClearanceCache* clearances;
};

/// A backend's structure over one bone in rest pose, queried about single nodes. A backend that answers node by node
/// implements nothing else (see `make_point_backend`).
class BoneStructure {
 public:
  BoneStructure() = default;
  BoneStructure(const BoneStructure&) = delete;
  BoneStructure& operator=(const BoneStructure&) = delete;
  virtual ~BoneStructure() = default;

  [[nodiscard]] virtual AnswerBound answer_bound() const = 0;
  /// Counted from sizes (deterministic), with the state of each node.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
  /// The smallest edge of a cell, in metres; 0 without cells.
  [[nodiscard]] virtual double step_m() const { return 0; }
  /// Of a structure that approximates; without the bone's name.
  [[nodiscard]] virtual std::optional<StructureError> error() const { return std::nullopt; }
  [[nodiscard]] virtual StructureOrigin origin() const { return {}; }

  /// Of the grid over the bone the share of cells that was built; less than 1 where a part is expected to do.
  [[nodiscard]] virtual double kept_share() const { return 1; }
  /// Whether `detect` was asked about a point in what is left out, so that its answers may lack contacts.
  [[nodiscard]] virtual bool found_left_out() const { return false; }

  /// Empties the state that is kept of each node between detections, and makes room for this many nodes. Called with a
  /// clearance cache only.
  virtual void reset_nodes(std::size_t /*nodes*/) {}

  /// Appends the contacts of the batch in the order of its nodes; a position that is not finite has none. Several
  /// threads call at once, with different nodes.
  virtual void detect(const NodeBatch& batch, std::vector<Contact>& contacts) = 0;
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/clearance/clearance_cache.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// A batch of nodes that one thread queries against one bone.
struct NodeBatch {
  int bone;
  const RigidMotion& pose;          ///< pose of the bone, from its rest frame to the world frame
  std::span<const Vec3> positions;  ///< of all nodes: world frame, metres
  std::span<const int> nodes;       ///< the nodes to query, as indices into `positions`
  /// Not null if a clearance cache is in use. Each of `nodes` then has no safe sphere or has left it, and `detect` may
  /// store a new one.
  ClearanceCache* clearances;
};

/// A backend's structure over one bone in rest pose, for queries of single nodes. Derive from it if your backend can
/// answer each node alone; `make_point_backend` does the rest. Query points in the bone's rest frame:
/// `batch.pose.apply_inverse(position)`.
class BoneStructure {
 public:
  BoneStructure() = default;
  BoneStructure(const BoneStructure&) = delete;
  BoneStructure& operator=(const BoneStructure&) = delete;
  virtual ~BoneStructure() = default;

  /// An upper bound of the error of the answers. The contract tests check it.
  [[nodiscard]] virtual AnswerBound answer_bound() const = 0;
  /// Memory of the structure, including the state of nodes. Count it from sizes, so that it is the same in every run.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
  /// The smallest edge of a cell, in metres. 0 without cells.
  [[nodiscard]] virtual double step_m() const { return 0; }
  /// Error of an approximate structure. `bone` is left empty.
  [[nodiscard]] virtual std::optional<StructureError> error() const { return std::nullopt; }
  /// Whether the structure was computed or read from a file.
  [[nodiscard]] virtual StructureOrigin origin() const { return {}; }

  /// The share of the grid's cells that was built. Less than 1 if only a part was expected to be needed.
  [[nodiscard]] virtual double kept_share() const { return 1; }
  /// Whether `detect` was queried outside the built part, so that contacts may be missing.
  [[nodiscard]] virtual bool found_left_out() const { return false; }

  /// Clears the state that is kept for each node between detections, and allocates it for `nodes` nodes. Called only if
  /// a clearance cache is in use.
  virtual void reset_nodes(std::size_t /*nodes*/) {}

  /// Appends the contacts of the batch to `contacts`, in the order of its nodes. A position that is not finite has no
  /// contact. Several threads call it at once, with different nodes.
  virtual void detect(const NodeBatch& batch, std::vector<Contact>& contacts) = 0;
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/contact/least_displacement.hpp"
#include "core/mesh/body.hpp"

namespace musclebench {

/// The method that moves a node out of a bone.
enum class ResponseKind {
  /// Moves the node back from its predicted position p towards its previous position x, step by step, until it is free.
  /// A node whose x is inside as well follows the bone (paper, II-A and III-B).
  backtrack,
  /// Moves the node along the contact normal by the depth. Repeats until no depth is left or the steps are used up
  /// (paper, IV-A: three steps).
  project,
};

/// The default number of steps of the response `project`. A step is a detection and a correction.
inline constexpr int default_projection_steps = 3;

/// The response to contacts of one muscle with one bone.
struct BoneResponse {
  ResponseKind kind = ResponseKind::project;
  int steps = default_projection_steps;  ///< largest number of steps of `project`; >= 1

  friend bool operator==(const BoneResponse&, const BoneResponse&) = default;
};

/// A row of the table of responses: a kind with its name and a line of help.
struct ResponseEntry {
  ResponseKind kind;
  std::string name;
  std::string help;
};

/// The table of responses. Safe from several threads, as are the functions below.
const std::vector<ResponseEntry>& response_registry();

/// The name of a response, as in scene files.
const std::string& name_of(ResponseKind kind);

/// The response of that name. Throws InputError that names `location` if the name is unknown.
ResponseKind find_response(std::string_view name, std::string_view location);

/// What a response needs and a backend with these capabilities lacks, in words. Empty if it lacks nothing.
std::string_view lacks_for(ResponseKind kind, const Capabilities& capabilities);

/// The state of a substep that a response reads. Positions are in metres in the world frame.
struct ResponseInput {
  std::span<const Vec3> substep_start;               ///< x: positions at the start of the substep, by node
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const RigidMotion> bone_poses;           ///< the poses that contacts were found with
};

/// Moves the predicted positions p of nodes out of bones. The corrections by several bones are added (paper, IV-C). All
/// start from the same p. Keeps scratch memory, so two threads must not share one object.
class Response {
 public:
  /// One response for all bones. `steps` is used by `project` only.
  Response(ResponseKind kind, int steps = default_projection_steps)  // NOLINT(google-explicit-constructor)
      : Response(std::vector{BoneResponse{kind, steps}}) {}
  /// `of_pairs` has one response for all, one for each bone, or one for each muscle and bone. In the last case the
  /// first muscle comes with all bones, then the second muscle, and so on. `muscles` is needed in that case only.
  explicit Response(std::vector<BoneResponse> of_pairs, std::vector<Body> muscles = {});

  /// Changes how `project` treats a node that is in several bones. Instead of adding the corrections, it moves the node
  /// to the closest position outside all tangent planes found so far (`least_displacement`). `steps` is the largest
  /// number of detections in a collision step.
  void project_out_of_all(int steps) { m_joint_steps = steps; }

  /// Nodes that are still in a bone after their first correction leave it by `margin_m` more
  /// (`ContactProperties::margin_m`, m). The depths of the contacts that `resolve` is given include it already.
  void set_margin(double margin_m) { m_margin_m = margin_m; }

  /// Allocates the memory for `nodes` nodes and `bones` bones. `resolve` then allocates nothing.
  void reserve(std::size_t nodes, std::size_t bones);

  /// Corrects `predicted`, which has a position for each node. `contacts` must be the result of the last detection at
  /// `predicted`, ordered by bone and then by node. Calls `backend.detect` for further steps.
  void resolve(CollisionBackend& backend, const ResponseInput& input, std::span<const Contact> contacts,
               std::span<Vec3> predicted);

 private:
  [[nodiscard]] const BoneResponse& of(const Contact& contact) const;
  void project(CollisionBackend& backend, std::span<const Contact> contacts, std::span<Vec3> predicted);
  void project_out_of_all(CollisionBackend& backend, std::span<const Contact> contacts, std::span<Vec3> predicted,
                          std::size_t bones);
  void move_out_of_all(int node, std::span<Vec3> predicted, std::size_t bones);
  void backtrack(CollisionBackend& backend, const ResponseInput& input, std::span<const Contact> contacts,
                 std::span<Vec3> predicted);
  void backtrack_from_bone(CollisionBackend& backend, const ResponseInput& input, std::span<const Contact> contacts,
                           std::span<const Vec3> predicted);
  void keep_nodes_in_contact_with(int bone);

  std::vector<BoneResponse> m_of_pairs;
  std::vector<Body> m_muscles;
  int m_most_steps = 0;
  int m_joint_steps = 0;  ///< 0: corrections are added
  double m_margin_m = 0;
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<Contact> m_backtracked;  ///< contacts of this kind, if pairs differ
  std::vector<Contact> m_projected;
  std::vector<Contact> m_contacts;
  std::vector<int> m_nodes;
  std::vector<Vec3> m_trial;
  std::vector<Vec3> m_corrections;
  // For nodes that are projected out of all bones together, in the order of their first contacts.
  std::vector<int> m_joint_index;        ///< by node
  std::vector<Vec3> m_joint_start;       ///< p before the response
  std::vector<HalfSpace> m_half_spaces;  ///< one for each bone, relative to the start; depth -infinity: not met yet
};

}  // namespace musclebench

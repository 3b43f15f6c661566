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

/// How a node inside a bone is moved out.
enum class ResponseKind {
  /// Back from p towards x, step by step, until free; a node whose x is inside too follows the bone (paper, II-A and
  /// III-B).
  backtrack,
  /// Along the contact normal by the depth, until the depth is gone or so many steps are done (paper, IV-A: three).
  project,
};

/// Detections, and corrections by them, of the response `project`.
inline constexpr int default_projection_steps = 3;

/// How the nodes of a muscle are moved out of a bone.
struct BoneResponse {
  ResponseKind kind = ResponseKind::project;
  int steps = default_projection_steps;  ///< of projecting, at most; >= 1

  friend bool operator==(const BoneResponse&, const BoneResponse&) = default;
};

/// One row of the table of responses.
struct ResponseEntry {
  ResponseKind kind;
  std::string name;
  std::string help;
};

const std::vector<ResponseEntry>& response_registry();

const std::string& name_of(ResponseKind kind);

/// The response of that name. Throws InputError that names `location` for an unknown one.
ResponseKind find_response(std::string_view name, std::string_view location);

/// What a backend with these capabilities lacks for a response; empty: nothing.
std::string_view lacks_for(ResponseKind kind, const Capabilities& capabilities);

/// State of the substep that a response reads.
struct ResponseInput {
  std::span<const Vec3> substep_start;               ///< x: positions at the start of the substep, world
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const RigidMotion> bone_poses;           ///< the poses that contacts were found with
};

/// Corrects `predicted` (p) so that it leaves the bones. Corrections by several bones are added (paper, IV-C); those of
/// all bones start from the same p, whatever their kinds.
class Response {
 public:
  /// The same for all bones.
  Response(ResponseKind kind, int steps = default_projection_steps)  // NOLINT(google-explicit-constructor)
      : Response(std::vector{BoneResponse{kind, steps}}) {}
  /// One for all, one a bone, or, of several muscles, one a muscle and bone: those of the first muscle with all bones,
  /// then those of the next.
  explicit Response(std::vector<BoneResponse> of_pairs, std::vector<Body> muscles = {});

  /// From now on a node that is to be projected out of bones goes to the closest position outside the tangent planes of
  /// all that detections have met, instead of along the sum of their pushes; at most so many detections a step.
  void project_out_of_all(int steps) { m_joint_steps = steps; }

  /// Makes room for all that `nodes` nodes and `bones` bones can need: `resolve` then allocates nothing.
  void reserve(std::size_t nodes, std::size_t bones);

  /// `contacts` are those of the last detection at `predicted`, ordered by bone, then node.
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
  int m_joint_steps = 0;  ///< 0: pushes are added
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<Contact> m_backtracked;  ///< contacts of this kind, where pairs differ
  std::vector<Contact> m_projected;
  std::vector<Contact> m_contacts;
  std::vector<int> m_nodes;
  std::vector<Vec3> m_trial;
  std::vector<Vec3> m_corrections;
  // Of nodes that are projected out of all bones together, in the order of their first contacts.
  std::vector<int> m_joint_index;        ///< by node
  std::vector<Vec3> m_joint_start;       ///< p before the response
  std::vector<HalfSpace> m_half_spaces;  ///< one a bone, about the start; depth -infinity: not met yet
};

}  // namespace musclebench

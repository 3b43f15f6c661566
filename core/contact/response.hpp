#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// How a node that was found inside a bone gets out again.
enum class ResponseKind {
  /// Back from p towards x, step by step, until free; a node whose x is inside too follows the bone (paper, II-A and
  /// III-B).
  backtrack,
  /// Along the contact normal by the depth, until the depth is gone or so many steps are done (paper, IV-A: three).
  project,
};

/// Detections, and corrections by them, of the response `project`.
inline constexpr int default_projection_steps = 3;

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

/// What a response needs to know of the substep.
struct ResponseInput {
  std::span<const Vec3> substep_start;               ///< x: positions at the start of the substep, world
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const RigidMotion> bone_poses;           ///< the poses that contacts were found with
};

/// Corrects `predicted` (p) so that it leaves the bones. Corrections by several bones are added (paper, IV-C).
class Response {
 public:
  /// `projection_steps` >= 1: of the response `project`.
  explicit Response(ResponseKind kind, int projection_steps = default_projection_steps)
      : m_kind(kind), m_projection_steps(projection_steps) {}

  /// Makes room for all that `nodes` nodes and `bones` bones can need: `resolve` then allocates nothing.
  void reserve(std::size_t nodes, std::size_t bones);

  /// `contacts` are those of the last detection at `predicted`, ordered by bone, then node.
  void resolve(CollisionBackend& backend, const ResponseInput& input, std::span<const Contact> contacts,
               std::span<Vec3> predicted);

 private:
  void project(CollisionBackend& backend, std::span<const Contact> contacts, std::span<Vec3> predicted);
  void backtrack(CollisionBackend& backend, const ResponseInput& input, std::span<const Contact> contacts,
                 std::span<Vec3> predicted);
  void backtrack_from_bone(CollisionBackend& backend, const ResponseInput& input, std::span<const Contact> contacts,
                           std::span<const Vec3> predicted);
  void keep_nodes_in_contact_with(int bone);

  ResponseKind m_kind;
  int m_projection_steps;
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<Contact> m_contacts;
  std::vector<int> m_nodes;
  std::vector<Vec3> m_trial;
  std::vector<Vec3> m_corrections;
};

}  // namespace musclebench

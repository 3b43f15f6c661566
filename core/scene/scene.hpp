#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/contact/muscle_contact.hpp"
#include "core/contact/response.hpp"
#include "core/fibres/fibre_segments.hpp"
#include "core/mesh/bound_node.hpp"
#include "core/pbd/simulation.hpp"
#include "core/scene/attachment_area.hpp"
#include "core/scene/bone_motion.hpp"
#include "core/scene/mesh_placement.hpp"
#include "core/scene/scene_warning.hpp"

namespace musclebench {

/// The nodes of one muscle that one bone carries because the scene says so.
struct Attachment {
  std::string name;
  int bone = 0;
  std::size_t muscle = 0;
  AttachmentArea area;
  std::vector<int> nodes;     ///< ascending
  std::string location = {};  ///< file and line, for messages
};

struct SceneEffect {
  std::string name;
  Parameters parameters;
  std::string location = {};               ///< file (or preset) and line, for messages
  std::vector<std::string> own_keys = {};  ///< parameters that the scene gives itself, not its preset
  bool is_own = false;                     ///< has a table in the scene
};

struct SceneMesh {
  std::string reference;      ///< as the scene names it
  std::string sha256;         ///< of the coordinates and indices of `mesh`
  TriangleMesh mesh;          ///< as shipped, in metres where the scene places it (MeshPlacement)
  std::string location = {};  ///< file and line of its table, for messages
  bool has_unit = false;      ///< the scene gives its unit or scale
  MeshPlacement placement = {};
};

/// A muscle: what its file holds, and which of the scene's nodes and triangles are made of it (see weld_mesh).
struct Muscle {
  Body body;  ///< its name, nodes and triangles in `Scene::muscle_mesh`
  SceneMesh file;
  std::vector<int> node_of_vertex;   ///< of each vertex of the file; -1 for one that no triangle uses
  std::vector<std::string> changes;  ///< what welding did
  std::vector<FibreSegment> fibres;  ///< from a file; none where they run between the attachments
  bool fibres_between_attachments = false;
  std::optional<double> density_kg_per_m3 = {};  ///< its own, in place of the loop's
  Vec3 velocity_m_per_s = Vec3::Zero();          ///< of its free nodes as the run begins
};

/// A backend that a scene names.
struct SceneBackend {
  std::string name;                                  ///< empty: the scene leaves the choice open
  std::map<std::string, ParameterValue> parameters;  ///< not checked yet: core knows no backend
  // File, line and key, for messages.
  std::string location;
  std::string parameters_location;
};

/// Two muscles that touch each other.
struct SceneMusclePair {
  MusclePair muscles;
  SceneBackend backend = {};
  std::optional<int> response_steps = {};  ///< nothing: those of `[contact]`
};

/// What a scene says of contact between one muscle and one bone; empty: left open.
struct SceneBoneContact {
  SceneBackend backend;
  std::optional<ResponseKind> response;
  std::string response_location = {};  ///< file, line and key, for messages
  std::optional<int> response_steps = {};
};

/// `NAME = false`: an effect of the preset that the scene does without, or one that the checker may not add.
struct EffectExclusion {
  std::string effect;
  bool is_of_preset = false;
};

/// An effect, or contact between two muscles, that the checker added to a scene.
struct AddedEffect {
  std::string effect;  ///< as the registry names it, or "muscle_contact a b"
  std::string rule;    ///< whose finding asked for it
  std::string reason;  ///< the finding's words, with its figures
};

/// `effects = "auto"`: a scene that leaves it to the checker which effects it has beside those that it names.
struct AutoEffects {
  bool wanted = false;
  bool keeps_out_muscle_contact = false;  ///< by `muscle_contact = false`
  std::vector<AddedEffect> added = {};
  std::string resolved_text = {};  ///< a scene file that names all of them, once they are added
};

/// Bound nodes of one muscle, numbered from its first: those on the bone of its first attachment, and all others.
struct EndNodes {
  std::vector<int> origin;
  std::vector<int> insertion;
};

/// A complete, checked description of what is simulated: all files read, all parameters known.
struct Scene {
  std::string name;
  std::string file;  ///< for messages
  std::string title;
  std::string preset;
  std::vector<Bone> bones;             ///< repaired, numbered coherently, rest pose
  std::vector<SceneMesh> bone_meshes;  ///< as shipped and placed, one a bone
  std::vector<BoneMotion> motions;     ///< one a bone
  std::vector<Muscle> muscles;
  TriangleMesh muscle_mesh;  ///< the welded surfaces of all muscles, one after the other: its vertices are the nodes
  std::vector<Attachment> attachments;
  /// Instead of attachments: every node that the backend finds in a bone before the first frame is bound to that bone,
  /// as in the paper. The boundary condition then depends on the backend.
  bool attach_at_first_contact = false;
  std::vector<SceneEffect> effects;  ///< only those the scene names, in the order of the registry
  std::vector<EffectExclusion> exclusions;
  AutoEffects auto_effects;
  LoopParameters loop;
  std::optional<ResponseKind> response;           ///< nothing: the backend's own
  int response_steps = default_projection_steps;  ///< of projecting, and of the corrections between muscles
  std::string response_steps_location = {};       ///< where the scene gives them, for messages
  std::vector<SceneMusclePair> muscle_pairs;      ///< ascending; none: muscles pass through each other
  std::vector<SceneBoneContact> bone_contacts;    ///< one a muscle and bone (bone_pair)
  int fibre_count = 0;                            ///< of each muscle, to be followed; 0: none
  bool fibres_are_required = true;                ///< false: where none can run, the run goes on without
  std::string fibres_refused = {};                ///< why it does; empty: it does not
  /// What is odd about it and its effects, noted where it was loaded to be run.
  std::vector<SceneWarning> warnings = {};
  /// What keeps the scene from being run, where its reader was told to go on all the same (SceneRequest).
  std::vector<std::string> obstacles;

  /// Of the motion, from 0 to 1, at `frame_position` (0 at rest, `loop.frames` at the end).
  [[nodiscard]] double progress_at(double frame_position) const;
  /// Poses at `frame_position` (0 at rest, `loop.frames` at the end).
  void poses_at(double frame_position, std::vector<RigidMotion>& poses) const;
  /// Largest flexion angle over the bones at `frame_position`, rad: what the frame is labelled with.
  [[nodiscard]] double angle_rad(double frame_position) const;
  /// Bound nodes of all attachments; a node that two areas claim belongs to the first.
  [[nodiscard]] std::vector<BoundNode> bound_nodes() const;
  /// Index of a muscle and a bone in tables that have an entry for each such pair: the first muscle with all bones,
  /// then the next.
  [[nodiscard]] std::size_t bone_pair(std::size_t muscle, std::size_t bone) const {
    return muscle * bones.size() + bone;
  }
  [[nodiscard]] std::size_t bone_pairs() const { return std::max<std::size_t>(muscles.size(), 1) * bones.size(); }
  /// The response of each muscle and bone, given its kind: one for all, or one a pair.
  [[nodiscard]] std::vector<BoneResponse> responses(const std::vector<ResponseKind>& kinds) const;
  /// Appends a muscle whose nodes are the vertices of `mesh`, in their order.
  Muscle& add_muscle(const std::string& name_of_muscle, const TriangleMesh& mesh);
  [[nodiscard]] std::vector<Body> bodies() const;
  /// By muscle: its fibres, given the nodes that are bound. Those between attachments run from the bone of the muscle's
  /// first attachment to the others.
  [[nodiscard]] std::vector<std::vector<FibreSegment>> fibres_with(const std::vector<BoundNode>& bound) const;
  [[nodiscard]] EndNodes end_nodes(std::size_t muscle, const std::vector<BoundNode>& bound) const;
  [[nodiscard]] std::vector<Vec3> vertices_of(const Body& body) const;
  /// The surface of one muscle, its nodes numbered from 0.
  [[nodiscard]] TriangleMesh mesh_of(const Body& body) const;
  /// The names of all muscles.
  [[nodiscard]] std::string muscle_names() const;
};

bool has_effect(const Scene& scene, std::string_view name);

/// The parameters of the `[loop]` table.
std::vector<ParameterSpec> loop_parameters();
LoopParameters loop_from(const Parameters& parameters);
/// The values of all of them.
std::map<std::string, ParameterValue> loop_values(const LoopParameters& loop);

}  // namespace musclebench

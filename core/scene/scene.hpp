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
#include "core/fibres/end_nodes.hpp"
#include "core/fibres/fibre_segments.hpp"
#include "core/mesh/bound_node.hpp"
#include "core/mesh/retinaculum.hpp"
#include "core/pbd/simulation.hpp"
#include "core/scene/attachment_area.hpp"
#include "core/scene/bone_motion.hpp"
#include "core/scene/mesh_placement.hpp"
#include "core/scene/scene_warning.hpp"
#include "core/scene/wanted.hpp"

namespace musclebench {

/// An attachment of a muscle to a bone: the nodes that move with the bone.
struct Attachment {
  std::string name;
  int bone = 0;            ///< index in `Scene::bones`
  std::size_t muscle = 0;  ///< index in `Scene::muscles`
  AttachmentArea area;
  std::vector<int> nodes;     ///< attached nodes, ascending
  bool is_origin = false;     ///< the scene says so, see `Scene::end_nodes`
  std::string location = {};  ///< file and line, for messages
};

/// An effect of a scene with its parameters.
struct SceneEffect {
  std::string name;
  Parameters parameters;
  std::string location = {};               ///< file (or preset) and line, for messages
  std::vector<std::string> own_keys = {};  ///< parameters that the scene sets itself, not its preset
  bool is_own = false;                     ///< the scene has a table for it
};

/// A mesh that a scene names, as it is after placement.
struct SceneMesh {
  std::string reference;      ///< the text in the scene
  std::string sha256;         ///< hash of the coordinates and indices, as read
  TriangleMesh mesh;          ///< in metres, at the place that the scene gives it; not repaired. Of a muscle: split
  std::string location = {};  ///< file and line of its table, for messages
  bool has_unit = false;      ///< the scene gives its unit or scale
  MeshPlacement placement = {};
};

/// How often each triangle of the meshes is split in four: `[meshes]`.
struct MeshSplits {
  int split_muscles = 0;  ///< on the triangles (split_flat)
  int smooth_bones = 0;   ///< on a curved surface through the vertices (split_curved)
};

/// A muscle of a scene: its file, and its nodes and triangles in the mesh of all muscles.
struct Muscle {
  Body body;  ///< its name, nodes and triangles in `Scene::muscle_mesh`
  SceneMesh file;
  std::vector<int> node_of_vertex;               ///< node of each vertex of the file; -1 if no triangle uses the vertex
  std::vector<std::string> changes;              ///< what welding changed, one line each
  std::vector<FibreSegment> fibres;              ///< fibres from a file; empty otherwise
  bool fibres_between_attachments = false;       ///< fibres run between the attachments
  std::optional<double> density_kg_per_m3 = {};  ///< replaces that of the loop
  Vec3 velocity_m_per_s = Vec3::Zero();          ///< initial velocity of its free nodes
};

/// A backend that a scene names, with its parameters.
struct SceneBackend {
  std::string name;                                  ///< empty: the scene does not choose
  std::map<std::string, ParameterValue> parameters;  ///< not checked: core does not know the backends
  // File, line and key, for messages.
  std::string location;
  std::string parameters_location;
};

/// The settings of contact between two muscles.
struct SceneMusclePair {
  MusclePair muscles;
  SceneBackend backend = {};
  std::optional<int> response_steps = {};  ///< none: the value of `[contact]`
};

/// The settings of contact between one muscle and one bone. Empty members use the defaults of the scene.
struct SceneBoneContact {
  SceneBackend backend;
  std::optional<ResponseKind> response;
  std::string response_location = {};  ///< file, line and key, for messages
  std::optional<int> response_steps = {};
};

/// A line `NAME = false`: the scene removes an effect of its preset, or forbids the checker to add it.
struct EffectExclusion {
  std::string effect;
  bool is_of_preset = false;  ///< the preset has the effect
};

/// An effect, or contact between two muscles, that the checker or a search added to a scene.
struct AddedEffect {
  std::string effect;  ///< name in the registry, or "muscle_contact a b"
  std::string rule;    ///< the rule that asked for it, or "trial"
  std::string reason;  ///< text of the finding, or what runs showed, with figures
};

/// The setting `effects = "auto"`: the checker adds effects to those that the scene names or, where the scene says what
/// it wants, a search by trial runs does.
struct AutoEffects {
  bool wanted = false;
  bool keeps_out_muscle_contact = false;  ///< the scene says `muscle_contact = false`
  std::vector<AddedEffect> added = {};
  std::string resolved_text = {};  ///< a scene file that names all effects, after they were added
};

/// Where the shapes of a scene come from: `[source]`. What is unknown is empty.
struct SceneSource {
  std::string licence;
  std::vector<std::string> citations = {};
  std::string url = {};
  bool is_non_commercial = false;
};

/// A complete and checked description of a simulation. All files have been read and all parameters are known. Lengths
/// are in metres. Const functions are safe from several threads.
struct Scene {
  std::string name;
  std::string file;  ///< for messages
  std::string title;
  SceneSource source = {};
  std::string preset;
  std::vector<Bone> bones;             ///< repaired and split surfaces in rest pose, in Morton order
  std::vector<SceneMesh> bone_meshes;  ///< the meshes of the bones as read, one for each bone
  std::vector<BoneMotion> motions;     ///< one for each bone
  std::vector<Muscle> muscles;
  TriangleMesh muscle_mesh;  ///< the welded surfaces of all muscles, one after the other; its vertices are the nodes
  std::vector<Attachment> attachments;
  /// Replaces attachments: every node that the backend finds in a bone before the first frame is attached to that bone,
  /// as in the paper. The boundary condition then depends on the backend.
  bool attach_at_first_contact = false;
  std::vector<Retinaculum> retinacula;  ///< that the effect of this name uses
  std::vector<SceneEffect> effects;     ///< the effects of the scene, in the order of the registry
  std::vector<EffectExclusion> exclusions;
  AutoEffects auto_effects;
  Wanted wanted;  ///< by a search for effects
  LoopParameters loop;
  MeshSplits mesh_splits;                         ///< that the meshes have already
  std::optional<ResponseKind> response;           ///< none: the default of the backend
  int response_steps = default_projection_steps;  ///< steps of `project`, and of corrections between muscles
  std::string response_steps_location = {};       ///< where the scene sets them, for messages
  std::vector<SceneMusclePair> muscle_pairs;      ///< ascending; empty: muscles pass through each other
  std::vector<SceneBoneContact> bone_contacts;    ///< one for each muscle and bone, by `bone_pair`
  int fibre_count = 0;                            ///< number of fibres to follow in each muscle; 0: none
  bool fibres_are_required = true;                ///< false: the scene may run without fibres
  std::string fibres_refused = {};                ///< why it runs without fibres; empty: it has them
  /// Warnings about the scene and its effects. Filled in when the scene is loaded for a run.
  std::vector<SceneWarning> warnings = {};
  /// What prevents a run of the scene. Filled in if `SceneRequest::notes_obstacles` is set.
  std::vector<std::string> obstacles;

  /// Progress of the motion, 0 to 1, at `frame_position` (0 at rest, `loop.frames` at the end).
  [[nodiscard]] double progress_at(double frame_position) const;
  /// Sets the poses of all bones at `frame_position` (0 at rest, `loop.frames` at the end).
  void poses_at(double frame_position, std::vector<RigidMotion>& poses) const;
  /// The largest flexion angle of all bones at `frame_position`, in radians. It labels the frame.
  [[nodiscard]] double angle_rad(double frame_position) const;
  /// The attached nodes of all attachments, ascending. A node in two areas belongs to the first attachment.
  [[nodiscard]] std::vector<BoundNode> bound_nodes() const;
  /// The index of a muscle and a bone in tables with an entry for each such pair. The first muscle comes with all
  /// bones, then the second muscle, and so on.
  [[nodiscard]] std::size_t bone_pair(std::size_t muscle, std::size_t bone) const {
    return muscle * bones.size() + bone;
  }
  /// The number of such entries. Without muscles it is the number of bones.
  [[nodiscard]] std::size_t bone_pairs() const { return std::max<std::size_t>(muscles.size(), 1) * bones.size(); }
  /// The responses, given their kinds: one for all, or one for each muscle and bone.
  [[nodiscard]] std::vector<BoneResponse> responses(const std::vector<ResponseKind>& kinds) const;
  /// Appends a muscle whose nodes are the vertices of `mesh`, in their order. The reference is valid until the next
  /// call.
  Muscle& add_muscle(const std::string& name_of_muscle, const TriangleMesh& mesh);
  /// The bodies of all muscles.
  [[nodiscard]] std::vector<Body> bodies() const;
  /// The fibres of each muscle, given the attached nodes. Fibres between attachments run from origins to insertions.
  [[nodiscard]] std::vector<std::vector<FibreSegment>> fibres_with(const std::vector<BoundNode>& bound) const;
  /// The attached nodes at the two ends of a muscle. Origins are on the bones of attachments that the scene calls so;
  /// where it calls none so, on the bone of the first one.
  [[nodiscard]] EndNodes end_nodes(std::size_t muscle, const std::vector<BoundNode>& bound) const;
  /// The vertices of one muscle at rest.
  [[nodiscard]] std::vector<Vec3> vertices_of(const Body& body) const;
  /// The surface of one muscle at rest, with its nodes numbered from 0.
  [[nodiscard]] TriangleMesh mesh_of(const Body& body) const;
  /// The names of all muscles in one string.
  [[nodiscard]] std::string muscle_names() const;
};

/// Whether the scene has the effect `name`.
bool has_effect(const Scene& scene, std::string_view name);

/// The parameters of the `[meshes]` table.
std::vector<ParameterSpec> mesh_parameters();
/// Their values, by name.
std::map<std::string, ParameterValue> mesh_values(const MeshSplits& splits);

/// The parameters of the `[loop]` table.
std::vector<ParameterSpec> loop_parameters();
/// The loop settings with these values. `parameters` must be made from `loop_parameters`.
LoopParameters loop_from(const Parameters& parameters);
/// The values of all parameters of `[loop]`, by name. The inverse of `loop_from`.
std::map<std::string, ParameterValue> loop_values(const LoopParameters& loop);

}  // namespace musclebench

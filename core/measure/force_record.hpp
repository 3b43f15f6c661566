#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/column.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What a muscle's force comes from.
enum class ForceSource {
  bone,         ///< contact with a bone
  muscle,       ///< contact with another muscle
  itself,       ///< contact of the muscle with itself
  unknown,      ///< contact that moved nodes without telling with what
  attachment,   ///< a bone that carries nodes of the muscle
  retinaculum,  ///< a ring that holds a tendon of the muscle
  joint,        ///< all that muscles do to a bone: their contacts, attachments and retinacula
};

/// A mean force over one frame: a row of forces.csv. World frame, N. It acts on the muscle; in a row of a joint, on the
/// bone.
struct ForceRow {
  int frame = 0;
  double angle_rad = 0;     ///< of the bone that turns
  std::string muscle = {};  ///< empty for a joint
  ForceSource source = ForceSource::bone;
  std::string other = {};  ///< the bone, muscle, attachment or retinaculum that exerts the force; a joint's bone
  std::string bone = {};   ///< that touches or carries the muscle; a joint's; empty elsewhere
  Vec3 force_n = Vec3::Zero();
  Vec3 at_m = Vec3::Zero();  ///< the mean of its nodes, each by the size of its force; a point of a joint's axis
  // Of contact.
  std::optional<double> normal_n = {};          ///< sum over nodes of the sizes of their pushes along normals
  std::optional<double> friction_n = {};        ///< size of the sum of all friction
  std::optional<double> area_m2 = {};           ///< that faces the pushes: a third of the triangles about each node
  std::optional<double> peak_pressure_pa = {};  ///< largest push of a node over its area
  // Of an attachment.
  std::optional<double> fibres_n = {};  ///< of its muscle: the mean force along all fibres; nothing: no fibres pull
  std::optional<double> active_n = {};  ///< size of what `activation` or `fibre_force` pulls there
  /// The part of all other effects along the active part; < 0: against it. Its size where there is no active part.
  std::optional<double> passive_n = {};
  /// What the force does to the bone, about the axis of its first rotation that turns; nothing: the bone stands still.
  std::optional<double> torque_n_m = {};
};

/// What muscles do to one vertex of a bone: a row of a snapshot's table. World frame.
struct BoneVertexRow {
  std::string bone;
  int vertex = 0;  ///< of the bone's file in the run's folder
  double pressure_pa = 0;
  Vec3 force_n = Vec3::Zero();  ///< on the bone, without friction
};

/// The name of a source in forces.csv.
std::string_view name_of(ForceSource source);

/// The columns of a run's forces.csv.
std::span<const Column<ForceRow>> force_columns();
/// The columns of a snapshot's table of bones.
std::span<const Column<BoneVertexRow>> bone_vertex_columns();

}  // namespace musclebench

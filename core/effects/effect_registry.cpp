#include "core/effects/effect_registry.hpp"

#include "core/effects/activation.hpp"
#include "core/effects/attachment.hpp"
#include "core/effects/bending.hpp"
#include "core/effects/damping.hpp"
#include "core/effects/edge_length.hpp"
#include "core/effects/fibre_force.hpp"
#include "core/effects/friction.hpp"
#include "core/effects/gravity.hpp"
#include "core/effects/local_volume.hpp"
#include "core/effects/margin.hpp"
#include "core/effects/multi_bone.hpp"
#include "core/effects/no_passage/no_passage.hpp"
#include "core/effects/retinaculum.hpp"
#include "core/effects/self_contact.hpp"
#include "core/effects/surface_contact.hpp"
#include "core/effects/tunnelling_guard.hpp"
#include "core/effects/volume.hpp"

namespace musclebench {

namespace {

/// Of soft tissue: derived in the preset `standard`.
std::map<std::string, ParameterValue> tissue_bending() { return {{"stiffness", 1.0}, {"compliance_rad_per_n_m", 1e4}}; }

}  // namespace

const std::vector<EffectEntry>& effect_registry() {
  static const std::vector<EffectEntry> entries = {
      // Before gravity, or a body at rest would weigh less by what is damped of a substep's fall.
      {"damping", "velocities decay", damping_parameters(), make_damping},
      {"gravity", "constant acceleration of all free nodes", gravity_parameters(), make_gravity},
      {"attachment", "bound nodes move with their bone", attachment_parameters(), make_attachment},
      {.name = "edge_length",
       .help = "edges keep their rest length, softer along the fibres",
       .parameters = edge_length_parameters(),
       .make = make_edge_length,
       .remedies = {{Requirement::whole_surface}}},
      {"activation", "fibres shorten by a course over time", activation_parameters(), make_activation},
      {.name = "fibre_force",
       .help = "fibres pull: active, passive and by speed (Hill), and push never",
       .parameters = fibre_force_parameters(),
       .make = make_fibre_force,
       .remedies = {{Requirement::taut_fibres, {{"level", 0.05}}}}},  // as reports/moment_arms.md measures with
      {.name = "volume",
       .help = "the closed surface keeps its volume",
       .parameters = volume_parameters(),
       .make = make_volume,
       .remedies = {{Requirement::volume}}},
      {.name = "local_volume",
       .help = "each of several regions along the muscle keeps its volume",
       .parameters = local_volume_parameters(),
       .make = make_local_volume,
       .remedies = {{Requirement::volume}}},
      {.name = "bending",
       .help = "neighbouring triangles keep their dihedral angle (local shape)",
       .parameters = bending_parameters(),
       .make = make_bending,
       .remedies = {{Requirement::self_passage, tissue_bending()}, {Requirement::returned_shape, tissue_bending()}}},
      {"retinaculum", "rings that bones carry hold tendons, which slide through them", retinaculum_parameters(),
       make_retinaculum},
      {.name = "margin",
       .help = "a skin on the bones; nodes stay out of it, and faces with `surface_contact`",
       .parameters = margin_parameters(),
       .make = nullptr,
       .make_stage = make_margin,
       .set_contacts = set_margin,
       .needs_normals = true,
       .needs_projection = true},
      {.name = "multi_bone",
       .help = "nodes in several bones take one short displacement out of all bones; without this effect the pushes of "
               "the bones add up",
       .parameters = multi_bone_parameters(),
       .make = nullptr,
       .set_response = set_multi_bone,
       .needs_normals = true,
       .needs_projection = true,
       .remedies = {{Requirement::bone_depth}}},
      {.name = "friction",
       .help = "Coulomb friction: what touches a bone, a muscle or itself slides only as far as the push allows",
       .parameters = friction_parameters(),
       .make = nullptr,
       .make_stage = make_friction,
       .set_contacts = set_friction,
       .needs_normals = true},
      {.name = "self_contact",
       .help = "a muscle does not fold through itself",
       .parameters = self_contact_parameters(),
       .make = nullptr,
       .make_stage = make_self_contact,
       .remedies = {{Requirement::self_passage}}},
      {.name = "surface_contact",
       .help = "faces and edges of a muscle stay out of bones, not only its nodes",
       .parameters = surface_contact_parameters(),
       .make = nullptr,
       .make_stage = make_surface_contact,
       .remedies = {{Requirement::bone_depth}, {Requirement::bone_passage}}},
      {.name = "tunnelling_guard",
       .help = "no node ends a step on the far side of a bone",
       .parameters = tunnelling_guard_parameters(),
       .make = nullptr,
       .make_stage = make_tunnelling_guard,
       .remedies = {{Requirement::bone_passage}, {Requirement::bone_depth}}},
      {.name = "no_passage",
       .help = "no node, edge or face passes through a bone, another muscle or its own muscle",
       .parameters = no_passage_parameters(),
       .make = nullptr,
       .make_stage = make_no_passage,
       .remedies = {{Requirement::bone_passage},
                    {Requirement::muscle_passage},
                    {Requirement::self_passage},
                    {Requirement::bone_depth},
                    {Requirement::muscle_depth}}},
  };
  return entries;
}

const EffectEntry* find_effect(std::string_view name) {
  for (const EffectEntry& entry : effect_registry()) {
    if (entry.name == name) {
      return &entry;
    }
  }
  return nullptr;
}

}  // namespace musclebench

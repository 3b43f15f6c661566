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
#include "core/effects/self_contact.hpp"
#include "core/effects/surface_contact.hpp"
#include "core/effects/tunnelling_guard.hpp"
#include "core/effects/volume.hpp"

namespace musclebench {

const std::vector<EffectEntry>& effect_registry() {
  static const std::vector<EffectEntry> entries = {
      // Before gravity, or a body at rest would weigh less by what is damped of a substep's fall.
      {"damping", "velocities decay", damping_parameters(), make_damping},
      {"gravity", "constant acceleration of all free nodes", gravity_parameters(), make_gravity},
      {"attachment", "bound nodes move with their bone", attachment_parameters(), make_attachment},
      {"edge_length", "edges keep their rest length, softer along the fibres", edge_length_parameters(),
       make_edge_length},
      {"activation", "fibres shorten by a course over time", activation_parameters(), make_activation},
      {"fibre_force", "fibres pull: active, passive and by speed (Hill), and push never", fibre_force_parameters(),
       make_fibre_force},
      {"volume", "the closed surface keeps its volume", volume_parameters(), make_volume},
      {"local_volume", "each of several regions along the muscle keeps its volume", local_volume_parameters(),
       make_local_volume},
      {"bending", "neighbouring triangles keep their dihedral angle (local shape)", bending_parameters(), make_bending},
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
       .needs_projection = true},
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
       .make_stage = make_self_contact},
      {.name = "surface_contact",
       .help = "faces and edges of a muscle stay out of bones, not only its nodes",
       .parameters = surface_contact_parameters(),
       .make = nullptr,
       .make_stage = make_surface_contact},
      {.name = "tunnelling_guard",
       .help = "no node ends a step on the far side of a bone",
       .parameters = tunnelling_guard_parameters(),
       .make = nullptr,
       .make_stage = make_tunnelling_guard},
      {.name = "no_passage",
       .help = "no node, edge or face passes through a bone, another muscle or its own muscle",
       .parameters = no_passage_parameters(),
       .make = nullptr,
       .make_stage = make_no_passage},
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

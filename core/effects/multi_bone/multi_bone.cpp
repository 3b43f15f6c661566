#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

void set_multi_bone(Response& response, const Parameters& parameters) {
  response.project_out_of_all(static_cast<int>(parameters.integer("steps")));
}

std::vector<ParameterSpec> multi_bone_parameters() {
  return {
      parameter::integer({.name = "steps",
                          .default_value = 8,
                          .minimum = 1,
                          .maximum = 1000,
                          .help = "detections of one response, at most: a node between curved bones needs several"})};
}

}  // namespace

/// Nodes in contact with several bones (paper, section IV-C and Fig. 4). Without this effect the pushes of the bones
/// are added, as in the paper: twice as far as needed where bones overlap, and into another bone in a narrow wedge.
/// With it each goes to the closest position outside the tangent planes that detections of the step have met
/// (`least_displacement`), the same for any order of bones. Its time is a part of the response's.
EffectEntry multi_bone_entry() {
  return {.name = "multi_bone",
          .help =
              "nodes in several bones take one short displacement out of all bones; without this effect the pushes of "
              "the bones add up",
          .parameters = multi_bone_parameters(),
          .set_response = set_multi_bone,
          .needs_normals = true,
          .needs_projection = true,
          .remedies = {{Requirement::bone_depth}}};
}

}  // namespace musclebench

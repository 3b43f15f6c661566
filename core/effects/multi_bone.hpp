#pragma once

#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Nodes in contact with several bones (paper, section IV-C and Fig. 4). Without this effect the pushes of the bones
/// are added, as in the paper: twice as far as needed where bones overlap, and into another bone in a narrow wedge.
/// With it each goes to the closest position outside the tangent planes that detections of the step have met
/// (`least_displacement`), the same for any order of bones. Its time is a part of the response's.
void set_multi_bone(Response& response, const Parameters& parameters);
std::vector<ParameterSpec> multi_bone_parameters();

}  // namespace musclebench

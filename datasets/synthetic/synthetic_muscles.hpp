#pragma once

#include <string_view>

#include "datasets/synthetic/synthetic_field.hpp"

namespace musclebench {

/// A muscle: bundles of fibres from origin to insertion, without what would come nearer to a bone than a small
/// clearance, so that it lies flat against the bones.
struct MuscleShape {
  Field field;
  Vec3 lower_m;  ///< a box around it
  Vec3 upper_m;
  int vertices = 0;
};

/// `name` is one of adductor_brevis, gluteus_maximus, gluteus_medius, iliacus (asserted).
MuscleShape muscle_shape(std::string_view name);

}  // namespace musclebench

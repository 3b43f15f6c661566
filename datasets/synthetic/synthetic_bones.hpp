#pragma once

#include "datasets/synthetic/synthetic_field.hpp"

namespace musclebench {

/// The right hip bone with half a sacrum; the hip centre is the origin, x points to the left, y backwards, z up.
/// Proportions are those of an adult; every shape is made of analytic parts.
Field hip_bone_field();

/// The right femur in the same frame, upright: head (radius 23.5 mm), neck, trochanters, shaft, condyles.
Field femur_field();

constexpr double femoral_head_radius_m = 0.0235;
constexpr double socket_radius_m = 0.0255;

}  // namespace musclebench

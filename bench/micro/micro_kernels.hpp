#pragma once

#include "core/scene/scene.hpp"

namespace musclebench {

// Each registers the kernels of one file. They load the scene where their names depend on it.

/// `bvh_locate/near|far/BONE`: one query at a point, cold.
void register_query_kernels();

/// `update/BACKEND`, `detect/BACKEND` and `detect_threads/BACKEND/N`: all nodes of the muscle, pushed into the bones.
void register_detect_kernels();

/// `constraints/EFFECT/lanes|scalar|published`: one pass over an effect's constraints.
void register_constraint_kernels();

/// `loop/PRESET/BACKEND/scalar|1|2`: a frame of the loop, with the number of threads, or over scalar effects.
void register_loop_kernels();

/// `muscle_size/BACKEND/NODES`, `bone_size/bvh_locate|bvh_step/TRIANGLES`.
void register_size_kernels();

/// `allocations/BACKEND/RESPONSE`: how often a frame after the second asks for heap memory.
void register_allocation_kernels();

/// `effects/sum_of_parts`: what each effect adds to a frame without any, in ms, their sum, and what all add together.
void register_effect_kernels();

/// What backends have in their folders `micro`: a table that CMake writes. `scene` outlives the kernels.
void register_backend_kernels(const Scene& scene);

}  // namespace musclebench

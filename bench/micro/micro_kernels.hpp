#pragma once

namespace musclebench {

/// Along the longest side of a bone's box, of the grids whose building and queries are timed.
inline constexpr int field_cells = 64;

// Each registers the kernels of one file. They load the scene where their names depend on it.

/// `voxel_test/BONE`, `sdf_value_and_gradient/PRECISION/BONE`, `octree_value_and_gradient/BONE`,
/// `bvh_locate/near|far/BONE`: one query at a point, cold.
void register_query_kernels();

/// `sdf_build_a_node/BONE`, `sdf_build_threads/BONE/N`, `sdf_bytes/dense|band_10mm/PRECISION/BONE`.
void register_build_kernels();

/// `adaptive_over_uniform/BONE`: bytes and build time of the adaptive field of 0.05 mm over those of the uniform grid
/// that errs as much.
void register_equal_error_kernels();

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

}  // namespace musclebench

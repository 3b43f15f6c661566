#pragma once

#include "core/scene/scene.hpp"

namespace musclebench {

// Each registers the kernels of one file. `scene` outlives them.

/// `sdf_value_and_gradient/BONE`, `octree_value_and_gradient/BONE`: one query at a point, cold.
void register_field_query_kernels(const Scene& scene);

/// `sdf_build_a_node/BONE`, `sdf_build_threads/BONE/N`, `sdf_bytes/BONE`.
void register_field_build_kernels(const Scene& scene);

/// `adaptive_over_uniform/BONE`: bytes and build time of the adaptive field of 0.05 mm over those of the uniform grid
/// that errs as much.
void register_equal_error_kernels(const Scene& scene);

}  // namespace musclebench

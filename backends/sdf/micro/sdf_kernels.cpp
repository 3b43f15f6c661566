#include "backends/sdf/micro/field_kernels.hpp"

namespace musclebench {

void register_sdf_kernels(const Scene& scene) {
  register_field_query_kernels(scene);
  register_field_build_kernels(scene);
  register_equal_error_kernels(scene);
}

}  // namespace musclebench

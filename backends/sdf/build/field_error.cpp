#include "backends/sdf/build/field_builder.hpp"

namespace musclebench {

FieldError estimate_error(const CubicField& field, const SignedSurface& surface, int samples, std::uint64_t seed) {
  const GridShape& shape = field.shape();
  return estimate_error(surface,
                        {.box = {shape.lower_m, shape.upper_m()},
                         .reach_m = 2 * shape.cell_size_m.norm(),
                         .count = samples,
                         .seed = seed},
                        [&](const Vec3& point) { return field.value(point); });
}

}  // namespace musclebench

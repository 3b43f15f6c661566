#include "backends/sdf/field_queries.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/field_contact.hpp"
#include "backends/sdf/grid/cubic_field.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

class FieldQueries final : public SurfaceQueries {
 public:
  explicit FieldQueries(CubicField field) : m_field(std::move(field)) {}

  [[nodiscard]] SurfaceAnswer locate(const Vec3& point, int near) const override {
    const GridShape& grid = m_field.shape();
    const Vec3 within = point.cwiseMax(grid.lower_m).cwiseMin(grid.upper_m());
    const FieldSample sample = m_field.sample(within).value_or(FieldSample{});
    const Vec3 gradient = outward(sample.gradient, within - 0.5 * (grid.lower_m + grid.upper_m()));
    const Vec3 beyond = point - within;
    if (beyond.squaredNorm() > 0) {
      // The bone is on the other side of the border, so that the two ways make at least a right angle.
      const Vec3 away = beyond + sample.value_m * gradient;
      return {std::hypot(beyond.norm(), sample.value_m), away.normalized(), point - away, near};
    }
    return {sample.value_m, gradient, within - sample.value_m * gradient, near};
  }

  [[nodiscard]] Clearance clearance(const Vec3& point, int near) const override {
    const GridShape& grid = m_field.shape();
    const Vec3 within = point.cwiseMax(grid.lower_m).cwiseMin(grid.upper_m());
    const double beyond_m = (point - within).norm();
    if (beyond_m > 0) return {beyond_m, near};
    const double distance_m = std::abs(m_field.value(within).value_or(0));
    // By the steepest slope of the field; farther away by the declared error, once of this value and once of the
    // field's zero.
    const double cell_m = grid.cell_size_m.norm();
    return {std::max(distance_m / m_field.facts().lipschitz_bound, distance_m - cell_m), near};
  }

 private:
  CubicField m_field;
};

}  // namespace

MakeSurfaceQueries make_field_queries(const Parameters& parameters) {
  const bool has_cells_everywhere = !wants_octree(parameters) && !field_settings(parameters).band_m;
  if (!has_cells_everywhere || !parameters.word("discregrid").empty()) {
    throw InputError("sdf",
                     "faces need a field that is built here, with cells of one size everywhere; leave out band_m, "
                     "max_error_mm and discregrid");
  }
  return [grid = grid_settings(parameters), settings = field_settings(parameters)](const Bone& bone, int threads) {
    const GridShape shape = grid_over(bone.surface.mesh, grid, bone.name);
    return std::make_shared<const FieldQueries>(build_field(bone.signed_distance(), shape, settings, threads, nullptr));
  };
}

}  // namespace musclebench

#include "backends/sdf/field_queries.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/build/field_memory.hpp"
#include "backends/sdf/field_contact.hpp"
#include "backends/sdf/grid/cubic_field.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

class FieldQueries final : public SurfaceQueries {
 public:
  explicit FieldQueries(CubicField field) : m_field(std::move(field)) {
    // A hair inside: on the border itself rounding may take a point out of the domain.
    const GridShape& grid = m_field.shape();
    const Vec3 hair = Vec3::Constant(1e-12 * (grid.upper_m() - grid.lower_m).norm() +
                                     1e-15 * grid.lower_m.cwiseAbs().cwiseMax(grid.upper_m().cwiseAbs()).maxCoeff());
    m_lower_m = grid.lower_m + hair;
    m_upper_m = grid.upper_m() - hair;
  }

  [[nodiscard]] SurfaceAnswer locate(const Vec3& point, int near) const override {
    const GridShape& grid = m_field.shape();
    const Vec3 within = point.cwiseMax(m_lower_m).cwiseMin(m_upper_m);
    const FieldSample sample = m_field.sample(within).value_or(FieldSample{});
    const Vec3 gradient = outward(sample.gradient, within - 0.5 * (grid.lower_m + grid.upper_m()));
    const Vec3 beyond = point - within;
    if (beyond.squaredNorm() > 0) {
      // The bone is on the other side of the border, so that the two ways make at least a right angle. Where it is
      // thinner than a cell, the field may be negative at the border.
      const double value_m = std::max(sample.value_m, 0.0);
      const Vec3 away = beyond + value_m * gradient;
      const Vec3 direction = (away.squaredNorm() > 0 ? away : beyond).stableNormalized();
      return {std::hypot(beyond.norm(), value_m), direction, point - away, near};
    }
    return {sample.value_m, gradient, within - sample.value_m * gradient, near};
  }

  [[nodiscard]] Clearance clearance(const Vec3& point, int near) const override {
    const GridShape& grid = m_field.shape();
    const Vec3 within = point.cwiseMax(m_lower_m).cwiseMin(m_upper_m);
    const double beyond_m = (point - within).norm();
    if (beyond_m > 0) return {beyond_m, near};
    const double distance_m = std::abs(m_field.value(within).value_or(0));
    // By the steepest slope of the field; farther away by the declared error, once of this value and once of the
    // field's zero.
    const double cell_m = grid.cell_size_m.norm();
    return {std::max(distance_m / m_field.facts().lipschitz_bound, distance_m - cell_m), near};
  }

  [[nodiscard]] std::size_t bytes() const override { return sizeof(*this) + m_field.bytes(); }

 private:
  CubicField m_field;
  Vec3 m_lower_m;
  Vec3 m_upper_m;
};

}  // namespace

MakeSurfaceQueries make_field_queries(const Parameters& parameters, std::span<const Bone> bones) {
  if (wants_octree(parameters) || !parameters.word("discregrid").empty()) {
    throw InputError("sdf",
                     "faces need a field that is built here, with cells of one size; leave out max_error_mm and "
                     "discregrid");
  }
  const GridSettings grid = grid_settings(parameters);
  std::vector<GridShape> shapes;
  for (const Bone& bone : bones) shapes.push_back(grid_over(bone.surface.mesh, grid, bone.name));
  require_room(shapes, grid);
  return [grid](const Bone& bone, int threads) {
    const GridShape shape = grid_over(bone.surface.mesh, grid, bone.name);
    const auto surface = bone.kept_signed_distance();
    return std::make_shared<const FieldQueries>(build_field(*surface, shape, threads));
  };
}

}  // namespace musclebench

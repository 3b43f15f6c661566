#include "backends/sdf/build/field_builder.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "backends/sdf/build/cell_signs.hpp"
#include "backends/sdf/build/node_distances.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// Along one axis; what `cells` allows, too.
constexpr double most_cells = 4096;

/// Off-node samples of the error that is kept with a field.
constexpr int error_samples = 2000;

}  // namespace

GridShape grid_over(const TriangleMesh& mesh, const GridSettings& settings, const std::string& bone_name) {
  const Eigen::AlignedBox3d box = bounding_box(mesh.vertices);
  const Vec3 size = box.sizes();
  const double grown = settings.margin * size.norm();
  GridShape shape;
  if (settings.cell_size_m <= 0) {
    shape.cells.fill(settings.cells);
    shape.lower_m = box.min() - Vec3::Constant(grown);
    shape.cell_size_m = (size + Vec3::Constant(2 * grown)) / settings.cells;
    return shape;
  }
  const Vec3 wanted = ((size + Vec3::Constant(2 * grown)) / settings.cell_size_m).array().ceil().cwiseMax(1.0);
  const double longest = size.maxCoeff();
  const bool too_large = settings.cell_size_m > longest;
  if (too_large || wanted.maxCoeff() > most_cells) {
    throw InputError(
        fmt::format("sdf: cell_size_m ({})", bone_name),
        fmt::format("{} {}; {:.2g} to {:.2g} makes sense", settings.cell_size_m,
                    too_large ? fmt::format("is more than the whole bone, {:.3g} m", longest)
                              : fmt::format("gives {:.3g} cells along the bone of {:.3g} m, more than {:.0f}",
                                            wanted.maxCoeff(), longest, most_cells),
                    longest / 256, longest / 16));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    shape.cells[axis] = static_cast<std::int32_t>(wanted[static_cast<Eigen::Index>(axis)]);
  }
  shape.cell_size_m.setConstant(settings.cell_size_m);
  shape.lower_m = box.center() - 0.5 * settings.cell_size_m * wanted;
  return shape;
}

CubicField build_field(const SignedSurface& surface, const GridShape& shape, int threads,
                       const std::function<void(double)>& progress) {
  CubicField field(shape);
  fill_distances(surface, field, threads, progress);
  find_cell_signs(field, threads);
  field.facts().error = estimate_error(field, surface, error_samples);
  return field;
}

}  // namespace musclebench

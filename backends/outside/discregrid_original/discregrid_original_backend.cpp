#include <Discregrid/cubic_lagrange_discrete_grid.hpp>
#include <Discregrid/geometry/TriangleMeshDistance.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include <fmt/format.h>
#include <omp.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/files/discregrid_file.hpp"
#include "core/base/system_memory.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

namespace {

/// Discregrid takes as many threads as OpenMP would.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads) : m_before(omp_get_max_threads()) { omp_set_num_threads(threads); }
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  ~ThreadLimit() { omp_set_num_threads(m_before); }

 private:
  int m_before;
};

Discregrid::CubicLagrangeDiscreteGrid empty_grid(const GridShape& shape) {
  std::array<unsigned, 3> cells{};
  std::copy(shape.cells.begin(), shape.cells.end(), cells.begin());
  return {Eigen::AlignedBox3d(shape.lower_m, shape.upper_m()), cells};
}

/// A field of a bone that Discregrid builds, from its own distances, and evaluates.
class DiscregridOriginalBone {
 public:
  DiscregridOriginalBone(const Bone& bone, const GridSettings& settings, int threads)
      : m_shape(grid_over(bone.surface.mesh, settings, bone.name)), m_grid(empty_grid(m_shape)) {
    const SignedSurface& exact = bone.signed_distance();
    {
      const ThreadLimit limit(threads);
      m_has_right_sides = fill(bone.surface, exact);
    }
    // Discregrid tells neither slopes nor errors. This project's reader of its files does.
    const TemporaryFolder folder;
    m_grid.save((folder / "field.cdf").string());
    const CubicField field = read_discregrid(folder / "field.cdf", threads);
    // The reader rounds values to single precision, which changes a slope by less than this.
    const double rounding =
        64 * std::numeric_limits<float>::epsilon() * m_grid.domain().diagonal().norm() / m_shape.cell_size_m.minCoeff();
    m_lipschitz_bound = field.facts().lipschitz_bound + rounding;
    m_half_cell_m = 0.5 * m_shape.cell_size_m.norm();
    const FieldError error = estimate_error(field, exact, error_samples);
    m_error = {"", bytes(), error.samples, error.largest_m, error.p99_m};
  }

  /// As of `sdf`, where all values have the right sign.
  [[nodiscard]] AnswerBound answer_bound() const {
    const double side_m = m_has_right_sides ? m_half_cell_m : std::numeric_limits<double>::infinity();
    return {side_m, side_m, 1e-6 * m_half_cell_m};
  }
  /// By the sizes of what Discregrid keeps: values of all nodes, 32 indices a cell, and the map of cells.
  [[nodiscard]] std::size_t bytes() const {
    const auto& [x, y, z] = m_grid.resolution();
    const std::size_t edges =
        std::size_t{x} * (y + 1) * (z + 1) + std::size_t{y} * (x + 1) * (z + 1) + std::size_t{z} * (x + 1) * (y + 1);
    const std::size_t nodes = std::size_t{x + 1} * (y + 1) * (z + 1) + 2 * edges;
    return sizeof(*this) + nodes * sizeof(double) + m_grid.nCells() * 33 * sizeof(unsigned);
  }
  [[nodiscard]] std::optional<StructureError> error() const { return m_error; }
  [[nodiscard]] const DiscregridOriginalBone& session() const { return *this; }

  [[nodiscard]] LocatedPoint locate(const Vec3& point, int& /*near*/) const {
    const Eigen::AlignedBox3d& domain = m_grid.domain();
    if (!domain.contains(point)) return {.clearance_m = domain.exteriorDistance(point)};
    Vec3 slope = Vec3::Zero();
    const double value_m = m_grid.interpolate(0, point, &slope);
    if (value_m >= 0) return {.clearance_m = value_m / m_lipschitz_bound};
    const Vec3 out = slope.norm() > 1e-9 ? slope.normalized() : (point - domain.center()).stableNormalized();
    return {.inside = true, .depth_m = -value_m, .outward = out.isZero() ? Vec3::UnitX() : out};
  }

 private:
  static constexpr int error_samples = 2000;  ///< as of `sdf`

  /// Whether all values have the right sign. Discregrid's normals give the wrong one next to some vertices, and
  /// anywhere about a surface that is not clean; elsewhere it need not be compared.
  bool fill(const RepairedMesh& surface, const SignedSurface& exact) {
    const Discregrid::TriangleMeshDistance distance(surface.mesh.vertices, surface.mesh.triangles);
    std::atomic<bool> right = true;
    m_grid.addFunction([&](const Vec3& node) {
      using Discregrid::NearestEntity;
      const Discregrid::Result found = distance.signed_distance(node);
      const bool at_vertex = found.nearest_entity == NearestEntity::V0 || found.nearest_entity == NearestEntity::V1 ||
                             found.nearest_entity == NearestEntity::V2;
      if ((at_vertex || !surface.clean) && right &&
          exact.locate_from(node, found.triangle_id).inside != (found.distance < 0)) {
        right = false;
      }
      return found.distance;
    });
    return right;
  }

  GridShape m_shape;
  Discregrid::CubicLagrangeDiscreteGrid m_grid;
  bool m_has_right_sides = false;
  double m_lipschitz_bound = 1;
  double m_half_cell_m = 0;
  StructureError m_error;
};

/// Of all cells of these bones: seven values a cell and 32 indices, in the field and as its file is read.
void require_room(std::size_t bones, std::int64_t cells) {
  constexpr double bytes_a_cell = 3 * (7 * sizeof(double) + 33 * sizeof(unsigned));
  const double bytes = bytes_a_cell * static_cast<double>(bones) * std::pow(static_cast<double>(cells), 3);
  const double share = std::cbrt(static_cast<double>(available_memory_bytes()) / bytes);
  require_memory(static_cast<std::size_t>(bytes), "discregrid_original: cells",
                 fmt::format("{:.0f} cells fit", std::max(1.0, std::floor(0.95 * static_cast<double>(cells) * share))));
}

std::unique_ptr<CollisionBackend> make_discregrid_original_backend(const Parameters& parameters) {
  const GridSettings settings{.cells = static_cast<int>(parameters.integer("cells"))};
  return make_point_backend(
      {.capabilities = {.has_cache = uses_clearance_cache(parameters), .steady_memory = true},
       .require_fit = [settings](std::span<const Bone> bones) { require_room(bones.size(), settings.cells); },
       .contact_reach_m =
           [settings](const Bone& bone) {
             const GridShape shape = grid_over(bone.surface.mesh, settings, bone.name);
             const Eigen::AlignedBox3d box = bounding_box(bone.surface.mesh.vertices);
             return (box.min() - shape.lower_m).cwiseMax(shape.upper_m() - box.max()).norm();
           },
       .build = build_located(parameters, [settings](const Bone& bone, int threads, const ShareReport& /*report*/) {
         return std::make_unique<const DiscregridOriginalBone>(bone, settings, threads);
       })});
}

}  // namespace

// How it is driven follows the usage in Discregrid's README and its program GenerateSDF. The method: Koschier, Deul and
// Bender 2016; Koschier and others 2017.
BackendEntry discregrid_original_entry() {
  return {.name = "discregrid_original",
          .help = "a cubic field of each bone that Discregrid itself builds and evaluates",
          .implementation = "Discregrid, MIT",
          .default_response = ResponseKind::project,
          .parameters = {parameter::integer({.name = "cells",
                                             .default_value = 64,
                                             .minimum = 1,
                                             .maximum = 256,
                                             .role = ParameterRole::resolution,
                                             .help = "cells along each axis of the bone's bounding box"}),
                         cull_parameter(), clearance_cache_parameter()},
          .make = make_discregrid_original_backend};
}

}  // namespace musclebench

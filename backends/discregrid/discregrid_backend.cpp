#include <BulletCollision/CollisionShapes/btMiniSDF.h>
#include <LinearMath/btScalar.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/files/discregrid_file.hpp"
#include "core/base/input_error.hpp"
#include "core/base/system_memory.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

namespace {

/// A field of a bone as Discregrid stores it, and Discregrid's evaluation of it.
class DiscregridBone {
 public:
  DiscregridBone(const Bone& bone, const GridSettings& settings, int threads, const ShareReport& report) {
    const GridShape shape = grid_over(bone.surface.mesh, settings, bone.name);
    const CubicField field = build_field(bone.signed_distance(), shape, threads, report);
    const TemporaryFolder folder;
    write_discregrid(field, folder / "field.cdf");
    std::ifstream in(folder / "field.cdf", std::ios::binary);
    const std::string content((std::istreambuf_iterator<char>(in)), {});
    if (!m_field.load(content.data(), static_cast<int>(content.size())) || !m_field.isValid()) {
      throw InputError(fmt::format("discregrid: bone '{}'", bone.name), "Bullet does not take the field; report this");
    }
    const FieldFacts& facts = field.facts();
    m_lipschitz_bound = facts.lipschitz_bound;
    m_half_cell_m = 0.5 * shape.cell_size_m.norm();
    m_domain = Eigen::AlignedBox3d(shape.lower_m, shape.upper_m());
    m_error = {"", bytes(), facts.error.samples, facts.error.largest_m, facts.error.p99_m};
  }

  /// As of `sdf`, whose values these are.
  [[nodiscard]] AnswerBound answer_bound() const { return {m_half_cell_m, m_half_cell_m, 1e-6 * m_half_cell_m}; }
  /// Values of all nodes in double precision, 32 indices a cell, and the map of cells.
  [[nodiscard]] std::size_t bytes() const {
    std::size_t bytes = sizeof(*this);
    for (int i = 0; i < m_field.m_nodes.size(); ++i) {
      bytes += static_cast<std::size_t>(m_field.m_nodes[i].size()) * sizeof(double) +
               static_cast<std::size_t>(m_field.m_cells[i].size()) * sizeof(btCell32) +
               static_cast<std::size_t>(m_field.m_cell_map[i].size()) * sizeof(unsigned);
    }
    return bytes;
  }
  [[nodiscard]] std::optional<StructureError> error() const { return m_error; }
  [[nodiscard]] const DiscregridBone& session() const { return *this; }

  [[nodiscard]] LocatedPoint locate(const Vec3& point, int& /*near*/) const {
    // Bullet's own test lets through what is not a number.
    if (!(point.array() > m_domain.min().array()).all() || !(point.array() < m_domain.max().array()).all()) {
      return {.clearance_m = m_domain.exteriorDistance(point)};
    }
    double value_m = 0;
    btVector3 gradient(0, 0, 0);
    if (!m_field.interpolate(0, value_m, {point.x(), point.y(), point.z()}, &gradient)) return {};
    if (value_m >= 0) return {.clearance_m = value_m / m_lipschitz_bound};
    const Vec3 slope(gradient.x(), gradient.y(), gradient.z());
    const Vec3 out = slope.norm() > 1e-9 ? slope.normalized() : (point - m_domain.center()).stableNormalized();
    return {.inside = true, .depth_m = -value_m, .outward = out.isZero() ? Vec3::UnitX() : out};
  }

 private:
  btMiniSDF m_field;
  double m_lipschitz_bound = 1;
  double m_half_cell_m = 0;
  Eigen::AlignedBox3d m_domain;
  StructureError m_error;
};

/// Of all cells of these bones: seven values a cell and 32 indices, in the field, in its file's text and in Bullet.
void require_room(std::size_t bones, std::int64_t cells) {
  constexpr double bytes_a_cell = 3 * (7 * sizeof(double) + sizeof(btCell32));
  const double bytes = bytes_a_cell * static_cast<double>(bones) * std::pow(static_cast<double>(cells), 3);
  const double share = std::cbrt(static_cast<double>(available_memory_bytes()) / bytes);
  require_memory(static_cast<std::size_t>(bytes), "discregrid: cells",
                 fmt::format("{:.0f} cells fit", std::max(1.0, std::floor(0.95 * static_cast<double>(cells) * share))));
}

std::unique_ptr<CollisionBackend> make_discregrid_backend(const Parameters& parameters) {
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
       .build = build_located(parameters, [settings](const Bone& bone, int threads, const ShareReport& report) {
         return std::make_unique<const DiscregridBone>(bone, settings, threads, report);
       })});
}

}  // namespace

// The format and its evaluation are Discregrid's (Koschier, Deul and Bender 2016; Koschier and others 2017), shipped by
// Bullet as btMiniSDF, which takes value and gradient from one call.
BackendEntry discregrid_entry() {
  return {.name = "discregrid",
          .help = "the field of `sdf` in Discregrid's format, evaluated by Discregrid's algorithm",
          .implementation = fmt::format("Discregrid's btMiniSDF in Bullet {}.{:02}, zlib; the field is built here",
                                        BT_BULLET_VERSION / 100, BT_BULLET_VERSION % 100),
          .default_response = ResponseKind::project,
          .parameters = {parameter::integer(
                             {.name = "cells",
                              .default_value = 64,
                              .minimum = 1,
                              .maximum = 200,
                              .role = ParameterRole::resolution,
                              .help = "cells along each axis of the bone's bounding box; Bullet reads no larger "
                                      "field than of some 220"}),
                         cull_parameter(), clearance_cache_parameter()},
          .make = make_discregrid_backend};
}

}  // namespace musclebench

#include "backends/sdf/sdf_backend.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "backends/sdf/cubic_field.hpp"
#include "backends/sdf/field_builder.hpp"
#include "backends/sdf/field_file.hpp"
#include "core/base/system_memory.hpp"

namespace musclebench {

namespace {

/// Where a field sits in the world: `to_cells * x + offset` counts its cells along its axes.
struct CellMap {
  Mat3 to_cells;
  Vec3 offset;
  Vec3 upper;  ///< number of cells

  CellMap(const GridShape& shape, const RigidMotion& pose)
      : to_cells(shape.cell_size_m.cwiseInverse().asDiagonal() * pose.rotation.transpose()),
        offset(-(to_cells * pose.translation_m) - shape.lower_m.cwiseQuotient(shape.cell_size_m)),
        upper(shape.cells[0], shape.cells[1], shape.cells[2]) {}

  /// False outside the field, and for a position that is not a number.
  [[nodiscard]] bool place(const Vec3& position, Vec3& cells) const {
    cells = to_cells * position + offset;
    return cells.x() >= 0 && cells.y() >= 0 && cells.z() >= 0 && cells.x() < upper.x() && cells.y() < upper.y() &&
           cells.z() < upper.z();
  }
};

/// Out of the bone; away from the middle of the field where the field is flat, and along x in that very middle.
Vec3 outward(const Vec3& gradient, const Vec3& from_middle) {
  for (const Vec3& direction : {gradient, from_middle}) {
    const double length = direction.norm();
    if (length > 1e-9 && std::isfinite(length)) {
      return direction / length;
    }
  }
  return Vec3::UnitX();
}

class SdfBackend final : public CollisionBackend {
 public:
  explicit SdfBackend(const Parameters& parameters)
      : m_settings{static_cast<int>(parameters.integer("cells")), parameters.number("cell_size_m"),
                   parameters.number("margin")},
        m_precision(parameters.word("precision") == "float" ? FieldPrecision::single_precision
                                                            : FieldPrecision::double_precision),
        m_folder(parameters.word("structures")) {}

  [[nodiscard]] Capabilities capabilities() const override { return {}; }

  [[nodiscard]] bool built_from_file() const override {
    return m_loaded_fields > 0 && m_loaded_fields == m_fields.size();
  }

  /// Half a cell: what a cubic field errs by at kinks, where it is of first order. Sheets thinner than a cell lie
  /// outside it.
  [[nodiscard]] AnswerBound answer_bound(int bone) const override {
    const double half_cell_m = 0.5 * m_fields[static_cast<std::size_t>(bone)].shape().cell_size_m.norm();
    return {half_cell_m, half_cell_m};
  }

  [[nodiscard]] double step_m(int bone) const override {
    return m_fields[static_cast<std::size_t>(bone)].shape().cell_size_m.minCoeff();
  }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = 0;
    for (const CubicField& field : m_fields) {
      bytes += field.bytes();
    }
    return bytes;
  }

 private:
  void do_build() override {
    m_fields.clear();
    m_loaded_fields = 0;
    std::vector<GridShape> shapes;
    double bytes = 0;
    for (const Bone& bone : bones()) {
      shapes.push_back(grid_over(bone.surface.mesh, m_settings, bone.name));
      bytes += CubicField::bytes_needed(shapes.back(), m_precision);
    }
    require_memory(static_cast<std::size_t>(bytes), m_settings.cell_size_m > 0 ? "sdf: cell_size_m" : "sdf: cells",
                   m_settings.cell_size_m > 0 ? "choose larger cells" : "choose fewer cells");
    for (std::size_t b = 0; b < bones().size(); ++b) {
      m_fields.push_back(load_or_build(bones()[b], shapes[b]));
    }
  }

  [[nodiscard]] CubicField load_or_build(const Bone& bone, const GridShape& shape) {
    if (m_folder.empty()) {
      return build_field(SignedSurface(bone.surface), shape, m_precision, threads());
    }
    const std::string digest = surface_digest(bone.surface);
    const std::filesystem::path path = m_folder / file_name(bone);
    if (std::optional<CubicField> loaded = load_field(path, digest, shape, m_precision)) {
      ++m_loaded_fields;
      return *std::move(loaded);
    }
    CubicField built = build_field(SignedSurface(bone.surface), shape, m_precision, threads());
    save_field(built, digest, path);
    return built;
  }

  [[nodiscard]] std::string file_name(const Bone& bone) const {
    std::string name = bone.name;
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    const std::string grid = m_settings.cell_size_m > 0 ? fmt::format("{}m", m_settings.cell_size_m)
                                                        : fmt::format("{}cells", m_settings.cells);
    return fmt::format("{}-{}-{}.field", name, grid,
                       m_precision == FieldPrecision::single_precision ? "float" : "double");
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    for (std::size_t b = 0; b < m_fields.size(); ++b) {
      detect_bone(static_cast<int>(b), positions, nodes, contacts);
    }
  }

  void detect_bone(int bone, std::span<const Vec3> positions, std::span<const int> nodes,
                   std::vector<Contact>& contacts) const {
    const CubicField& field = m_fields[static_cast<std::size_t>(bone)];
    const RigidMotion& pose = poses()[static_cast<std::size_t>(bone)];
    const GridShape& shape = field.shape();
    const CellMap map(shape, pose);
    for (const int node : nodes) {
      Vec3 cells;
      if (!map.place(positions[static_cast<std::size_t>(node)], cells)) {
        continue;
      }
      const auto i = static_cast<std::size_t>(cells.x());
      const auto j = static_cast<std::size_t>(cells.y());
      const auto k = static_cast<std::size_t>(cells.z());
      if (!field.may_be_negative(shape.cell(i, j, k))) {
        continue;
      }
      const CubicCell cell = field.cell(i, j, k);
      const Vec3 at = cells - Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
      const double value = cell.value(at);
      if (value < 0) {
        Vec3 gradient;
        (void)cell.value_and_gradient(at, gradient);
        const Vec3 from_middle = (cells - 0.5 * map.upper).cwiseProduct(shape.cell_size_m);
        const Vec3 normal = outward(gradient.cwiseQuotient(shape.cell_size_m), from_middle);
        contacts.push_back({node, bone, -value, pose.apply_to_direction(normal)});
      }
    }
  }

  GridSettings m_settings;
  FieldPrecision m_precision;
  std::filesystem::path m_folder;
  std::size_t m_loaded_fields = 0;
  std::vector<CubicField> m_fields;
};

}  // namespace

std::vector<ParameterSpec> sdf_parameters() {
  return {
      {"cells", std::int64_t{64}, "cells along each axis of the bone's box (unless cell_size_m is given)", 1, 4096, {}},
      {"cell_size_m", 0.0, "edge of cubic cells; 0: use `cells`", 0, 10, {}},
      {"precision", std::string("float"), "stored values", -1e300, 1e300, {"float", "double"}},
      {"margin", 1e-3, "how far the field reaches beyond the bone's box, as a share of its diagonal", 1e-6, 1, {}},
      {"structures",
       std::string(),
       "folder where built fields are kept and found again; empty: none",
       -1e300,
       1e300,
       {}},
  };
}

std::unique_ptr<CollisionBackend> make_sdf_backend(const Parameters& parameters) {
  return std::make_unique<SdfBackend>(parameters);
}

}  // namespace musclebench

#include "backends/sdf/grid_field_source.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/build/field_memory.hpp"
#include "backends/sdf/files/discregrid_file.hpp"
#include "backends/sdf/files/foreign_field.hpp"
#include "backends/sdf/files/kept_fields.hpp"
#include "backends/sdf/grid/cubic_field.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// Samples for the error estimate of a field from another program.
constexpr int samples_of_foreign = 2000;

/// By how much two fields of one bone differ in a depth because their values were rounded to what is stored. No value
/// in a cell that reaches into the bone is larger than half of the domain's diagonal; interpolation enlarges an error
/// by at most four (the weights of a cubic cell's nodes).
double storage_rounding_m(const CubicField& field) {
  constexpr double enlarged = 4;
  constexpr double both = 2;
  const GridShape& grid = field.shape();
  const double largest_m = 0.5 * (grid.upper_m() - grid.lower_m).norm();
  return both * enlarged * 0.5 * static_cast<double>(std::numeric_limits<float>::epsilon()) * largest_m;
}

class GridBoneField final : public BoneField {
 public:
  GridBoneField(CubicField field, const StructureOrigin& origin) : BoneField(origin), m_field(std::move(field)) {}

  [[nodiscard]] std::size_t bytes() const override { return m_field.bytes(); }
  [[nodiscard]] std::optional<StructureError> error() const override {
    const FieldError& error = m_field.facts().error;
    return StructureError{"", m_field.bytes(), error.samples, error.largest_m, error.p99_m};
  }
  /// Half a cell: what a cubic field errs by at kinks, where it is of first order. Sheets thinner than a cell lie
  /// outside it.
  [[nodiscard]] AnswerBound answer_bound() const override {
    const double half_cell_m = 0.5 * grid().cell_size_m.norm();
    return {half_cell_m, half_cell_m, storage_rounding_m(m_field)};
  }
  [[nodiscard]] double step_m() const override { return grid().cell_size_m.minCoeff(); }
  [[nodiscard]] const GridShape& grid() const override { return m_field.shape(); }

  std::size_t sample(const CellMap& map, std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                     Wanted wanted, FieldAnswers& answers) const override {
    FieldBlock& block = answers.block;
    if (wanted == Wanted::contacts) {
      return m_field.sample(map, positions, nodes, first, CubicField::Wanted::may_be_inside, block);
    }
    const std::size_t next = m_field.sample(map, positions, nodes, first, CubicField::Wanted::known, block);
    for (std::size_t n = 0; n < block.count; ++n) {
      if (block.value_m[n] < 0 && !may_be_inside(block.cells(n))) {
        block.value_m[n] = 0;  // below zero by rounding only
      }
    }
    return next;
  }

  void find_clearances(const FieldAnswers& answers, FieldBlock::Lanes<double>& clearance_m) const override {
    const double lipschitz_bound = m_field.facts().lipschitz_bound;
    for (std::size_t n = 0; n < answers.block.count; ++n) clearance_m[n] = answers.block.value_m[n] / lipschitz_bound;
    if (!grid().is_part()) return;
    // Slopes are bounded in the part only; and whoever leaves it has to be asked again.
    for (std::size_t n = 0; n < answers.block.count; ++n) {
      clearance_m[n] = std::min(clearance_m[n], grid().distance_to_left_out_m(answers.block.cells(n)));
    }
  }

 private:
  [[nodiscard]] bool may_be_inside(const Vec3& cells) const {
    const CellPosition at = grid().locate(cells);
    return m_field.may_be_negative(grid().cell(at.i, at.j, at.k));
  }

  CubicField m_field;
};

class GridFieldSource final : public FieldSource {
 public:
  explicit GridFieldSource(const Parameters& parameters)
      : m_grid(grid_settings(parameters)), m_folder(parameters.word("structures")) {}

  [[nodiscard]] bool needs_closed_surfaces() const override { return false; }

  void require_fit(std::span<const Bone> bones) const override {
    std::vector<GridShape> shapes;
    for (const Bone& bone : bones) shapes.push_back(grid_over(bone.surface.mesh, m_grid, bone.name));
    require_room(shapes, m_grid);
  }

  [[nodiscard]] double contact_reach_m(const Bone& bone) const override {
    const GridShape shape = grid_over(bone.surface.mesh, m_grid, bone.name);
    const Eigen::AlignedBox3d box = bounding_box(bone.surface.mesh.vertices);
    return (box.min() - shape.lower_m).cwiseMax(shape.upper_m() - box.max()).norm();
  }

  /// A file is of the whole field, so that every scene can use it.
  [[nodiscard]] std::unique_ptr<BoneField> make(const Bone& bone, int threads, const ShareReport& progress,
                                                const Eigen::AlignedBox3d& expected) const override {
    const GridShape whole = grid_over(bone.surface.mesh, m_grid, bone.name);
    const GridShape shape = m_folder.empty() ? whole.part(expected) : whole;
    const KeptFields<CubicField> kept{
        [&] { return build_field(bone.signed_distance(), shape, threads, progress); },
        [&](const std::filesystem::path& path, const std::string& digest) { return load_field(path, digest, shape); },
        [](const CubicField& field, const std::filesystem::path& path, const std::string& digest) {
          save_field(field, digest, path);
        }};
    auto [field, origin] = kept.load_or_build(m_folder, built_with(), "field", bone.surface, threads);
    return std::make_unique<GridBoneField>(std::move(field), origin);
  }

 private:
  [[nodiscard]] std::string built_with() const {
    const std::string grid =
        m_grid.cell_size_m > 0 ? fmt::format("{}m", m_grid.cell_size_m) : fmt::format("{}cells", m_grid.cells);
    return grid + margin_file_name(m_grid.margin);
  }

  GridSettings m_grid;
  std::filesystem::path m_folder;
};

class DiscregridFieldSource final : public FieldSource {
 public:
  explicit DiscregridFieldSource(const Parameters& parameters) : m_folder(parameters.word("discregrid")) {}

  [[nodiscard]] bool needs_closed_surfaces() const override { return false; }

  [[nodiscard]] std::unique_ptr<BoneField> make(const Bone& bone, int threads, const ShareReport& /*progress*/,
                                                const Eigen::AlignedBox3d& /*expected*/) const override {
    const std::filesystem::path path = m_folder / (bone_file_name(bone.name) + ".cdf");
    CubicField field = read_discregrid(path, threads);
    const SignedSurface& surface = bone.signed_distance();
    require_field_of(field, bone.surface.mesh, surface, bone.name, path);
    field.facts().error = estimate_error(field, surface, samples_of_foreign);
    return std::make_unique<GridBoneField>(std::move(field), StructureOrigin{true});
  }

 private:
  std::filesystem::path m_folder;
};

}  // namespace

std::unique_ptr<FieldSource> make_grid_field_source(const Parameters& parameters) {
  return std::make_unique<GridFieldSource>(parameters);
}

std::unique_ptr<FieldSource> make_discregrid_field_source(const Parameters& parameters) {
  return std::make_unique<DiscregridFieldSource>(parameters);
}

}  // namespace musclebench

#include "backends/sdf/octree_field_source.hpp"

#include <filesystem>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "backends/sdf/build/octree_builder.hpp"
#include "backends/sdf/files/kept_fields.hpp"
#include "backends/sdf/files/octree_file.hpp"
#include "backends/sdf/sdf_settings.hpp"

namespace musclebench {

namespace {

class OctreeBoneField final : public BoneField {
 public:
  OctreeBoneField(OctreeField field, const StructureOrigin& origin)
      : BoneField(origin), m_field(std::move(field)), m_grid(m_field.shape().grid()) {}

  [[nodiscard]] std::size_t bytes() const override { return m_field.bytes(); }
  [[nodiscard]] std::optional<StructureError> error() const override {
    const OctreeQuality& quality = m_field.quality();
    return StructureError{"", m_field.bytes(), static_cast<int>(quality.samples), quality.largest_m, quality.p99_m};
  }
  /// Proven, for sheets of any thickness, too; actual errors are some hundred times smaller. Rounding decides which
  /// leaves are divided.
  [[nodiscard]] AnswerBound answer_bound() const override {
    const double bound_m = m_field.quality().bound_m;
    return {bound_m, bound_m, bound_m};
  }
  [[nodiscard]] double step_m() const override { return m_field.step_m(); }
  [[nodiscard]] const GridShape& grid() const override { return m_grid; }

  std::size_t sample(const CellMap& map, std::span<const Vec3> positions, std::span<const int> nodes, std::size_t first,
                     Wanted /*wanted*/, FieldAnswers& answers) const override {
    return m_field.sample(map, positions, nodes, first, answers.block, answers.leaves);
  }
  void find_clearances(const FieldAnswers& answers, FieldBlock::Lanes<double>& clearance_m) const override {
    m_field.clear(answers.block, answers.leaves, clearance_m);
  }

 private:
  OctreeField m_field;
  GridShape m_grid;  ///< a cell a root
};

class OctreeFieldSource final : public FieldSource {
 public:
  explicit OctreeFieldSource(const Parameters& parameters)
      : m_settings(octree_settings(parameters)),
        m_error_name(format_parameter_value(parameters.number("max_error_mm"))),
        m_folder(parameters.word("structures")) {}

  /// Leaves without a polynomial store only a lower bound of the unsigned distance.
  [[nodiscard]] bool needs_closed_surfaces() const override { return true; }

  [[nodiscard]] double contact_reach_m(const Bone& bone) const override {
    return octree_reach_m(bone.surface.mesh, m_settings);
  }

  /// Of the whole bone: cells are split until the error of all its surface is what was wanted, so that a part would
  /// have other cells, and other bits.
  [[nodiscard]] std::unique_ptr<BoneField> make(const Bone& bone, int threads, const ShareReport& progress,
                                                const Eigen::AlignedBox3d& /*expected*/) const override {
    const KeptFields<OctreeField> kept{
        [&] {
          return build_octree(bone.signed_distance(), bone.surface.mesh, m_settings, bone.name, threads, progress);
        },
        [&](const std::filesystem::path& path, const std::string& digest) {
          return load_octree(path, digest, m_settings);
        },
        [&](const OctreeField& field, const std::filesystem::path& path, const std::string& digest) {
          save_octree(field, digest, m_settings, path);
        }};
    const std::string built_with = fmt::format("{}mm{}", m_error_name, margin_file_name(m_settings.margin));
    auto [field, origin] = kept.load_or_build(m_folder, built_with, "octree", bone.surface, threads);
    return std::make_unique<OctreeBoneField>(std::move(field), origin);
  }

 private:
  OctreeSettings m_settings;
  std::string m_error_name;
  std::filesystem::path m_folder;
};

}  // namespace

std::unique_ptr<FieldSource> make_octree_field_source(const Parameters& parameters) {
  return std::make_unique<OctreeFieldSource>(parameters);
}

}  // namespace musclebench

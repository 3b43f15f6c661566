#include "backends/sdf/octree_backend.hpp"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/field_contact.hpp"
#include "backends/sdf/field_detection.hpp"
#include "backends/sdf/field_file.hpp"
#include "backends/sdf/octree_builder.hpp"
#include "backends/sdf/octree_file.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/clearance/clearance_cache.hpp"

namespace musclebench {

namespace {

class OctreeBackend final : public CollisionBackend {
 public:
  explicit OctreeBackend(const Parameters& parameters)
      : m_settings(octree_settings(parameters)),
        m_error_name(format_parameter_value(parameters.number("max_error_mm"))),
        m_folder(parameters.word("structures")),
        m_wants_budgets(uses_clearance_cache(parameters)) {}

  [[nodiscard]] Capabilities capabilities() const override { return {.remembers = m_detection.has_budgets()}; }
  [[nodiscard]] bool built_from_file() const override {
    return m_loaded_fields > 0 && m_loaded_fields == m_fields.size();
  }

  /// Proven, sheets of any thickness included; what is reached is some hundred times less.
  [[nodiscard]] AnswerBound answer_bound(int bone) const override {
    const double bound_m = field(bone).quality().bound_m;
    return {bound_m, bound_m};
  }
  [[nodiscard]] double step_m(int bone) const override { return field(bone).step_m(); }
  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = m_detection.bytes();
    for (const OctreeField& each : m_fields) {
      bytes += each.bytes();
    }
    return bytes;
  }
  [[nodiscard]] std::vector<StructureError> structure_errors() const override {
    std::vector<StructureError> errors;
    for (std::size_t b = 0; b < m_fields.size(); ++b) {
      const OctreeQuality& quality = m_fields[b].quality();
      errors.push_back(
          {bones()[b].name, m_fields[b].bytes(), static_cast<int>(quality.samples), quality.largest_m, quality.p99_m});
    }
    return errors;
  }

 private:
  [[nodiscard]] const OctreeField& field(int bone) const { return m_fields[static_cast<std::size_t>(bone)]; }

  void do_build() override {
    m_fields.clear();
    m_loaded_fields = 0;
    // What lies between the fine cells is known by the distance alone.
    m_detection.reset(bones(), muscle().vertices.size(), m_wants_budgets && are_closed(bones()));
    for (const Bone& bone : bones()) {
      m_fields.push_back(load_or_build(bone));
    }
  }

  [[nodiscard]] OctreeField load_or_build(const Bone& bone) {
    const auto build = [&] {
      const double before = static_cast<double>(m_fields.size());
      const auto report = [&](double share) { build_report()((before + share) / static_cast<double>(bones().size())); };
      return build_octree(bone.signed_distance(), bone.surface.mesh, m_settings, bone.name, threads(),
                          build_report() ? BuildProgress(report) : nullptr);
    };
    if (m_folder.empty()) {
      return build();
    }
    const std::string digest = surface_digest(bone.surface);
    const std::filesystem::path path = m_folder / fmt::format("{}-{}mm{}.octree", bone_file_name(bone.name),
                                                              m_error_name, margin_file_name(m_settings.margin));
    if (std::optional<OctreeField> loaded = load_octree(path, digest, m_settings)) {
      ++m_loaded_fields;
      return *std::move(loaded);
    }
    OctreeField built = build();
    save_octree(built, digest, m_settings, path);
    return built;
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_detection.detect(
        poses(), positions, nodes, threads(),
        [&](const FieldDetection::Share& share, std::vector<Contact>& found) { detect_share(share, positions, found); },
        contacts);
  }

  /// Where there are budgets all nodes are new ones or have used up what they may move, and are granted anew.
  void detect_share(const FieldDetection::Share& share, std::span<const Vec3> positions,
                    std::vector<Contact>& contacts) {
    const auto& [bone, nodes] = share;
    const GridShape grid = field(bone).shape().grid();
    const CellMap map(grid, pose(bone));
    FieldBlock block;
    LeafBlock leaves;
    for (std::size_t next = 0; next < nodes.size();) {
      const std::size_t first = next;
      block.count = 0;
      next = field(bone).sample(map, positions, nodes, next, block, leaves);
      for (std::size_t n = 0; n < block.count; ++n) {
        if (block.value_m[n] < 0) {
          contacts.push_back(field_contact(grid, pose(bone), bone, nodes[block.asker[n]], block, n));
        }
      }
      if (m_detection.has_budgets()) {
        grant_near(bone, nodes, block, leaves);
        grant_far(bone, nodes, first, next, map, positions, block);
      }
    }
  }

  void grant_near(int bone, std::span<const int> nodes, const FieldBlock& block, const LeafBlock& leaves) {
    const GridShape grid = field(bone).shape().grid();
    FieldBlock::Lanes<double> clearance_m;
    field(bone).clear(block, leaves, clearance_m);
    for (std::size_t n = 0; n < block.count; ++n) {
      if (block.value_m[n] >= 0) {
        m_detection.budgets().grant(bone, nodes[block.asker[n]], grid.point(block.cells(n)), clearance_m[n]);
      }
    }
  }

  /// Those from `first` to `end` that are not in the field.
  void grant_far(int bone, std::span<const int> nodes, std::size_t first, std::size_t end, const CellMap& map,
                 std::span<const Vec3> positions, const FieldBlock& block) {
    const GridShape grid = field(bone).shape().grid();
    for (std::size_t place = first, n = 0; place < end; ++place) {
      if (n < block.count && block.asker[n] == place) {
        ++n;
        continue;
      }
      const Vec3 cells = map.apply(positions[static_cast<std::size_t>(nodes[place])]);
      m_detection.budgets().grant(bone, nodes[place], grid.point(cells), grid.distance_m(cells));
    }
  }

  [[nodiscard]] const RigidMotion& pose(int bone) const { return poses()[static_cast<std::size_t>(bone)]; }

  OctreeSettings m_settings;
  std::string m_error_name;
  std::filesystem::path m_folder;
  bool m_wants_budgets;
  std::size_t m_loaded_fields = 0;
  std::vector<OctreeField> m_fields;
  FieldDetection m_detection;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_octree_backend(const Parameters& parameters) {
  return std::make_unique<OctreeBackend>(parameters);
}

}  // namespace musclebench

#include "backends/sdf/sdf_backend.hpp"

#include <string>
#include <utility>

#include "backends/sdf/bone_field.hpp"
#include "backends/sdf/field_contact.hpp"
#include "backends/sdf/field_detection.hpp"
#include "backends/sdf/grid_field_source.hpp"
#include "backends/sdf/octree_field_source.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/clearance/clearance_cache.hpp"

namespace musclebench {

namespace {

class SdfBackend final : public CollisionBackend {
 public:
  SdfBackend(std::unique_ptr<FieldSource> source, bool wants_cache)
      : m_source(std::move(source)), m_wants_cache(wants_cache) {}

  [[nodiscard]] Capabilities capabilities() const override {
    return {.has_cache = m_wants_cache, .has_step = true, .steady_memory = true};
  }

  [[nodiscard]] bool built_from_file() const override {
    return m_loaded_fields > 0 && m_loaded_fields == m_fields.size();
  }
  [[nodiscard]] AnswerBound answer_bound(int bone) const override { return field(bone).answer_bound(); }
  [[nodiscard]] double step_m(int bone) const override { return field(bone).step_m(); }

  [[nodiscard]] std::vector<StructureError> structure_errors() const override {
    std::vector<StructureError> errors;
    for (const auto& each : m_fields) {
      errors.push_back(each->error());
      errors.back().bone = bones()[errors.size() - 1].name;
    }
    return errors;
  }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = m_detection.bytes();
    for (const auto& each : m_fields) {
      bytes += each->error().bytes;
    }
    return bytes;
  }

 private:
  [[nodiscard]] const BoneField& field(int bone) const { return *m_fields[static_cast<std::size_t>(bone)]; }
  [[nodiscard]] const RigidMotion& pose(int bone) const { return poses()[static_cast<std::size_t>(bone)]; }

  void do_build() override {
    m_fields.clear();
    m_loaded_fields = 0;
    m_detection.reset(bones(), muscle().vertices.size(),
                      m_wants_cache && (!m_source->needs_closed_surfaces() || are_closed(bones())));
    m_source->require_fit(bones());
    for (const Bone& bone : bones()) {
      const double before = static_cast<double>(m_fields.size());
      const auto report = [&](double share) { build_report()((before + share) / static_cast<double>(bones().size())); };
      FieldSource::Made made =
          m_source->make(bone, threads(), build_report() ? std::function<void(double)>(report) : nullptr);
      m_fields.push_back(std::move(made.field));
      m_loaded_fields += made.from_file ? 1 : 0;
    }
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_detection.detect(
        poses(), positions, nodes, threads(),
        [&](const FieldDetection::Share& share, std::vector<Contact>& found) { detect_share(share, positions, found); },
        contacts);
  }

  /// With a clearance cache all `nodes` have no clearance or have left theirs, and get a new one unless they are
  /// contacts.
  void detect_share(const FieldDetection::Share& share, std::span<const Vec3> positions,
                    std::vector<Contact>& contacts) {
    const auto& [bone, nodes] = share;
    const BoneField& field = this->field(bone);
    const CellMap map(field.grid(), pose(bone));
    const auto wanted = m_detection.has_cache() ? BoneField::Wanted::clearances : BoneField::Wanted::contacts;
    FieldAnswers answers;
    const FieldBlock& block = answers.block;
    for (std::size_t next = 0; next < nodes.size();) {
      const std::size_t first = next;
      answers.block.count = 0;
      next = field.sample(map, positions, nodes, next, wanted, answers);
      for (std::size_t n = 0; n < block.count; ++n) {
        if (block.value_m[n] < 0) {
          contacts.push_back(field_contact(field.grid(), pose(bone), bone, nodes[block.query[n]], block, n));
        }
      }
      if (m_detection.has_cache()) {
        store_sampled(bone, nodes, answers);
        store_left_out(bone, nodes, first, next, map, positions, block);
      }
    }
  }

  void store_sampled(int bone, std::span<const int> nodes, const FieldAnswers& answers) {
    const FieldBlock& block = answers.block;
    FieldBlock::Lanes<double> clearance_m;
    field(bone).find_clearances(answers, clearance_m);
    for (std::size_t n = 0; n < block.count; ++n) {
      if (block.value_m[n] >= 0) {
        m_detection.clearance_cache().store(bone, nodes[block.query[n]], field(bone).grid().point(block.cells(n)),
                                            clearance_m[n]);
      }
    }
  }

  /// Those from `first` to `end` that are not in the block.
  void store_left_out(int bone, std::span<const int> nodes, std::size_t first, std::size_t end, const CellMap& map,
                      std::span<const Vec3> positions, const FieldBlock& block) {
    for (std::size_t index = first, n = 0; index < end; ++index) {
      if (n < block.count && block.query[n] == index) {
        ++n;
        continue;
      }
      const Vec3 cells = map.apply(positions[static_cast<std::size_t>(nodes[index])]);
      m_detection.clearance_cache().store(bone, nodes[index], field(bone).grid().point(cells),
                                          field(bone).clearance_m(cells));
    }
  }

  std::unique_ptr<FieldSource> m_source;
  bool m_wants_cache;
  std::size_t m_loaded_fields = 0;
  std::vector<std::unique_ptr<BoneField>> m_fields;
  FieldDetection m_detection;
};

std::unique_ptr<FieldSource> make_field_source(const Parameters& parameters) {
  if (wants_octree(parameters)) {
    return make_octree_field_source(parameters);
  }
  return parameters.word("discregrid").empty() ? make_grid_field_source(parameters)
                                               : make_discregrid_field_source(parameters);
}

}  // namespace

std::unique_ptr<CollisionBackend> make_sdf_backend(const Parameters& parameters) {
  return std::make_unique<SdfBackend>(make_field_source(parameters), uses_clearance_cache(parameters));
}

}  // namespace musclebench

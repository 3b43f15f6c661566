#include "backends/sdf/octree_backend.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/field_file.hpp"
#include "backends/sdf/octree_builder.hpp"
#include "backends/sdf/octree_file.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/contact/motion_budgets.hpp"

namespace musclebench {

namespace {

class OctreeBackend final : public CollisionBackend {
 public:
  explicit OctreeBackend(const Parameters& parameters)
      : m_settings(octree_settings(parameters)),
        m_error_name(format_parameter_value(parameters.number("max_error_mm"))),
        m_folder(parameters.word("structures")),
        m_wants_budgets(has_motion_budgets(parameters)) {}

  [[nodiscard]] Capabilities capabilities() const override { return {.remembers = m_has_budgets}; }
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
    std::size_t bytes = m_has_budgets ? m_budgets.bytes() : 0;
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
    // What lies between the fine cells is known by the distance alone, and across a hole the side changes without a
    // surface.
    m_has_budgets = m_wants_budgets && std::all_of(bones().begin(), bones().end(),
                                                   [](const Bone& bone) { return is_closed(bone.surface.mesh); });
    m_loaded_fields = 0;
    if (m_has_budgets) {
      m_budgets.reset(bones(), muscle().vertices.size());
    }
    for (const Bone& bone : bones()) {
      m_fields.push_back(load_or_build(bone));
    }
  }

  [[nodiscard]] OctreeField load_or_build(const Bone& bone) {
    const auto build = [&] {
      const double before = static_cast<double>(m_fields.size());
      const auto report = [&](double share) { build_report()((before + share) / static_cast<double>(bones().size())); };
      return build_octree(SignedSurface(bone.surface), bone.surface.mesh, m_settings, bone.name, threads(),
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
    if (m_has_budgets && positions.size() != m_budgets.nodes()) {
      m_budgets.reset(bones(), positions.size());
    }
    if (m_has_budgets) {
      m_budgets.collect_spent(poses(), positions, nodes);
    }
    for (int bone = 0; bone < static_cast<int>(m_fields.size()); ++bone) {
      for (const int node : m_has_budgets ? m_budgets.spent(bone) : nodes) {
        ask(bone, node, positions, contacts);
      }
    }
  }

  void ask(int bone, int node, std::span<const Vec3> positions, std::vector<Contact>& contacts) {
    const RigidMotion& pose = poses()[static_cast<std::size_t>(bone)];
    const Vec3 at = pose.apply_inverse(positions[static_cast<std::size_t>(node)]);
    if (const std::optional<OctreeField::Sample> inside = field(bone).sample_inside(at)) {
      contacts.push_back({node, bone, -inside->value_m, pose.apply_to_direction(outward(field(bone), at, *inside))});
    } else if (m_has_budgets) {
      m_budgets.grant(bone, node, at, field(bone).clearance_m(at));
    }
  }

  /// Away from the middle of the field where the field is flat, and along x in that very middle.
  [[nodiscard]] static Vec3 outward(const OctreeField& field, const Vec3& at, const OctreeField::Sample& sample) {
    const Vec3 middle = 0.5 * (field.shape().lower_m + field.shape().upper_m());
    for (const Vec3& direction : {sample.gradient, Vec3(at - middle)}) {
      const double length = direction.norm();
      if (length > 1e-9 && std::isfinite(length)) {
        return direction / length;
      }
    }
    return Vec3::UnitX();
  }

  OctreeSettings m_settings;
  std::string m_error_name;
  std::filesystem::path m_folder;
  bool m_wants_budgets;
  bool m_has_budgets = false;
  std::size_t m_loaded_fields = 0;
  std::vector<OctreeField> m_fields;
  MotionBudgets m_budgets;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_octree_backend(const Parameters& parameters) {
  return std::make_unique<OctreeBackend>(parameters);
}

}  // namespace musclebench

#include <algorithm>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

class Attachment final : public Effect {
 public:
  explicit Attachment(const EffectInput& input) {
    for (const auto& [node, bone] : input.bound_nodes) {
      m_bound_rows.push_back({static_cast<std::size_t>(input.order.row_of(node)), bone,
                              input.rest_poses[bone].apply_inverse(input.mesh.vertices[node])});
    }
    std::ranges::sort(m_bound_rows, {}, &BoundRow::row);
  }

  [[nodiscard]] std::string_view name() const override { return "attachment"; }

  void project(NodeRows& rows, const SubstepInput& input, const Team& team) override {
    const auto [first, last] =
        team.share_by_row(m_bound_rows.size(), rows.size(), [&](std::size_t i) { return m_bound_rows[i].row; });
    for (std::size_t i = first; i < last; ++i) {
      const auto& [row, bone, position] = m_bound_rows[i];
      rows[row].set_position(input.bone_poses[bone].apply(position));
    }
  }

 private:
  struct BoundRow {
    std::size_t row;
    int bone;
    Vec3 position;  ///< rest frame of the bone
  };

  std::vector<BoundRow> m_bound_rows;
};

std::unique_ptr<Effect> make_attachment(const EffectInput& input, const Parameters& /*parameters*/) {
  return std::make_unique<Attachment>(input);
}

std::vector<ParameterSpec> attachment_parameters() { return {}; }

}  // namespace

/// Bound nodes follow their bone: p = pose(rest position in the bone's frame). Their inverse mass is 0, so that no
/// other constraint moves them (Mueller et al. 2007, "Position based dynamics", section 3.6: attachments are nodes of
/// infinite mass).
EffectEntry attachment_entry() {
  return {.name = "attachment",
          .help = "bound nodes move with their bone",
          .parameters = attachment_parameters(),
          .make = make_attachment,
          .colour = "#b3b3b3"};
}

}  // namespace musclebench

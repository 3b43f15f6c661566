#include "core/effects/attachment.hpp"

namespace musclebench {

namespace {

class Attachment final : public Effect {
 public:
  explicit Attachment(const EffectInput& input) : m_bound_nodes(input.bound_nodes) {
    for (const BoundNode& bound : m_bound_nodes) {
      m_bone_frame_positions.push_back(input.rest_poses[bound.bone].apply_inverse(input.muscle.vertices[bound.node]));
    }
  }

  [[nodiscard]] std::string_view name() const override { return "attachment"; }

  void project(Particles& particles, const SubstepInput& input) override {
    for (std::size_t i = 0; i < m_bound_nodes.size(); ++i) {
      particles.predicted[m_bound_nodes[i].node] =
          input.bone_poses[m_bound_nodes[i].bone].apply(m_bone_frame_positions[i]);
    }
  }

 private:
  std::vector<BoundNode> m_bound_nodes;
  std::vector<Vec3> m_bone_frame_positions;
};

}  // namespace

std::unique_ptr<Effect> make_attachment(const EffectInput& input, const Parameters& /*parameters*/) {
  return std::make_unique<Attachment>(input);
}

std::vector<ParameterSpec> attachment_parameters() { return {}; }

}  // namespace musclebench

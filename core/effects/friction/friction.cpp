#include <algorithm>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

class Friction final : public ContactStage {
 public:
  Friction(const StageInput& input, double coefficient) : m_coefficient(coefficient), m_push_m(input.nodes, 0) {
    const std::size_t most_contacts = input.nodes * input.bones.size();
    m_before.reserve(most_contacts);
    m_corrections.reserve(most_contacts);
    m_nodes.reserve(most_contacts);
  }

  [[nodiscard]] std::string_view name() const override { return "friction"; }

  void before_response(const ContactStageInput& input) override {
    m_before.clear();
    for (const Contact& contact : input.contacts) m_before.push_back(input.predicted[contact.node]);
  }

  std::span<const int> after_bones(const ContactStageInput& input) override {
    m_nodes.clear();
    for (std::size_t i = 0; i < input.contacts.size(); ++i) {
      const Contact& contact = input.contacts[i];
      m_nodes.push_back(contact.node);
      m_push_m[contact.node] += push_m(input, i);
    }
    m_corrections.clear();
    for (std::size_t i = 0; i < input.contacts.size(); ++i) m_corrections.push_back(correction(input, i));
    for (std::size_t i = 0; i < input.contacts.size(); ++i) {
      input.predicted[m_nodes[i]] += m_corrections[i];
      m_push_m[m_nodes[i]] = 0;
    }
    return m_nodes;
  }

  [[nodiscard]] int contact_count() const override { return static_cast<int>(m_nodes.size()); }

 private:
  /// How far the response has moved the node out of the bone.
  [[nodiscard]] double push_m(const ContactStageInput& input, std::size_t i) const {
    const Contact& contact = input.contacts[i];
    return std::max(0.0, contact.normal.dot(input.predicted[contact.node] - m_before[i]));
  }

  [[nodiscard]] Vec3 correction(const ContactStageInput& input, std::size_t i) const {
    const Contact& contact = input.contacts[i];
    const double own_push_m = push_m(input, i);
    if (!(own_push_m > 0)) {
      return Vec3::Zero();
    }
    const Vec3 on_bone = input.previous_bone_poses[contact.bone].apply_inverse(input.start[contact.node]);
    const Vec3 displacement = input.predicted[contact.node] - input.bone_poses[contact.bone].apply(on_bone);
    const Vec3 slide = displacement - contact.normal.dot(displacement) * contact.normal;
    const double undone = share_undone_by_friction(slide.norm(), own_push_m, m_coefficient);
    return -(undone * own_push_m / m_push_m[contact.node]) * slide;
  }

  double m_coefficient;
  std::vector<double> m_push_m;  ///< by node, of all its contacts; 0 between steps
  // By contact.
  std::vector<Vec3> m_before;  ///< p before the response
  std::vector<Vec3> m_corrections;
  std::vector<int> m_nodes;
};

std::unique_ptr<ContactStage> make_friction(const StageInput& input, const Parameters& parameters) {
  return std::make_unique<Friction>(input, parameters.number("coefficient"));
}

void set_friction(ContactProperties& contacts, const Parameters& parameters) {
  contacts.friction_coefficient = parameters.number("coefficient");
}

std::vector<ParameterSpec> friction_parameters() {
  return {parameter::number({.name = "coefficient",
                             .default_value = 0.1,
                             .minimum = 0,
                             .maximum = 10,
                             .help = "Coulomb coefficient: largest tangential force over normal force"})};
}

}  // namespace

/// Coulomb friction on bones, as a limit on how far a node slides in a step (Macklin et al. 2014, "Unified
/// particle physics for real-time applications"): of the tangential displacement relative to the bone the part up to
/// coefficient times the push out of the bone is undone. A node in contact with several bones shares its friction among
/// them by their pushes, so that their order does not matter. Contacts that other stages find (faces, muscles) rub in
/// their ContactRowSolver.
EffectEntry friction_entry() {
  return {.name = "friction",
          .help = "Coulomb friction: what touches a bone, a muscle or itself slides only as far as the push allows",
          .parameters = friction_parameters(),
          .make_stage = make_friction,
          .set_contacts = set_friction,
          .needs_normals = true,
          .inert_at_zero = {"coefficient"},
          .colour = "#E69F00"};
}

}  // namespace musclebench

#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

class Gravity final : public Effect {
 public:
  explicit Gravity(const Vec3& acceleration_m_per_s2) : m_acceleration_m_per_s2(acceleration_m_per_s2) {}

  [[nodiscard]] std::string_view name() const override { return "gravity"; }
  [[nodiscard]] bool is_force() const override { return true; }

  void apply_force(const NodeRows& rows, std::span<NodeRow> velocities, const SubstepInput& input,
                   const Team& team) override {
    const Vec3 change = input.time_step_s * m_acceleration_m_per_s2;
    const auto [first, last] = team.share(rows.size());
    for (std::size_t row = first; row < last; ++row) {
      if (rows[row].inverse_mass > 0) {
        velocities[row].set_position(velocities[row].position() + change);
      }
    }
  }

 private:
  Vec3 m_acceleration_m_per_s2;
};

std::unique_ptr<Effect> make_gravity(const EffectInput& /*input*/, const Parameters& parameters) {
  return std::make_unique<Gravity>(
      Vec3(parameters.number("x_m_per_s2"), parameters.number("y_m_per_s2"), parameters.number("z_m_per_s2")));
}

std::vector<ParameterSpec> gravity_parameters() {
  const auto along = [](const char* name, double standard_m_per_s2, const char* help) {
    constexpr double limit_m_per_s2 = 1e6;
    return parameter::number({.name = name,
                              .unit = "m/s2",
                              .default_value = standard_m_per_s2,
                              .minimum = -limit_m_per_s2,
                              .maximum = limit_m_per_s2,
                              .help = help});
  };
  return {along("x_m_per_s2", 0, "acceleration along x"), along("y_m_per_s2", 0, "acceleration along y"),
          along("z_m_per_s2", -9.80665, "acceleration along z (default: standard gravity, z up)")};
}

}  // namespace

/// Constant acceleration: v += dt g for every free node, before positions are predicted (external forces of Mueller et
/// al. 2007, "Position based dynamics", section 3.1).
EffectEntry gravity_entry() {
  return {.name = "gravity",
          .help = "constant acceleration of all free nodes",
          .parameters = gravity_parameters(),
          .make = make_gravity,
          .colour = "#4d4d4d"};
}

}  // namespace musclebench

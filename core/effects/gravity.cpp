#include "core/effects/gravity.hpp"

namespace musclebench {

namespace {

class Gravity final : public Effect {
 public:
  explicit Gravity(const Vec3& acceleration_m_per_s2) : m_acceleration_m_per_s2(acceleration_m_per_s2) {}

  [[nodiscard]] std::string_view name() const override { return "gravity"; }

  void apply_force(Particles& particles, const SubstepInput& input) override {
    const Vec3 change = input.time_step_s * m_acceleration_m_per_s2;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      if (particles.inverse_masses[i] > 0) {
        particles.velocities[i] += change;
      }
    }
  }

 private:
  Vec3 m_acceleration_m_per_s2;
};

}  // namespace

std::unique_ptr<Effect> make_gravity(const EffectInput& /*input*/, const Parameters& parameters) {
  return std::make_unique<Gravity>(
      Vec3(parameters.number("x_m_per_s2"), parameters.number("y_m_per_s2"), parameters.number("z_m_per_s2")));
}

std::vector<ParameterSpec> gravity_parameters() {
  constexpr double limit = 1e6;
  return {{"x_m_per_s2", 0.0, "acceleration along x", -limit, limit, {}},
          {"y_m_per_s2", 0.0, "acceleration along y", -limit, limit, {}},
          {"z_m_per_s2", -9.80665, "acceleration along z (default: standard gravity, z up)", -limit, limit, {}}};
}

}  // namespace musclebench

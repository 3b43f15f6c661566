#include "core/base/portable_math.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

class Damping final : public Effect {
 public:
  explicit Damping(double rate_per_s) : m_rate_per_s(rate_per_s) {}

  [[nodiscard]] std::string_view name() const override { return "damping"; }
  [[nodiscard]] bool is_force() const override { return true; }

  void apply_force(const NodeRows& rows, std::span<NodeRow> velocities, const SubstepInput& input,
                   const Team& team) override {
    const double kept = portable::exp(-m_rate_per_s * input.time_step_s);
    const auto [first, last] = team.share(rows.size());
    for (std::size_t row = first; row < last; ++row) {
      velocities[row] = kept * velocities[row];
    }
  }

 private:
  double m_rate_per_s;
};

std::unique_ptr<Effect> make_damping(const EffectInput& /*input*/, const Parameters& parameters) {
  return std::make_unique<Damping>(parameters.number("rate_per_s"));
}

std::vector<ParameterSpec> damping_parameters() {
  return {parameter::number({.name = "rate_per_s",
                             .unit = "1/s",
                             .default_value = 10,
                             .minimum = 0,
                             .maximum = 1e6,
                             .help = "velocities decay as exp(-rate t)"})};
}

}  // namespace

/// Velocities decay as exp(-rate t), whatever the time step: the exact solution of dv/dt = -rate v over a substep
/// (viscous drag: Witkin 1997, "Particle system dynamics"), where Mueller et al. 2007 ("Position based dynamics",
/// section 3.1) damp velocities.
EffectEntry damping_entry() {
  return {.name = "damping",
          .help = "velocities decay",
          .parameters = damping_parameters(),
          .make = make_damping,
          .inert_at_zero = {"rate_per_s"},
          .colour = "#808080"};
}

}  // namespace musclebench

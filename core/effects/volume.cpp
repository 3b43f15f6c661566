#include "core/effects/volume.hpp"

#include <algorithm>

#include "core/mesh/surface_volume.hpp"

namespace musclebench {

namespace {

class Volume final : public Effect {
 public:
  Volume(const EffectInput& input, const Parameters& parameters)
      : m_triangles(input.muscle.triangles),
        m_gradients(input.muscle.vertices.size()),
        m_target_m3(parameters.number("pressure") * surface_volume_m3(input.muscle.vertices, input.muscle.triangles)),
        m_projection_scale(parameters.number("projection_scale")) {}

  [[nodiscard]] std::string_view name() const override { return "volume"; }

  void project(Particles& particles, const SubstepInput& /*input*/) override {
    const std::vector<Vec3>& predicted = particles.predicted;
    const double volume_m3 = accumulate_gradients(predicted);
    double weighted = 0;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      weighted += particles.inverse_masses[i] * m_gradients[i].squaredNorm();
    }
    if (!(weighted > 0)) {
      return;
    }
    const double multiplier = m_projection_scale * (volume_m3 - m_target_m3) / weighted;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      particles.predicted[i] -= (multiplier * particles.inverse_masses[i]) * m_gradients[i];
    }
  }

 private:
  /// Stores dV/dp in m_gradients; returns V.
  double accumulate_gradients(const std::vector<Vec3>& positions) {
    std::fill(m_gradients.begin(), m_gradients.end(), Vec3::Zero());
    const Vec3& origin = positions.front();
    double six_volumes = 0;
    for (const Triangle& triangle : m_triangles) {
      const Vec3 a = positions[triangle[0]] - origin;
      const Vec3 b = positions[triangle[1]] - origin;
      const Vec3 c = positions[triangle[2]] - origin;
      const Vec3 b_cross_c = b.cross(c);
      m_gradients[triangle[0]] += b_cross_c / 6;
      m_gradients[triangle[1]] += c.cross(a) / 6;
      m_gradients[triangle[2]] += a.cross(b) / 6;
      six_volumes += a.dot(b_cross_c);
    }
    return six_volumes / 6;
  }

  std::vector<Triangle> m_triangles;
  std::vector<Vec3> m_gradients;
  double m_target_m3;
  double m_projection_scale;
};

}  // namespace

std::unique_ptr<Effect> make_volume(const EffectInput& input, const Parameters& parameters) {
  return std::make_unique<Volume>(input, parameters);
}

std::vector<ParameterSpec> volume_parameters() {
  return {parameter::number({.name = "pressure",
                             .default_value = 1,
                             .minimum = 0.01,
                             .maximum = 100,
                             .help = "target volume over rest volume (useful: 0.5 to 2)"}),
          parameter::number({.name = "projection_scale",
                             .default_value = 1,
                             .minimum = 0,
                             .maximum = 1,
                             .help = "part of the full projection that one pass does (the paper's public code: 1/6)"})};
}

}  // namespace musclebench

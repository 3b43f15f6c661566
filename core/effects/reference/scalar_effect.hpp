#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// An effect in plain C++: one constraint after the other, positions as three doubles, the C library's functions. What
/// the effects over SIMD lanes are tested against and raced against; no simulation uses it.
class ScalarEffect {
 public:
  ScalarEffect() = default;
  ScalarEffect(const ScalarEffect&) = delete;
  ScalarEffect& operator=(const ScalarEffect&) = delete;
  virtual ~ScalarEffect() = default;

  /// Multipliers are those of a substep.
  virtual void begin_substep() {}
  virtual void project(std::vector<Vec3>& predicted, const std::vector<double>& inverse_masses,
                       const SubstepInput& input) = 0;
};

/// The effect of that name, with the parameters of its entry in `effect_registry`; nullptr where there is none in
/// scalar form.
std::unique_ptr<ScalarEffect> make_scalar_effect(std::string_view name, const EffectInput& input,
                                                 const Parameters& parameters);

}  // namespace musclebench

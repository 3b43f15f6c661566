#pragma once

#include <memory>
#include <string_view>
#include <utility>

#include "core/pbd/effect.hpp"

namespace musclebench {

/// An effect that projects one set of constraints and does nothing else.
template <typename Constraints>
class ConstraintEffect final : public Effect {
 public:
  ConstraintEffect(std::string_view name, Constraints constraints)
      : m_name(name), m_constraints(std::move(constraints)) {}

  [[nodiscard]] std::string_view name() const override { return m_name; }

  void apply_force(const NodeRows& /*rows*/, std::span<NodeRow> /*velocities*/, const SubstepInput& /*input*/,
                   const Team& team) override {
    m_constraints.begin_substep(team);
  }

  void project(NodeRows& rows, const SubstepInput& input, const Team& team) override {
    m_constraints.project(rows, input.time_step_s, team);
  }

 private:
  std::string_view m_name;
  Constraints m_constraints;
};

/// `name` outlives the effect.
template <typename Constraints>
std::unique_ptr<Effect> make_constraint_effect(std::string_view name, Constraints constraints) {
  return std::make_unique<ConstraintEffect<Constraints>>(name, std::move(constraints));
}

}  // namespace musclebench

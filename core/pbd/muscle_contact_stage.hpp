#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/contact/muscle_contact_rows.hpp"
#include "core/pbd/contact_stage.hpp"

namespace musclebench {

/// Contact between muscles: a detector for each method that the scene's pairs name, and one solver for all contacts.
/// Muscles that overlap at rest separate without being accelerated.
class MuscleContactStage final : public ContactStage {
 public:
  static constexpr std::string_view stage_name = "muscle_contact";

  /// `triangles` of the mesh of all muscles, which outlive this. `steps`: corrections of the contacts of one detection.
  MuscleContactStage(std::vector<std::unique_ptr<MuscleContactDetector>> detectors, std::span<const Triangle> triangles,
                     PairSteps steps, ContactRowSolver solver)
      : m_detectors(std::move(detectors)),
        m_triangles(triangles),
        m_steps(std::move(steps)),
        m_solver(std::move(solver)) {
    for (const auto& detector : m_detectors) {
      const auto times = detector->pair_times();
      m_pair_times.insert(m_pair_times.end(), times.begin(), times.end());
    }
  }

  [[nodiscard]] std::string_view name() const override { return stage_name; }

  std::span<const int> before_bones(const ContactStageInput& input) override {
    m_contacts.clear();
    for (const auto& detector : m_detectors) {
      detector->detect(input.predicted, m_found);
      m_contacts.insert(m_contacts.end(), m_found.begin(), m_found.end());
    }
    add_times();
    rows_of(m_contacts, m_triangles, m_steps, m_rows);
    m_solver.lay_out_slowly(m_rows, input.start, input.predicted, input.depenetration_m);
    m_solver.solve(m_rows, input.start, input.predicted, input.impulses);
    return m_solver.moved_nodes();
  }

  [[nodiscard]] int contact_count() const override { return static_cast<int>(m_contacts.size()); }

  /// Of the last step: a detector after the other.
  [[nodiscard]] std::span<const MuscleContact> contacts() const { return m_contacts; }

  /// Of each pair, a detector after the other: the sum since the last call.
  [[nodiscard]] std::vector<PairTime> take_pair_times() {
    std::vector<PairTime> taken = m_pair_times;
    for (PairTime& time : m_pair_times) time.detect_ns = 0;
    return taken;
  }

 private:
  void add_times() {
    auto sum = m_pair_times.begin();
    for (const auto& detector : m_detectors) {
      for (const PairTime& time : detector->pair_times()) (sum++)->detect_ns += time.detect_ns;
    }
  }

  std::vector<std::unique_ptr<MuscleContactDetector>> m_detectors;
  std::span<const Triangle> m_triangles;
  PairSteps m_steps;
  ContactRowSolver m_solver;
  std::vector<ContactRow> m_rows;
  std::vector<MuscleContact> m_contacts;
  std::vector<MuscleContact> m_found;
  std::vector<PairTime> m_pair_times;
};

}  // namespace musclebench

#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/contact/muscle_contact_response.hpp"
#include "core/pbd/contact_stage.hpp"

namespace musclebench {

/// Muscles against muscles: what detectors find, a detector for each method that the scene's pairs ask for, and one
/// response for all of it.
class MuscleContactStage final : public ContactStage {
 public:
  static constexpr std::string_view stage_name = "muscle_contact";

  MuscleContactStage(std::vector<std::unique_ptr<MuscleContactDetector>> detectors, MuscleContactResponse response)
      : m_detectors(std::move(detectors)), m_response(std::move(response)) {}

  [[nodiscard]] std::string_view name() const override { return stage_name; }

  std::span<const int> collide(const ContactStageInput& input) override {
    m_contacts.clear();
    for (const auto& detector : m_detectors) {
      detector->detect(input.predicted, m_found);
      m_contacts.insert(m_contacts.end(), m_found.begin(), m_found.end());
    }
    m_response.resolve(m_contacts, input.start, input.predicted);
    return m_response.moved_nodes();
  }

  [[nodiscard]] int contact_count() const override { return static_cast<int>(m_contacts.size()); }

  /// Of the last step: a detector after the other.
  [[nodiscard]] std::span<const MuscleContact> contacts() const { return m_contacts; }

 private:
  std::vector<std::unique_ptr<MuscleContactDetector>> m_detectors;
  MuscleContactResponse m_response;
  std::vector<MuscleContact> m_contacts;
  std::vector<MuscleContact> m_found;
};

}  // namespace musclebench

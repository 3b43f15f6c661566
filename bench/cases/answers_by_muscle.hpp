#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "bench/cases/case.hpp"
#include "bench/cases/replay_record.hpp"
#include "core/measure/answer_error.hpp"

namespace musclebench {

/// Contacts and errors with bones, told apart by muscle, of a scene that has several. Pairs are counted bone after
/// bone, each with all muscles.
class AnswersByMuscle {
 public:
  explicit AnswersByMuscle(const Case& resolved);

  /// Gives the record of a frame its muscles and pairs, without contacts.
  void prepare(ReplayRecord& record) const;

  /// Adds a step's contacts, and its times by pair (CollisionBackend::pair_times; empty: not told).
  void add_contacts(std::span<const Contact> contacts, ReplayRecord& record) const;
  static void add_times(std::span<const Nanoseconds> pair_ns, ReplayRecord& record);

  /// What is measured on its own: pairs, or all in one where there is but one muscle.
  [[nodiscard]] std::size_t parts() const { return std::max<std::size_t>(1, m_pairs.size()); }
  /// Adds to the errors of each part how far the answer is from the truth.
  void measure(const Referee& referee, const JudgedAnswer& answer, std::span<const Contact> truth, double band_m,
               std::vector<AnswerErrors>& errors) const;
  /// What the errors of the parts say of pairs, muscles and all, into the record, which is prepared.
  void add_accuracy(std::span<const AnswerErrors> errors, ReplayRecord& record) const;

 private:
  [[nodiscard]] bool are_told() const { return m_bodies.size() > 1; }
  [[nodiscard]] std::size_t pair_of(const Contact& contact) const;
  [[nodiscard]] std::vector<std::vector<Contact>> split(std::span<const Contact> contacts) const;

  std::vector<Body> m_bodies;
  std::vector<PairReplay> m_pairs;  ///< as they are before anything is counted
};

}  // namespace musclebench

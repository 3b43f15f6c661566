#include "bench/cases/answers_by_muscle.hpp"

namespace musclebench {

AnswersByMuscle::AnswersByMuscle(const Case& resolved) : m_bodies(resolved.scene.bodies()) {
  if (!are_told()) return;
  const Scene& scene = resolved.scene;
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    for (std::size_t muscle = 0; muscle < m_bodies.size(); ++muscle) {
      const BackendChoice choice =
          backend_of_pair(scene.bone_pair(muscle, bone), resolved.backend, resolved.parameters, resolved.colliders);
      m_pairs.push_back({m_bodies[muscle].name, scene.bones[bone].name, choice.entry->name});
    }
  }
}

void AnswersByMuscle::prepare(ReplayRecord& record) const {
  if (!are_told()) return;
  record.pairs = m_pairs;
  for (const Body& body : m_bodies) record.muscles.push_back({body.name});
}

void AnswersByMuscle::add_contacts(std::span<const Contact> contacts, ReplayRecord& record) const {
  if (!are_told()) return;
  for (const Contact& contact : contacts) {
    const std::size_t pair = pair_of(contact);
    ++record.pairs[pair].contacts;
    ++record.muscles[pair % m_bodies.size()].contacts;
  }
}

void AnswersByMuscle::add_times(std::span<const Nanoseconds> pair_ns, ReplayRecord& record) {
  for (std::size_t pair = 0; pair < pair_ns.size(); ++pair) {
    std::optional<Nanoseconds>& sum_ns = record.pairs[pair].detect_ns;
    sum_ns = sum_ns.value_or(0) + pair_ns[pair];
  }
}

void AnswersByMuscle::measure(const Referee& referee, const JudgedAnswer& answer, std::span<const Contact> truth,
                              double band_m, std::vector<AnswerErrors>& errors) const {
  if (!are_told()) {
    measure_answer(referee, answer, truth, band_m, errors[0]);
    return;
  }
  const std::vector<std::vector<Contact>> answered = split(answer.contacts);
  const std::vector<std::vector<Contact>> true_ones = split(truth);
  for (std::size_t pair = 0; pair < errors.size(); ++pair) {
    measure_answer(referee, {answer.bone_poses, answer.positions, answered[pair], answer.depths_known}, true_ones[pair],
                   band_m, errors[pair]);
  }
}

void AnswersByMuscle::add_accuracy(std::span<const AnswerErrors> errors, ReplayRecord& record) const {
  std::vector<AnswerErrors> of_muscles(record.muscles.size());
  for (std::size_t pair = 0; pair < record.pairs.size(); ++pair) {
    record.pairs[pair].accuracy = accuracy_of(errors[pair]);
    of_muscles[pair % of_muscles.size()].add(errors[pair]);
  }
  for (std::size_t i = 0; i < of_muscles.size(); ++i) record.muscles[i].accuracy = accuracy_of(of_muscles[i]);
  AnswerErrors of_all;
  for (const AnswerErrors& each : errors) of_all.add(each);
  record.accuracy = accuracy_of(of_all);
}

std::size_t AnswersByMuscle::pair_of(const Contact& contact) const {
  return static_cast<std::size_t>(contact.bone) * m_bodies.size() + body_of(m_bodies, contact.node);
}

std::vector<std::vector<Contact>> AnswersByMuscle::split(std::span<const Contact> contacts) const {
  std::vector<std::vector<Contact>> by_pair(m_pairs.size());
  for (const Contact& contact : contacts) by_pair[pair_of(contact)].push_back(contact);
  return by_pair;
}

}  // namespace musclebench

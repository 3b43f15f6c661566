#include "core/measure/answer_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace musclebench {

namespace {

constexpr double degrees_per_radian = 180 / std::numbers::pi;

std::pair<int, int> key_of(const Contact& contact) { return {contact.bone, contact.node}; }

void add_normal_error(const Contact& contact, const Vec3& true_normal, AnswerErrors& errors) {
  if (!contact.normal.isZero(0) && !true_normal.isZero(0)) {
    const double angle_rad = std::atan2(contact.normal.cross(true_normal).norm(), contact.normal.dot(true_normal));
    errors.normal_errors_deg.push_back(angle_rad * degrees_per_radian);
  }
}

/// A contact that both see.
void add_answered(bool depths_known, const Contact& contact, const Contact& real, double band_m, AnswerErrors& errors) {
  if (!(real.depth_m <= band_m)) return;
  if (depths_known) errors.depth_errors_m.push_back(std::abs(contact.depth_m - real.depth_m));
  add_normal_error(contact, real.normal, errors);
}

void add_false(const SurfaceDistance& surface, AnswerErrors& errors) {
  ++errors.false_contacts;
  errors.max_false_distance_m = std::max(errors.max_false_distance_m, surface.signed_distance_m);
}

void add_missed(const Contact& real, AnswerErrors& errors) {
  ++errors.missed_contacts;
  errors.max_missed_depth_m = std::max(errors.max_missed_depth_m, real.depth_m);
}

void append(const std::vector<double>& from, std::vector<double>& to) { to.insert(to.end(), from.begin(), from.end()); }

}  // namespace

void AnswerErrors::add(const AnswerErrors& other) {
  contacts += other.contacts;
  true_contacts += other.true_contacts;
  missed_contacts += other.missed_contacts;
  false_contacts += other.false_contacts;
  max_missed_depth_m = std::max(max_missed_depth_m, other.max_missed_depth_m);
  max_false_distance_m = std::max(max_false_distance_m, other.max_false_distance_m);
  append(other.depth_errors_m, depth_errors_m);
  append(other.normal_errors_deg, normal_errors_deg);
}

void measure_answer(const TrueSurface& surface_at, std::span<const Contact> answered, bool depths_known,
                    std::span<const Contact> truth, double band_m, AnswerErrors& errors) {
  errors.contacts += static_cast<long>(answered.size());
  errors.true_contacts += static_cast<long>(truth.size());
  auto real = truth.begin();
  for (const Contact& contact : answered) {
    for (; real != truth.end() && key_of(*real) < key_of(contact); ++real) {
      add_missed(*real, errors);
    }
    if (real != truth.end() && key_of(*real) == key_of(contact)) {
      add_answered(depths_known, contact, *real, band_m, errors);
      ++real;
    } else {
      add_false(surface_at(contact), errors);
    }
  }
  for (; real != truth.end(); ++real) {
    add_missed(*real, errors);
  }
}

void measure_answer(const Referee& referee, const JudgedAnswer& answer, std::span<const Contact> truth, double band_m,
                    AnswerErrors& errors) {
  const auto surface_at = [&](const Contact& contact) {
    const RigidMotion& pose = answer.bone_poses[contact.bone];
    SurfaceDistance surface = referee.closest(contact.bone, pose.apply_inverse(answer.positions[contact.node]));
    surface.normal = pose.apply_to_direction(surface.normal);
    return surface;
  };
  measure_answer(surface_at, answer.contacts, answer.depths_known, truth, band_m, errors);
}

}  // namespace musclebench

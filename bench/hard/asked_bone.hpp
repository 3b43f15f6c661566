#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/hard/hard_case.hpp"
#include "core/base/input_error.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

/// Why the backend can't be asked about points; nothing: it can.
std::optional<std::string> why_not_points(const HardRequest& request);

/// One bone with a backend built over it, which is asked about points that belong to no surface.
class AskedBone {
 public:
  /// `points`: how many are asked about at a time. Throws InputError where the mesh or the parameters are refused.
  AskedBone(const HardRequest& request, const TriangleMesh& mesh, std::size_t points,
            const std::map<std::string, ParameterValue>& more = {});

  /// `points` in the bone's rest frame, as many as said; they and the bone are moved by `pose`.
  [[nodiscard]] std::vector<Contact> contacts(std::span<const Vec3> points, const RigidMotion& pose = {});
  /// Of each point its depth, or 1 where the backend tells none; 0 for one that is in no contact.
  [[nodiscard]] std::vector<double> depths(std::span<const Vec3> points, const RigidMotion& pose = {});

  [[nodiscard]] const TriangleMesh& mesh() const { return m_bones.front().surface.mesh; }
  [[nodiscard]] double diagonal_m() const;
  [[nodiscard]] AnswerBound bound() const { return m_backend->answer_bound(0); }
  [[nodiscard]] bool tells_depth() const { return m_backend->capabilities().depth; }

 private:
  void write_wrong(std::span<const Vec3> points, const std::vector<Contact>& contacts) const;

  std::string m_backend_name;
  std::string m_wrong_prefix;
  std::vector<Bone> m_bones;
  TriangleMesh m_muscle;
  std::vector<int> m_nodes;
  std::unique_ptr<CollisionBackend> m_backend;
};

/// The Referee's signed distance of each point to the mesh as a bone, in metres, negative inside.
std::vector<double> true_distances(const TriangleMesh& mesh, std::span<const Vec3> points);

/// How answers differ from the truth by more than the backend declares, and `slack_m` besides.
struct WrongAnswers {
  int inside = 0;  ///< points that are, by the truth
  int missed = 0;  ///< of those deeper than the declared bound
  int invented = 0;
  double largest_depth_error_m = 0;  ///< of points found that are inside, where depths are told
};

WrongAnswers wrong_answers(std::span<const double> truth_m, const std::vector<Contact>& contacts,
                           const AskedBone& asked, double slack_m);

/// The cell, which also says with which parameters a backend was asked that needs some for points.
HardCell with_parameters_for_points(HardCell cell, const HardRequest& request);

/// Of points that the case has only compared with each other: those of them inside that the backend does not find.
HardFigure missed_figure(std::span<const double> truth_m, const std::vector<Contact>& contacts, const AskedBone& asked);

/// What `ask` says, where the backend can be asked about points; a structure that was refused by the status given.
template <typename Ask>
HardCell about_points(const HardRequest& request, const Ask& ask) {
  if (const std::optional<std::string> why = why_not_points(request)) return not_applicable(*why);
  try {
    return with_parameters_for_points(ask(), request);
  } catch (const InputError& refused) {
    return with_parameters_for_points({request.backend.exact ? Verdict::breaks : Verdict::refused, refused.what(), {}},
                                      request);
  }
}

}  // namespace musclebench

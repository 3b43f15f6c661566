#include "bench/hard/asked_bone.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "bench/cases/verification.hpp"
#include "bench/queries/make_queries.hpp"
#include "bench/queries/query_set_file.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

std::optional<std::string> why_not_points(const HardRequest& request) {
  const Capabilities can = request.backend.make(request.parameters_for_points())->capabilities();
  if (!can.finds_contacts) return "finds no contacts";
  if (!can.point_queries) return "collides surfaces, and is asked about points here";
  return std::nullopt;
}

HardFigure missed_figure(std::span<const double> truth_m, const std::vector<Contact>& contacts,
                         const AskedBone& asked) {
  const WrongAnswers wrong = wrong_answers(truth_m, contacts, asked, 1e-12 * asked.diagonal_m());
  return {"inner points missed beyond its declared bound", static_cast<double>(wrong.missed), 0, "points"};
}

HardCell with_parameters_for_points(HardCell cell, const HardRequest& request) {
  std::string said;
  for (const auto& [name, value] : request.backend.for_points) {
    if (!request.given.contains(name))
      said += fmt::format("{}{} = {}", said.empty() ? "asked with " : ", ", name, format_parameter_value(value));
  }
  if (said.empty() || cell.verdict == Verdict::not_applicable) return cell;
  cell.detail = cell.detail.empty() ? said : said + "; " + cell.detail;
  return cell;
}

AskedBone::AskedBone(const HardRequest& request, const TriangleMesh& mesh, std::size_t points,
                     const std::map<std::string, ParameterValue>& more)
    : m_backend_name(request.backend.name),
      m_wrong_prefix(request.wrong_prefix),
      m_nodes(points),
      m_backend(request.backend.make(request.parameters_for_points(more))) {
  m_bones.push_back({"bone", repair_mesh(mesh, "bone")});
  m_muscle.vertices.assign(points, Vec3::Zero());
  std::iota(m_nodes.begin(), m_nodes.end(), 0);
  m_backend->build(m_bones, m_muscle, request.threads);
}

std::vector<Contact> AskedBone::contacts(std::span<const Vec3> points, const RigidMotion& pose) {
  std::vector<Vec3> positions;
  positions.reserve(points.size());
  for (const Vec3& point : points) positions.push_back(pose.apply(point));
  std::vector<Contact> found;
  m_backend->update(std::array{pose}, positions);
  m_backend->detect(positions, m_nodes, found);
  // A file has the bone at rest; what a pose rounds would be no fault of the library.
  if (!m_wrong_prefix.empty() && std::ranges::equal(points, positions)) write_wrong(points, found);
  return found;
}

void AskedBone::write_wrong(std::span<const Vec3> points, const std::vector<Contact>& contacts) const {
  constexpr std::size_t most_points = 20;
  const QuerySet asked = queries_about(m_bones.front(), points);
  std::vector<char> is_found(points.size(), 0);
  for (const Contact& contact : contacts) is_found[static_cast<std::size_t>(contact.node)] = 1;
  const double slack_m = agreed_difference_m(mesh());
  std::vector<std::pair<double, std::size_t>> wrong;  // by how far beyond what the backend declares
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double truth_m = asked.distances_m[i];
    const double beyond_m = is_found[i] != 0 ? truth_m - bound().false_distance_m : -truth_m - bound().missed_depth_m;
    if (beyond_m > slack_m) wrong.emplace_back(-beyond_m, i);
  }
  if (wrong.empty()) return;
  std::sort(wrong.begin(), wrong.end());
  std::vector<Vec3> worst;
  for (std::size_t i = 0; i < std::min(wrong.size(), most_points); ++i) worst.push_back(points[wrong[i].second]);
  QuerySet set = queries_about(m_bones.front(), worst);
  set.about =
      fmt::format("points on whose side {} is wrong by more than it declares, {} of {} asked, the worst first; m",
                  m_backend_name, wrong.size(), points.size());
  int number = 1;
  const auto path = [&] { return fmt::format("{}-{}.queries", m_wrong_prefix, number); };
  while (std::filesystem::exists(path())) ++number;
  write_query_set(path(), set);
}

std::vector<double> AskedBone::depths(std::span<const Vec3> points, const RigidMotion& pose) {
  std::vector<double> depths_m(points.size(), 0);
  for (const Contact& contact : contacts(points, pose)) {
    depths_m[static_cast<std::size_t>(contact.node)] = tells_depth() ? contact.depth_m : 1;
  }
  return depths_m;
}

double AskedBone::diagonal_m() const { return bounding_box(mesh().vertices).diagonal().norm(); }

std::vector<double> true_distances(const TriangleMesh& mesh, std::span<const Vec3> points) {
  const std::vector<Bone> bones = {{"bone", repair_mesh(mesh, "bone")}};
  const Referee referee(bones, 1);
  std::vector<double> distances_m;
  distances_m.reserve(points.size());
  for (const Vec3& point : points) distances_m.push_back(referee.signed_distance(0, point));
  return distances_m;
}

WrongAnswers wrong_answers(std::span<const double> truth_m, const std::vector<Contact>& contacts,
                           const AskedBone& asked, double slack_m) {
  const AnswerBound bound = asked.bound();
  std::vector<char> is_found(truth_m.size(), 0);
  WrongAnswers wrong;
  for (const Contact& contact : contacts) {
    const auto point = static_cast<std::size_t>(contact.node);
    is_found[point] = 1;
    if (truth_m[point] > bound.false_distance_m + slack_m) ++wrong.invented;
    if (truth_m[point] < 0 && asked.tells_depth()) {
      wrong.largest_depth_error_m = std::max(wrong.largest_depth_error_m, std::abs(contact.depth_m + truth_m[point]));
    }
  }
  for (std::size_t point = 0; point < truth_m.size(); ++point) {
    if (truth_m[point] < 0) ++wrong.inside;
    if (truth_m[point] < -bound.missed_depth_m - slack_m && is_found[point] == 0) ++wrong.missed;
  }
  return wrong;
}

}  // namespace musclebench

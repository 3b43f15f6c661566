#include "bench/queries/check_queries.hpp"

#include <algorithm>
#include <cmath>

#include "backends/registry.hpp"
#include "bench/cases/verification.hpp"
#include "core/base/percentile.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh_repair/repair_mesh.hpp"

namespace musclebench {

namespace {

constexpr std::size_t asked_of_slow_backends = 2000;

Vec3 vector_at(const std::vector<double>& values, std::size_t i) { return Eigen::Map<const Vec3>(&values[3 * i]); }

Bone bone_of(const QuerySet::Bone& bone) {
  Bone copy{bone.name, {}};
  for (std::size_t i = 0; 3 * i < bone.vertices_m.size(); ++i) {
    copy.surface.mesh.vertices.push_back(vector_at(bone.vertices_m, i));
  }
  for (std::size_t i = 0; i < bone.triangles.size(); i += 3) {
    copy.surface.mesh.triangles.push_back({bone.triangles[i], bone.triangles[i + 1], bone.triangles[i + 2]});
  }
  return copy;
}

}  // namespace

QueryErrors compare_answers(const QuerySet& set, const std::vector<double>& answers,
                            const std::function<bool(std::size_t)>& counts) {
  std::vector<double> unclear_m;  // nearer to the surface than this the side may be either
  for (const QuerySet::Bone& bone : set.bones) {
    const TriangleMesh mesh = bone_of(bone).surface.mesh;
    unclear_m.push_back(std::max(touching_distance_m(mesh), agreed_difference_m(mesh)));
  }
  QueryErrors found;
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!counts(i)) continue;
    ++found.queries;
    const double truth_m = set.distances_m[i];
    if (!std::isfinite(answers[i])) {
      ++found.unanswered;
      continue;
    }
    errors_m.push_back(std::abs(answers[i] - truth_m));
    const bool is_clear = std::abs(truth_m) > unclear_m[static_cast<std::size_t>(set.bone[i])];
    if (is_clear && (answers[i] < 0) != (truth_m < 0)) ++found.wrong_sides;
  }
  if (errors_m.empty()) return found;
  found.largest_m = *std::max_element(errors_m.begin(), errors_m.end());
  found.p99_m = percentile(std::move(errors_m), 0.99);
  return found;
}

std::vector<QuerySetCheck> check_query_set(const QuerySet& set) {
  std::vector<Bone> bones;
  double agreed_m = 0;
  for (const QuerySet::Bone& bone : set.bones) {
    bones.push_back(bone_of(bone));
    agreed_m = std::max(agreed_m, agreed_difference_m(bones.back().surface.mesh));
  }
  std::vector<QuerySetCheck> checks;
  for (const BackendEntry& backend : backend_registry()) {
    if (!backend.signed_distance) continue;
    const auto is_clean_bone = [](const Bone& bone) { return is_clean(bone.surface.mesh); };
    if (!backend.exact && !std::ranges::all_of(bones, is_clean_bone)) continue;
    std::vector<SignedDistance> distances;
    for (const Bone& bone : bones) distances.push_back(backend.signed_distance(bone, 1));
    const bool is_slow = &backend != &exact_backend();
    const std::size_t stride = is_slow ? set.bone.size() / asked_of_slow_backends + 1 : 1;
    std::vector<double> answers(set.bone.size());
    for (std::size_t i = 0; i < answers.size(); i += stride) {
      answers[i] = distances[static_cast<std::size_t>(set.bone[i])](vector_at(set.points_m, i));
    }
    checks.push_back(
        {backend.name, compare_answers(set, answers, [&](std::size_t i) { return i % stride == 0; }), agreed_m});
  }
  return checks;
}

double largest_gap_m(const QuerySet& set) {
  double largest_m = 0;
  for (std::size_t i = 0; i < set.bone.size(); ++i) {
    const double distance_m = (vector_at(set.points_m, i) - vector_at(set.closest_m, i)).norm();
    const double gap_m = std::abs(distance_m - std::abs(set.distances_m[i]));
    if (!(gap_m <= largest_m)) largest_m = gap_m;  // NaN is the largest
  }
  return largest_m;
}

}  // namespace musclebench

#include "bench/hard/sane_figures.hpp"

#include <algorithm>
#include <cmath>

#include "core/measure/crossings.hpp"
#include "core/mesh/surface_volume.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

namespace {

/// Of the muscle's diagonal: surfaces that are this close touch.
constexpr double touching_share = 1e-6;
constexpr const char* status_figure = "runs that end with another status than ok";

/// The muscle with each node moved by `distance_m` against its normal.
std::vector<Vec3> drawn_in(const TriangleMesh& muscle, std::vector<Vec3> positions, double distance_m) {
  const double side = surface_volume_m3(positions, muscle.triangles) < 0 ? -1 : 1;
  std::vector<Vec3> normals(positions.size(), Vec3::Zero());
  for (const auto& [a, b, c] : muscle.triangles) {
    const Vec3& corner = positions[static_cast<std::size_t>(a)];
    const Vec3 normal =
        (positions[static_cast<std::size_t>(b)] - corner).cross(positions[static_cast<std::size_t>(c)] - corner);
    for (const int node : {a, b, c}) normals[static_cast<std::size_t>(node)] += normal;
  }
  for (std::size_t node = 0; node < positions.size(); ++node) {
    positions[node] -= side * distance_m * normals[node].stableNormalized();
  }
  return positions;
}

/// Counts crossings of the shapes that a run has kept.
class KeptCrossings {
 public:
  explicit KeptCrossings(const MovedScene& run)
      : m_run(run),
        m_referee(run.scene.bones, static_cast<int>(run.scene.muscle_mesh.vertices.size())),
        m_tree(run.scene.muscle_mesh),
        m_bodies(run.scene.bodies()),
        m_meter(run.scene.bones, run.scene.muscle_mesh, m_bodies, carriers_of(run)) {}

  PassingTriangles count(const Snapshot& shape, double declared_m) {
    const double touching_m = touching_share * m_run.diagonal_m();
    const CrossingSums as_it_is = sums(shape, shape.positions);
    const CrossingSums smaller = sums(shape, drawn_in(m_run.scene.muscle_mesh, shape.positions, touching_m));
    const CrossingSums lifted =
        as_it_is.in_bones > 0 ? sums(shape, lifted_out(shape, std::max(touching_m, declared_m), touching_m)) : as_it_is;
    return {lifted.in_bones, std::min(as_it_is.in_muscles.value_or(0), smaller.in_muscles.value_or(0)),
            std::min(as_it_is.in_itself, smaller.in_itself)};
  }

 private:
  CrossingSums sums(const Snapshot& shape, const std::vector<Vec3>& positions) {
    m_tree.refit(m_run.scene.muscle_mesh.triangles, positions);
    return sums_of(m_meter.pairs(), m_meter.count(m_referee, m_tree, shape.bone_poses, positions));
  }

  /// The nodes, those within `reach_m` of a bone's surface `clear_m` outside of it.
  [[nodiscard]] std::vector<Vec3> lifted_out(const Snapshot& shape, double reach_m, double clear_m) const {
    std::vector<Vec3> positions = shape.positions;
    constexpr int passes = 3;  // out of a corner face by face
    for (int pass = 0; pass < passes; ++pass) {
      for (std::size_t bone = 0; bone < shape.bone_poses.size(); ++bone) {
        const RigidMotion& pose = shape.bone_poses[bone];
        const RefereeTree& tree = m_referee.tree(static_cast<int>(bone));
        for (Vec3& position : positions) {
          const Vec3 at_rest = pose.apply_inverse(position);
          if (tree.box_distance(at_rest - tree.centre_m()) > clear_m) continue;
          const SurfaceDistance near = m_referee.closest(static_cast<int>(bone), at_rest);
          if (near.signed_distance_m < -reach_m || near.signed_distance_m >= 0.5 * clear_m) continue;
          position = pose.apply(near.closest_point_m + clear_m * near.normal);
        }
      }
    }
    return positions;
  }

  static std::vector<int> carriers_of(const MovedScene& run) {
    std::vector<int> carriers(run.scene.muscle_mesh.vertices.size(), -1);
    for (const BoundNode& bound : run.result.bound_nodes) carriers[static_cast<std::size_t>(bound.node)] = bound.bone;
    return carriers;
  }

  const MovedScene& m_run;
  Referee m_referee;
  RefereeTree m_tree;
  std::vector<Body> m_bodies;
  CrossingMeter m_meter;
};

/// Whether the judge found that nothing passes after that frame, nor touches.
bool is_free(const std::vector<StepRecord>& records, int frame) {
  const auto record = std::ranges::find(records, frame, &StepRecord::frame);
  return record != records.end() && !record->crossings.empty() &&
         std::ranges::all_of(record->crossings, [](int triangles) { return triangles == 0; });
}

}  // namespace

PassingTriangles passing_triangles(const MovedScene& run, double declared_m) {
  PassingTriangles most;
  const std::vector<Snapshot>& shapes = run.result.snapshots;
  if (shapes.empty() || run.scene.muscle_mesh.triangles.empty()) return most;
  KeptCrossings crossings(run);
  const PassingTriangles at_rest = crossings.count(shapes.front(), declared_m);
  for (const Snapshot& shape : shapes) {
    if (shape.frame == 0 || is_free(run.result.records, shape.frame)) continue;
    const PassingTriangles now = crossings.count(shape, declared_m);
    most.bones = std::max(most.bones, now.bones - at_rest.bones);
    most.muscles = std::max(most.muscles, now.muscles - at_rest.muscles);
    most.itself = std::max(most.itself, now.itself - at_rest.itself);
  }
  return most;
}

std::vector<HardFigure> sane_figures(const MovedScene& run, const HardRequest& request, const std::string& words,
                                     const SaneBars& bars) {
  const std::string of_run = words.empty() ? "" : words + ": ";
  const double lost = std::nan("");
  const double declared = declared_m(run, request);
  const double deepest_m = std::max(bars.depth_m, bars.depth_share * run.diagonal_m()) + declared;
  const Outcome& outcome = run.result.outcome;
  std::vector<HardFigure> figures;
  if (bars.passing) {
    const PassingTriangles passing = passing_triangles(run, request.backend.exact ? 0 : declared);
    const auto add = [&](const char* through, int triangles) {
      figures.push_back({of_run + "triangles through " + through, static_cast<double>(triangles), 0, "triangles"});
    };
    add("bones", passing.bones);
    add("the muscle itself", passing.itself);
    if (run.scene.muscles.size() > 1) add("other muscles", passing.muscles);
  }
  figures.push_back({of_run + "nodes on the wrong side of a bone", run.tunnelled_nodes(), 0, "nodes"});
  if (std::isfinite(bars.depth_m)) {
    figures.push_back({of_run + "depth of the surface in bones", 1e3 * outcome.max_surface_depth_m.value_or(lost),
                       1e3 * deepest_m, "mm"});
  }
  figures.push_back({of_run + "volume error", outcome.max_volume_error.value_or(lost), bars.volume_error});
  figures.push_back(
      {of_run + "longest edge over its length at rest", outcome.max_edge_stretch.value_or(lost), bars.edge_stretch});
  if (bars.status) figures.push_back({of_run + status_figure, run.said().empty() ? 0.0 : 1.0, 0});
  return figures;
}

std::vector<HardFigure> with_sane_figures(std::vector<HardFigure> figures, const MovedScene& run,
                                          const HardRequest& request, const std::string& words, const SaneBars& bars) {
  for (HardFigure& figure : sane_figures(run, request, words, bars)) figures.push_back(std::move(figure));
  return figures;
}

}  // namespace musclebench

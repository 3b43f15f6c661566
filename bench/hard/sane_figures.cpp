#include "bench/hard/sane_figures.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

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

  /// As the shape is; touching counts.
  PassingTriangles touching(const Snapshot& shape) { return sums(shape, shape.positions); }

  /// From now on what touches in this shape excuses triangles there, and nowhere else (CrossingMeter::beyond_rest).
  void take_as_rest(const Snapshot& shape) {
    touching(shape);
    m_meter.take_as_rest();
    m_has_rest = true;
  }

  /// Of `touching`, those that pass, beyond rest; only where there are more than `known`, of each kind.
  PassingTriangles passing(const Snapshot& shape, const PassingTriangles& touching, const PassingTriangles& known,
                           double declared_m) {
    const double touching_m = touching_share * m_run.diagonal_m();
    PassingTriangles found = touching;
    if (touching.bones > known.bones) {
      const auto positions = lifted_out(shape, std::max(touching_m, declared_m), touching_m);
      found.bones = std::min(touching.bones, sums(shape, positions).bones);
    }
    if (touching.muscles > known.muscles || touching.itself > known.itself) {
      const auto positions = drawn_in(m_run.scene.muscle_mesh, shape.positions, touching_m);
      const PassingTriangles smaller = sums(shape, positions);
      found.muscles = std::min(touching.muscles, smaller.muscles);
      found.itself = std::min(touching.itself, smaller.itself);
    }
    return found;
  }

 private:
  PassingTriangles sums(const Snapshot& shape, const std::vector<Vec3>& positions) {
    m_tree.refit(m_run.scene.muscle_mesh.triangles, positions);
    std::vector<int> counts = m_meter.count(m_referee, m_tree, shape.bone_poses, positions);
    if (m_has_rest) counts = m_meter.beyond_rest();
    const CrossingSums sums = sums_of(m_meter.pairs(), counts);
    return {sums.in_bones, sums.in_muscles.value_or(0), sums.in_itself};
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
  bool m_has_rest = false;
};

/// By frame, what the judge has counted, in which what only touches counts, too.
std::vector<PassingTriangles> touching_triangles(const MovedScene& run, KeptCrossings& crossings) {
  std::vector<PassingTriangles> touching{crossings.touching(run.result.snapshots.front())};
  for (std::size_t i = 1; i < run.result.snapshots.size(); ++i) {
    const StepRecord& record = run.result.records.at(i - 1);
    // The judge counts as often as its budget allows.
    if (!record.bone_crossings) {
      touching.push_back(crossings.touching(run.result.snapshots[i]));
      continue;
    }
    touching.push_back(
        {*record.bone_crossings, record.muscle_crossings.value_or(0), record.self_intersecting_triangles.value_or(0)});
  }
  return touching;
}

}  // namespace

PassingTriangles passing_triangles(const MovedScene& run, double declared_m) {
  const std::vector<Snapshot>& shapes = run.result.snapshots;
  if (shapes.empty() || run.scene.muscle_mesh.triangles.empty()) return {};
  KeptCrossings crossings(run);
  const std::vector<PassingTriangles> touching = touching_triangles(run, crossings);
  crossings.take_as_rest(shapes.front());
  PassingTriangles largest;
  std::vector<std::size_t> order(shapes.size());  // most first, which spares the others
  std::iota(order.begin(), order.end(), 0);
  const auto sum = [&](std::size_t i) { return touching[i].bones + touching[i].muscles + touching[i].itself; };
  std::ranges::stable_sort(order, std::greater(), sum);
  for (const std::size_t i : order) {
    const PassingTriangles now = crossings.passing(shapes[i], touching[i], largest, declared_m);
    largest.bones = std::max(largest.bones, now.bones);
    largest.muscles = std::max(largest.muscles, now.muscles);
    largest.itself = std::max(largest.itself, now.itself);
  }
  return largest;
}

std::vector<HardFigure> sane_figures(const MovedScene& run, const HardRequest& request, const std::string& words,
                                     const SaneBars& bars) {
  const std::string of_run = words.empty() ? "" : words + ": ";
  const double lost = std::nan("");
  const double declared = declared_missed_m(run, request);
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

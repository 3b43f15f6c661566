#include "bench/cases/fibre_watch.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/base/percentile.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

constexpr int segments = 16;
/// Of the fibres that are asked for: those that lose their way in a thin rim are missed by no figure.
constexpr double most_lost = 0.05;

/// Of a muscle's diagonal: measured fibres end at bones, a little outside a surface that was drawn apart from them.
constexpr double most_outside = 0.1;

void require_guides_inside(const Scene& scene, const Muscle& muscle, const SignedSurface& surface) {
  if (muscle.fibres.empty()) return;
  std::vector<double> distances_m;
  for (const FibreSegment& guide : muscle.fibres) {
    distances_m.push_back(surface.locate(0.5 * (guide.start + guide.end)).signed_distance_m());
  }
  const double usual_m = median(distances_m);
  const double largest_m = most_outside * bounding_box(scene.vertices_of(muscle.body)).diagonal().norm();
  if (usual_m <= largest_m) return;
  throw InputError(
      fmt::format("{}: muscle '{}', fibres", scene.file, muscle.body.name),
      fmt::format("leave the surface: half of them lie {:.3g} mm outside or more; check their file, its unit "
                  "and the name after '#'",
                  1e3 * usual_m));
}

FibrePaths paths_of(const Scene& scene, std::size_t index, const std::vector<BoundNode>& bound) {
  const Muscle& muscle = scene.muscles[index];
  const std::string location = fmt::format("{}: muscle '{}'", scene.file, muscle.body.name);
  const TriangleMesh mesh = scene.mesh_of(muscle.body);
  const SignedSurface surface(RepairedMesh{mesh, false, {}});
  const EndNodes ends = scene.end_nodes(index, bound);
  if (ends.origin.empty() || ends.insertion.empty()) {
    throw InputError(location, "is not bound to two bones, between which fibres could run; see its attachments");
  }
  require_guides_inside(scene, muscle, surface);
  const FibreAreas areas = fibre_areas(mesh, ends.origin, ends.insertion);
  const VolumePotential potential(mesh, surface, areas, muscle.fibres);
  FibrePaths paths = trace_fibres(potential, mesh, surface, areas, scene.fibre_count, segments);
  if (paths.fibres.empty() || paths.lost > most_lost * scene.fibre_count) {
    throw InputError(location,
                     fmt::format("{} of {} fibres end away from its attachments: no path inside its surface leads from "
                                 "one to the other; check with `musclebench check` that it is one "
                                 "closed piece and that both attachments hold nodes",
                                 paths.lost, scene.fibre_count));
  }
  return paths;
}

}  // namespace

FibreWatch::FibreWatch(const Scene& scene, const std::vector<BoundNode>& bound, int threads)
    : m_bodies(scene.bodies()) {
  for (std::size_t i = 0; i < scene.muscles.size(); ++i) {
    const FibrePaths paths = paths_of(scene, i, bound);
    m_fibres.emplace_back(scene.mesh_of(m_bodies[i]), paths, scene.muscles[i].body.name, threads);
    m_followed.push_back({m_bodies[i].name, scene.fibre_count, static_cast<int>(paths.fibres.size())});
  }
}

std::vector<std::vector<Vec3>> FibreWatch::points(std::span<const Vec3> positions) const {
  std::vector<std::vector<Vec3>> points;
  for (std::size_t i = 0; i < m_bodies.size(); ++i) {
    const auto first = static_cast<std::size_t>(m_bodies[i].first_node);
    points.push_back(
        m_fibres[i].points(positions.subspan(first, static_cast<std::size_t>(m_bodies[i].last_node) - first)));
  }
  return points;
}

FibreFrame FibreWatch::frame(int number, double angle_rad, std::span<const std::vector<Vec3>> points) const {
  FibreFrame frame{number, angle_rad, {}};
  for (std::size_t i = 0; i < m_fibres.size(); ++i) frame.muscles.push_back({m_fibres[i].lengths(points[i]), {}});
  return frame;
}

std::size_t FibreWatch::points_per_fibre() const { return m_fibres.front().points_per_fibre(); }

std::size_t FibreWatch::bytes() const {
  std::size_t bytes = 0;
  for (const MuscleFibres& fibres : m_fibres) bytes += fibres.bytes();
  return bytes;
}

}  // namespace musclebench

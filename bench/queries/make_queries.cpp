#include "bench/queries/make_queries.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "bench/cases/verification.hpp"
#include "bench/queries/query_set_file.hpp"
#include "core/base/input_error.hpp"
#include "core/measure/contact_sites.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

namespace {

void add_vector(std::vector<double>& values, const Vec3& vector) {
  values.insert(values.end(), vector.data(), vector.data() + 3);
}

/// Queries within the band, with all that classify_sites needs.
struct FoundQueries {
  std::vector<ContactSite> sites;  ///< `surface_point_m` is the closest point
  std::vector<Vec3> points_m;
  std::vector<double> distances_m;
  std::vector<int> steps;

  /// Keeps the queries of every `stride`-th free node.
  void thin_out(std::span<const int> free_nodes, std::size_t stride) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < sites.size(); ++i) {
      const auto rank = std::lower_bound(free_nodes.begin(), free_nodes.end(), sites[i].node) - free_nodes.begin();
      if (static_cast<std::size_t>(rank) % stride != 0) continue;
      sites[kept] = sites[i];
      points_m[kept] = points_m[i];
      distances_m[kept] = distances_m[i];
      steps[kept] = steps[i];
      ++kept;
    }
    sites.resize(kept);
    points_m.resize(kept);
    distances_m.resize(kept);
    steps.resize(kept);
  }
};

/// The bone's box, which tells without a search that a node is far.
void find_within_band(const Referee& referee, const std::vector<Eigen::AlignedBox3d>& boxes, const RecordedStep& step,
                      int step_number, std::span<const int> nodes, double band_m, FoundQueries& found) {
  for (int bone = 0; bone < static_cast<int>(boxes.size()); ++bone) {
    const RigidMotion& pose = step.bone_poses[static_cast<std::size_t>(bone)];
    for (const int node : nodes) {
      const Vec3 point = pose.apply_inverse(step.positions[static_cast<std::size_t>(node)]);
      if (!point.allFinite() || boxes[static_cast<std::size_t>(bone)].exteriorDistance(point) > band_m) continue;
      const SurfaceDistance answer = referee.closest(bone, point);
      if (std::abs(answer.signed_distance_m) > band_m) continue;
      found.sites.push_back({bone, 0, node, answer.closest_point_m, answer.normal});
      found.points_m.push_back(point);
      found.distances_m.push_back(answer.signed_distance_m);
      found.steps.push_back(step_number);
    }
  }
}

/// Points that no node was at.
void add_points(const Referee& referee, std::size_t bone, std::span<const Vec3> points, QuerySet& set) {
  const auto index = static_cast<std::int32_t>(bone);
  for (const Vec3& point : points) {
    const SurfaceDistance answer = referee.closest(index, point);
    add_vector(set.points_m, point);
    add_vector(set.closest_m, answer.closest_point_m);
    set.distances_m.push_back(answer.signed_distance_m);
    set.bone.push_back(index);
    set.node.push_back(-1);
    set.step.push_back(-1);
    set.difficulty.push_back(around_the_bone);
  }
}

QuerySet::Bone bone_of(const Bone& bone) {
  QuerySet::Bone copy{bone.name, {}, {}};
  std::replace(copy.name.begin(), copy.name.end(), ' ', '_');  // the head has words
  for (const Vec3& vertex : bone.surface.mesh.vertices) add_vector(copy.vertices_m, vertex);
  for (const Triangle& corners : bone.surface.mesh.triangles) {
    copy.triangles.insert(copy.triangles.end(), corners.begin(), corners.end());
  }
  return copy;
}

}  // namespace

QuerySet queries_of(const Scene& scene, FrameSource& recording, const QueryChoice& choice,
                    const std::function<void(int)>& report) {
  const RecordingHeader& header = recording.header();
  const Referee referee(scene.bones, 0);
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<double> diagonals_m;
  for (const Bone& bone : scene.bones) {
    boxes.push_back(bounding_box(bone.surface.mesh.vertices));
    diagonals_m.push_back(boxes.back().diagonal().norm());
  }
  FoundQueries found;
  RecordedFrame frame;
  recording.rewind();
  for (int index = 1, moment = 0; index <= header.frames(); ++index) {
    recording.read(frame);
    // The moments divide the motion evenly, and the last is its last frame.
    if (static_cast<long>(index) * choice.moments < static_cast<long>(moment + 1) * header.frames()) continue;
    const std::size_t steps = std::min(frame.steps.size(), static_cast<std::size_t>(choice.steps));
    for (std::size_t i = 0; i < steps; ++i) {
      const int number = (index - 1) * header.steps_per_frame() + static_cast<int>(i);
      find_within_band(referee, boxes, frame.steps[i], number, header.free_nodes, choice.band_m, found);
    }
    moment = static_cast<int>(static_cast<long>(index) * choice.moments / header.frames());
    report(moment);
  }
  if (found.sites.empty()) {
    throw InputError(scene.name, fmt::format("no node comes within {:g} mm of a bone at the moments chosen; choose a "
                                             "wider --band-mm or more --moments",
                                             1e3 * choice.band_m));
  }
  if (found.sites.size() > choice.most) {
    found.thin_out(header.free_nodes, (found.sites.size() + choice.most - 1) / choice.most);
  }
  classify_sites(referee, diagonals_m, scene.muscle_mesh, header.free_nodes, found.sites);

  QuerySet set;
  for (const Bone& bone : scene.bones) set.bones.push_back(bone_of(bone));
  for (std::size_t i = 0; i < found.sites.size(); ++i) {
    const ContactSite& site = found.sites[i];
    add_vector(set.points_m, found.points_m[i]);
    add_vector(set.closest_m, site.surface_point_m);
    set.distances_m.push_back(found.distances_m[i]);
    set.bone.push_back(site.bone);
    set.node.push_back(site.node);
    set.step.push_back(found.steps[i]);
    set.difficulty.push_back(static_cast<std::int32_t>(site.difficulty));
  }
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    // Vertices, middles of edges, points next to the surface and anywhere: a muscle brings few of these.
    add_points(referee, bone, points_about(scene.bones[bone].surface.mesh, choice.around, 1 + bone), set);
  }
  return set;
}

QuerySet queries_about(const Bone& bone, std::span<const Vec3> points) {
  const Referee referee(std::span(&bone, 1), 0);
  QuerySet set;
  set.bones.push_back(bone_of(bone));
  add_points(referee, 0, points, set);
  return set;
}

}  // namespace musclebench

#include "core/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/mesh/body_mesh.hpp"

namespace musclebench {

double Scene::progress_at(double frame_position) const {
  return std::min(1.0, frame_position / (loop.frames - loop.rest_frames));
}

void Scene::poses_at(double frame_position, std::vector<RigidMotion>& poses) const {
  poses.resize(motions.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    poses[i] = motions[i].pose(progress_at(frame_position));
  }
}

double Scene::angle_rad(double frame_position) const {
  double largest = 0;
  for (const BoneMotion& motion : motions) {
    const double angle = motion.largest_angle_rad(progress_at(frame_position));
    largest = std::abs(angle) > std::abs(largest) ? angle : largest;
  }
  return largest;
}

std::vector<BoundNode> Scene::bound_nodes() const {
  std::vector<BoundNode> bound;
  for (const Attachment& attachment : attachments) {
    for (const int node : attachment.nodes) {
      bound.push_back({node, attachment.bone});
    }
  }
  std::stable_sort(bound.begin(), bound.end(), [](const BoundNode& a, const BoundNode& b) { return a.node < b.node; });
  bound.erase(
      std::unique(bound.begin(), bound.end(), [](const BoundNode& a, const BoundNode& b) { return a.node == b.node; }),
      bound.end());
  return bound;
}

std::vector<BoneResponse> Scene::responses(const std::vector<ResponseKind>& kinds) const {
  std::vector<BoneResponse> responses(std::max<std::size_t>(bone_pairs(), 1), {kinds.front(), response_steps});
  for (std::size_t pair = 0; pair < bone_contacts.size(); ++pair) {
    responses[pair].steps = bone_contacts[pair].response_steps.value_or(response_steps);
  }
  for (std::size_t pair = 0; pair < kinds.size(); ++pair) {
    if (kinds.size() > 1) responses[pair].kind = kinds[pair];
  }
  return responses;
}

Muscle& Scene::add_muscle(const std::string& name_of_muscle, const TriangleMesh& mesh) {
  const auto first_node = static_cast<int>(muscle_mesh.vertices.size());
  const std::size_t first_triangle = muscle_mesh.triangles.size();
  muscle_mesh.vertices.insert(muscle_mesh.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const auto& [a, b, c] : mesh.triangles) {
    muscle_mesh.triangles.push_back({first_node + a, first_node + b, first_node + c});
  }
  Muscle& muscle = muscles.emplace_back();
  muscle.body = {name_of_muscle, first_node, static_cast<int>(muscle_mesh.vertices.size()), first_triangle,
                 muscle_mesh.triangles.size()};
  return muscle;
}

std::vector<Body> Scene::bodies() const {
  std::vector<Body> bodies;
  for (const Muscle& muscle : muscles) {
    bodies.push_back(muscle.body);
  }
  return bodies;
}

std::vector<Vec3> Scene::vertices_of(const Body& body) const {
  return {muscle_mesh.vertices.begin() + body.first_node, muscle_mesh.vertices.begin() + body.last_node};
}

TriangleMesh Scene::mesh_of(const Body& body) const { return musclebench::mesh_of(muscle_mesh, body); }

std::string Scene::muscle_names() const {
  std::string names;
  for (const Muscle& muscle : muscles) {
    names += (names.empty() ? "" : " + ") + muscle.body.name;
  }
  return names;
}

EndNodes Scene::end_nodes(std::size_t muscle, const std::vector<BoundNode>& bound) const {
  const Body& body = muscles[muscle].body;
  std::set<int> origin_bones;
  for (const Attachment& attachment : attachments) {
    if (attachment.muscle == muscle && attachment.is_origin) origin_bones.insert(attachment.bone);
  }
  if (origin_bones.empty()) {
    const auto first = std::ranges::find(attachments, muscle, &Attachment::muscle);
    origin_bones.insert(first == attachments.end() ? 0 : first->bone);
  }
  EndNodes ends;
  for (const BoundNode& node : bound) {
    if (!body.has_node(node.node)) continue;
    (origin_bones.contains(node.bone) ? ends.origin : ends.insertion).push_back(node.node - body.first_node);
  }
  return ends;
}

std::vector<std::vector<FibreSegment>> Scene::fibres_with(const std::vector<BoundNode>& bound) const {
  constexpr int most_segments = 1000;
  std::vector<std::vector<FibreSegment>> fibres;
  for (std::size_t i = 0; i < muscles.size(); ++i) {
    const Muscle& muscle = muscles[i];
    if (!muscle.fibres_between_attachments) {
      fibres.push_back(muscle.fibres);
      continue;
    }
    const EndNodes ends = end_nodes(i, bound);
    fibres.push_back(fibres_between(mesh_of(muscle.body), ends.origin, ends.insertion, most_segments));
  }
  return fibres;
}

std::vector<ParameterSpec> mesh_parameters() {
  // Four splits are 256 triangles for one.
  return {parameter::integer({.name = "split_muscles",
                              .default_value = 0,
                              .minimum = 0,
                              .maximum = 4,
                              .help = "how often each triangle of the muscles is split in four: more nodes on the same "
                                      "surface"}),
          parameter::integer({.name = "smooth_bones",
                              .default_value = 0,
                              .minimum = 0,
                              .maximum = 4,
                              .help = "how often each triangle of the bones is split in four, on a smooth surface "
                                      "through their vertices; creases of more than 60 degrees stay"})};
}

std::map<std::string, ParameterValue> mesh_values(const MeshSplits& splits) {
  return {{"split_muscles", std::int64_t{splits.split_muscles}}, {"smooth_bones", std::int64_t{splits.smooth_bones}}};
}

std::vector<ParameterSpec> loop_parameters() {
  return {
      parameter::integer({.name = "frames",
                          .default_value = 314,
                          .minimum = 1,
                          .maximum = 10'000'000,
                          .help = "frames of the whole run"}),
      parameter::integer({.name = "rest_frames",
                          .default_value = 0,
                          .minimum = 0,
                          .maximum = 10'000'000,
                          .help = "last frames, in which bones stand still where their motion ended"}),
      parameter::integer({.name = "settle_substeps",
                          .default_value = 0,
                          .minimum = 0,
                          .maximum = 1'000'000,
                          .help =
                              "substeps before the first frame, in which bones stand still and velocities stay 0: they "
                              "move nodes out of bones gently; use 30 if nodes start in a bone"}),
      parameter::number({.name = "depenetration_m_per_s",
                         .unit = "m/s",
                         .default_value = 0.05,
                         .minimum = 0,
                         .maximum = 1e3,
                         .help = "how fast contacts remove overlaps of the start, without adding velocity; 0: at once, "
                                 "and bones throw nodes out (paper)"}),
      parameter::integer({.name = "substeps",
                          .default_value = 3,
                          .minimum = 1,
                          .maximum = 1'000'000,
                          .help = "substeps in a frame, each with one prediction and one velocity update"}),
      parameter::integer({.name = "iterations",
                          .default_value = 1,
                          .minimum = 1,
                          .maximum = 1'000'000,
                          .help = "passes over constraints, detection and response in a substep"}),
      parameter::number({.name = "time_step_s",
                         .unit = "s",
                         .default_value = 1e-3,
                         .minimum = 1e-9,
                         .maximum = 1e3,
                         .help = "time of one substep"}),
      parameter::number({.name = "node_mass_kg",
                         .unit = "kg",
                         .default_value = 1,
                         .minimum = 1e-12,
                         .maximum = 1e12,
                         .help = "mass of every node (unless a density is given)"}),
      parameter::number({.name = "density_kg_per_m3",
                         .unit = "kg/m3",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 1e6,
                         .help = "density of the muscle, whose mass its nodes share evenly; 0: use node_mass_kg"}),
      parameter::number({.name = "start_noise_m",
                         .unit = "m",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 1,
                         .help = "random displacement of free nodes at the start, at most this along each axis; 1e-12 "
                                 "shows the effect of rounding"}),
      parameter::choice({.name = "bone_motion",
                         .choices = {"per_frame", "interpolated"},
                         .help = "per_frame: bones jump to the frame's pose in its first substep (paper); "
                                 "interpolated: they move in every substep"}),
  };
}

bool has_effect(const Scene& scene, std::string_view name) {
  return std::ranges::any_of(scene.effects, [&](const SceneEffect& effect) { return effect.name == name; });
}

LoopParameters loop_from(const Parameters& parameters) {
  LoopParameters loop;
  loop.frames = static_cast<int>(parameters.integer("frames"));
  loop.rest_frames = static_cast<int>(parameters.integer("rest_frames"));
  loop.settle_substeps = static_cast<int>(parameters.integer("settle_substeps"));
  loop.depenetration_m_per_s = parameters.number("depenetration_m_per_s");
  loop.substeps = static_cast<int>(parameters.integer("substeps"));
  loop.iterations = static_cast<int>(parameters.integer("iterations"));
  loop.time_step_s = parameters.number("time_step_s");
  loop.node_mass_kg = parameters.number("node_mass_kg");
  loop.density_kg_per_m3 = parameters.number("density_kg_per_m3");
  loop.start_noise_m = parameters.number("start_noise_m");
  loop.interpolate_poses = parameters.word("bone_motion") == "interpolated";
  return loop;
}

std::map<std::string, ParameterValue> loop_values(const LoopParameters& loop) {
  return {{"frames", std::int64_t{loop.frames}},
          {"rest_frames", std::int64_t{loop.rest_frames}},
          {"settle_substeps", std::int64_t{loop.settle_substeps}},
          {"depenetration_m_per_s", loop.depenetration_m_per_s},
          {"substeps", std::int64_t{loop.substeps}},
          {"iterations", std::int64_t{loop.iterations}},
          {"time_step_s", loop.time_step_s},
          {"node_mass_kg", loop.node_mass_kg},
          {"density_kg_per_m3", loop.density_kg_per_m3},
          {"start_noise_m", loop.start_noise_m},
          {"bone_motion", std::string(loop.interpolate_poses ? "interpolated" : "per_frame")}};
}

}  // namespace musclebench

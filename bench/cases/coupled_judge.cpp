#include "bench/cases/coupled_judge.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "core/measure/muscle_depth.hpp"
#include "core/measure/outcome_limits.hpp"
#include "core/measure/stuck_nodes.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {
namespace {

/// Of the muscle's diagonal: a movement below that is none.
constexpr double least_movement = 1e-6;

/// A frame is judged in at most 20 times its own time. Work is counted and not timed, and 3 of 314 frames took a tenth
/// longer than their count.
constexpr long judging_factor = 18;
/// Rest is judged once, before any frame, and from nothing: what is known of it makes every later frame cheaper.
constexpr long budgets_at_rest = 20;
/// A shape that is kept is looked at more closely: of the largest muscle of the LHDL hip 8 suffice.
constexpr long budgets_of_a_shape = 20;
/// Of a frame, whatever its size: some 2 ms. Two small muscles that fly through each other within ten frames would be
/// looked at once else, before or after.
constexpr long least_budget = 100'000;
/// A unit of the Referee's work, and what a node costs the loop in a substep and iteration, alone and for every effect.
/// Calibrated on one thread of the EPYC that the reports are measured on, with the preset `paper` (5 effects) and no
/// collision: four LHDL muscles take 66 to 100 ns a node and substep, which these constants, from below, call 60. A
/// unit takes 20 ns, up to 30 where triangles are tested against triangles. So a spent budget is some 15 times the
/// frame.
constexpr long work_unit_ns = 20;
constexpr long node_ns = 10;
constexpr long node_and_effect_ns = 10;

/// Of the smallest muscle's diagonal: a twentieth of the depth that makes a run suspect.
constexpr double depth_tolerance = 2.5e-4;
/// Distances that looking for the deepest point of muscles in others may take.
constexpr long least_queries = 2000;
constexpr long queries_of_a_triangle = 20;

std::vector<int> carriers_of(const Scene& scene, std::span<const BoundNode> bound_nodes) {
  std::vector<int> carriers(scene.muscle_mesh.vertices.size(), -1);
  for (const BoundNode& bound : bound_nodes) {
    carriers[bound.node] = bound.bone;
  }
  return carriers;
}

double smallest_diagonal_m(const Scene& scene) {
  double smallest_m = std::numeric_limits<double>::infinity();
  for (const Body& body : scene.bodies()) {
    smallest_m = std::min(smallest_m, bounding_box(scene.mesh_of(body).vertices).diagonal().norm());
  }
  return smallest_m;
}

int body_of_triangle(std::span<const Body> bodies, int triangle) {
  const auto after = std::ranges::upper_bound(bodies, static_cast<std::size_t>(triangle), {}, &Body::last_triangle);
  return static_cast<int>(after - bodies.begin());
}

DeepBodies bodies_of(const DeepestSurfacePoint& surface, std::span<const Contact> truth, std::span<const Body> bodies) {
  if (surface.bone < 0) return {};
  if (surface.triangle >= 0) return {body_of_triangle(bodies, surface.triangle), surface.bone};
  const auto node = std::ranges::find_if(truth, [&](const Contact& contact) {
    return contact.bone == surface.bone && contact.depth_m == surface.depth_m;
  });
  return {node == truth.end() ? -1 : static_cast<int>(body_of(bodies, node->node)), surface.bone};
}

/// Of each bone the lowest limit that it has with a muscle.
std::vector<double> limits_of_bones_m(const Scene& scene) {
  std::vector<MuscleSize> muscles;
  for (const Body& body : scene.bodies()) muscles.push_back(size_of(body.name, scene.mesh_of(body)));
  std::vector<double> limits_m;
  for (const Bone& bone : scene.bones) {
    const BoneSize size{bone.name, thickness_m(bone.surface.mesh)};
    double limit_m = std::numeric_limits<double>::infinity();
    for (const MuscleSize& muscle : muscles) limit_m = std::min(limit_m, depth_limit(muscle, size).depth_m);
    limits_m.push_back(limit_m);
  }
  return limits_m;
}

}  // namespace

JudgedMuscles judged_muscles_of(const Scene& scene) {
  JudgedMuscles judged{scene.bodies(), {}};
  std::vector<MusclePair> pairs;
  for (const SceneMusclePair& pair : scene.muscle_pairs) pairs.push_back(pair.muscles);
  for (int muscle = 0; muscle < static_cast<int>(scene.muscles.size()); ++muscle) {
    judged.beside.push_back(muscles_beside(pairs, muscle));
  }
  return judged;
}

ThinBones::ThinBones(const Scene& scene, std::span<const int> carriers) {
  const std::vector<double> limits_m = limits_of_bones_m(scene);
  if (limits_m.empty()) return;
  const double largest_m = *std::ranges::max_element(limits_m);
  std::map<int, std::vector<std::size_t>> groups;  // by the power of two below the limit
  for (std::size_t bone = 0; bone < limits_m.size(); ++bone) {
    if (limits_m[bone] < largest_m) groups[std::ilogb(limits_m[bone])].push_back(bone);
  }
  for (const auto& [power, members] : groups) {
    std::vector<char> left_out(limits_m.size(), 1);
    double limit_m = largest_m;
    for (const std::size_t bone : members) {
      left_out[bone] = 0;
      limit_m = std::min(limit_m, limits_m[bone]);
    }
    std::vector<Bone> bones = scene.bones;
    for (std::size_t bone = 0; bone < bones.size(); ++bone) {
      if (left_out[bone] != 0) bones[bone].surface.mesh = {};
    }
    m_groups.push_back(
        {limit_m, left_out,
         SurfaceDepthMeter(scene.muscle_mesh.triangles, carriers, static_cast<int>(bones.size()), left_out),
         BoneVertexDepthMeter(bones, scene.muscle_mesh, carriers)});
  }
}

void ThinBones::measure(const Referee& referee, std::span<const RigidMotion> poses, std::span<const Vec3> positions,
                        std::span<const Contact> truth, long budget, std::span<const Body> bodies, StepRecord& record) {
  m_work = 0;
  double worst_share = 0;
  for (Group& group : m_groups) {
    m_truth.clear();
    std::ranges::copy_if(truth, std::back_inserter(m_truth), [&](const Contact& contact) {
      return group.left_out[static_cast<std::size_t>(contact.bone)] == 0;
    });
    const long own_budget = budget / (2 * std::ssize(m_groups));
    const DeepestBoneVertex vertex = group.vertices.measure(poses, positions, own_budget);
    const DeepestSurfacePoint surface = group.surface.measure(referee, poses, positions, m_truth, own_budget);
    m_work += group.vertices.last_work() + group.surface.last_work();
    record.judgement_complete = record.judgement_complete && vertex.complete() && surface.complete;
    const double depth_m = std::max(vertex.depth_m, surface.depth_m);
    if (!(depth_m / group.limit_m > worst_share)) continue;
    worst_share = depth_m / group.limit_m;
    record.thin_bone_is_vertex = vertex.depth_m > surface.depth_m;
    record.thin_bone_depth_m = depth_m;
    record.thin_bone_bodies = record.thin_bone_is_vertex
                                  ? DeepBodies{body_of_triangle(bodies, vertex.triangle), vertex.bone}
                                  : bodies_of(surface, m_truth, bodies);
  }
}

CoupledJudge::CoupledJudge(const Scene& scene, std::span<const BoundNode> bound_nodes, const Simulation& simulation,
                           int threads, std::function<double(int)> declared_missed_m, long effort)
    : m_referee(scene.bones, static_cast<int>(scene.muscle_mesh.vertices.size())),
      m_surface(scene.muscle_mesh.triangles, carriers_of(scene, bound_nodes), static_cast<int>(scene.bones.size())),
      m_bone_vertices(scene.bones, scene.muscle_mesh, carriers_of(scene, bound_nodes)),
      m_crossings(scene.bones, scene.muscle_mesh, scene.bodies(), carriers_of(scene, bound_nodes)),
      m_triangles(scene.muscle_mesh.triangles),
      m_thin_bones(scene, carriers_of(scene, bound_nodes)),
      m_tunnelling(static_cast<int>(scene.bones.size()), static_cast<int>(scene.muscle_mesh.vertices.size())),
      m_stretch(scene.muscle_mesh),
      m_rings(scene.retinacula, scene.muscle_mesh),
      m_all_bodies(scene.bodies()),
      m_smallest_diagonal_m(smallest_diagonal_m(scene)),
      m_declared_missed_m(std::move(declared_missed_m)),
      m_floor_m(least_movement * bounding_box(scene.muscle_mesh.vertices).diagonal().norm()),
      m_budget(effort * judging_budget(scene, threads)) {
  if (scene.muscles.size() > 1) {
    m_bodies = scene.bodies();
    for (const Body& body : m_bodies) m_stretch_of_bodies.emplace_back(scene.mesh_of(body));
  }
  if (!scene.muscle_pairs.empty()) {
    m_muscle_referee.emplace(scene.muscle_mesh, judged_muscles_of(scene));
    m_passing.emplace(judged_muscles_of(scene));
  }
  // The state at rest is where tunnelling starts from; all memory that judging needs is taken on the way.
  LastDetection nothing;
  const auto poses = simulation.bone_poses();
  nothing.bone_poses.assign(poses.begin(), poses.end());
  nothing.positions = simulation.positions();
  m_budget *= budgets_at_rest;
  judge(simulation, nothing, m_at_rest, CrossingTest::always);
  m_crossings.take_as_rest();
  m_budget /= budgets_at_rest;
  m_contact_depths = {};
}

void CoupledJudge::judge(const Simulation& simulation, const LastDetection& detection, StepRecord& record,
                         CrossingTest crossings) {
  const ScopedTimer timer(record.judging_ns);
  const std::vector<Vec3>& positions = simulation.positions();
  m_referee.judge(detection.bone_poses, detection.positions, simulation.free_nodes(), m_truth);
  m_work = m_referee.last_effort().work;
  record.difference = compare_contacts(detection.contacts, m_truth);
  judge_misses(detection, record);
  record.stuck_nodes = count_stuck_nodes(detection, m_truth, positions, m_floor_m);

  judge_nodes(simulation, record);
  judge_bodies(simulation, m_truth, m_in_muscles, record);
  m_contact_depths.add(m_truth, record.contacts);

  m_node_work = m_work;

  const auto poses = simulation.bone_poses();
  const long least = m_budget / 8;
  // Bones' vertices come first: what a budget leaves open of them has the coarser bound.
  const DeepestBoneVertex vertex = m_bone_vertices.measure(poses, positions, std::max((m_budget - m_work) / 2, least));
  record.bone_vertex_depth_m = vertex.depth_m;
  record.bone_vertex_depth_bound_m = vertex.bound_m;
  if (vertex.triangle >= 0) {
    record.bone_vertex_bodies = {body_of_triangle(m_all_bodies, vertex.triangle), vertex.bone};
  }
  m_work += m_bone_vertices.last_work();
  const DeepestSurfacePoint surface =
      m_surface.measure(m_referee, poses, positions, m_truth, std::max(m_budget - m_work, least));
  record.surface_depth_m = surface.depth_m;
  record.surface_depth_bound_m = surface.bound_m;
  record.surface_bodies = bodies_of(surface, m_truth, m_all_bodies);
  m_work += m_surface.last_work();
  record.judgement_complete = surface.complete && vertex.complete();
  if (m_thin_bones.are_there()) {
    m_thin_bones.measure(m_referee, poses, positions, m_truth, std::max(m_budget - m_work, least), m_all_bodies,
                         record);
    m_work += m_thin_bones.last_work();
  }
  judge_crossings(simulation, crossings, record);
  record.edge_stretch = m_stretch.measure(positions);
  record.ring_escape = m_rings.measure(positions, poses);
  record.judged = true;
}

/// At the end of a frame; adds its work.
void CoupledJudge::judge_nodes(const Simulation& simulation, StepRecord& record) {
  const std::vector<Vec3>& positions = simulation.positions();
  const auto poses = simulation.bone_poses();
  m_referee.judge(poses, positions, simulation.free_nodes(), m_truth);
  m_work += m_referee.last_effort().work;
  record.depth = depth_statistics(m_truth);
  if (const auto deepest = std::ranges::max_element(m_truth, {}, &Contact::depth_m); deepest != m_truth.end()) {
    record.depth_bodies = {static_cast<int>(body_of(m_all_bodies, deepest->node)), deepest->bone};
  }
  record.tunnelled_nodes = m_tunnelling.update(m_referee, poses, positions, simulation.free_nodes(), m_truth);
  m_work += m_tunnelling.last_work();

  m_in_muscles.clear();
  if (m_muscle_referee) {
    m_muscle_referee->judge(positions, m_in_muscles);
    m_work += m_muscle_referee->last_work();
    record.in_muscles = depth_statistics(m_in_muscles);
    if (const auto deepest = std::ranges::max_element(m_in_muscles, {}, &Contact::depth_m);
        deepest != m_in_muscles.end()) {
      record.in_muscles_bodies = {static_cast<int>(body_of(m_all_bodies, deepest->node)), deepest->bone};
    }
    record.depths_in_muscles_m.assign(m_crossings.pairs().size(), 0.0);
    for (const Contact& contact : m_in_muscles) {
      raise_depth(record, {static_cast<int>(body_of(m_all_bodies, contact.node)), contact.bone}, contact.depth_m);
    }
    record.passed_nodes = m_passing->update(*m_muscle_referee, positions);
    m_work += m_passing->last_work();
  }
}

void CoupledJudge::follow(const Simulation& simulation, StepRecord& record) {
  const ScopedTimer timer(record.judging_ns);
  m_work = 0;
  judge_nodes(simulation, record);
}

/// `m_truth` is that of the detection.
void CoupledJudge::judge_misses(const LastDetection& detection, StepRecord& record) const {
  record.true_contacts = static_cast<int>(m_truth.size());
  if (record.difference.missed == 0) return;
  const auto key = [](const Contact& contact) { return std::pair(contact.bone, contact.node); };
  for (const Contact& contact : m_truth) {
    if (std::ranges::binary_search(detection.contacts, key(contact), {}, key)) continue;
    const double declared_m = m_declared_missed_m ? m_declared_missed_m(contact.bone) : 0;
    if (std::isfinite(declared_m) && contact.depth_m <= declared_m) continue;
    ++record.missed_beyond;
    record.max_missed_m = std::max(record.max_missed_m, contact.depth_m);
  }
}

/// The muscles' tree has been refitted. A test costs what the scene's size says, so the last one tells what the next
/// takes.
void CoupledJudge::judge_crossings(const Simulation& simulation, CrossingTest test, StepRecord& record) {
  m_crossing_work = 0;
  m_crossing_credit += std::max(m_budget - m_work, m_budget / 8);
  if (test != CrossingTest::always && m_crossing_credit < m_crossing_estimate) return;
  record.crossings =
      m_crossings.count(m_referee, m_bone_vertices.muscle_tree(), simulation.bone_poses(), simulation.positions());
  record.beyond_rest = m_crossings.beyond_rest();
  m_crossing_work = m_crossing_estimate = m_crossings.last_work();
  m_crossing_credit = 0;
  const CrossingSums sums = sums_of(m_crossings.pairs(), record.crossings);
  record.bone_crossings = sums.in_bones;
  record.muscle_crossings = sums.in_muscles;
  record.self_intersecting_triangles = sums.in_itself;
  if (m_muscle_referee) judge_surfaces_in_muscles(simulation, record);
}

/// Of muscles that touch; crossings have been looked for.
void CoupledJudge::judge_surfaces_in_muscles(const Simulation& simulation, StepRecord& record) {
  std::vector<TriangleInMuscle> candidates = triangles_in_muscles(m_triangles, m_crossings.in_muscles(), m_in_muscles);
  std::erase_if(candidates, [&](const TriangleInMuscle& candidate) {
    const auto muscle = static_cast<std::size_t>(body_of_triangle(m_all_bodies, candidate.triangle));
    return !std::ranges::binary_search(m_muscle_referee->beside(muscle), candidate.other);
  });
  const auto bodies_of = [&](const TriangleInMuscle& candidate) {
    return DeepBodies{body_of_triangle(m_all_bodies, candidate.triangle), candidate.other};
  };
  const auto pair = [&](const TriangleInMuscle& candidate) { return muscle_pair(bodies_of(candidate)); };
  std::ranges::stable_sort(candidates, {}, pair);
  record.muscle_surface_depth_m = 0;
  // Pair by pair: a deep overlap that the scene has at rest must not hide a new one.
  for (auto first = candidates.begin(); first != candidates.end();) {
    const auto last =
        std::find_if(first, candidates.end(), [&](const auto& other) { return pair(other) != pair(*first); });
    const std::span<const TriangleInMuscle> own(first, last);
    const long queries = least_queries + static_cast<long>(queries_of_a_triangle * own.size());
    const DeepestInMuscle deepest = deepest_in_muscles(*m_muscle_referee, m_triangles, simulation.positions(), own,
                                                       depth_tolerance * m_smallest_diagonal_m, queries);
    const bool is_decided = deepest.complete || deepest.bound_m <= outcome_limit("depth_share") * m_smallest_diagonal_m;
    record.judgement_complete = record.judgement_complete && is_decided;
    first = last;
    if (deepest.triangle < 0) continue;
    const DeepBodies bodies = bodies_of({deepest.triangle, deepest.other});
    raise_depth(record, bodies, deepest.depth_m);
    if (deepest.depth_m <= record.muscle_surface_depth_m) continue;
    record.muscle_surface_depth_m = deepest.depth_m;
    record.muscle_surface_bodies = bodies;
  }
}

std::size_t CoupledJudge::muscle_pair(const DeepBodies& bodies) const {
  const int first = std::min(bodies.muscle, bodies.other);
  const int second = std::max(bodies.muscle, bodies.other);
  const auto pairs = m_crossings.pairs();
  const auto found = std::ranges::find_if(pairs, [&](const CrossingPair& pair) {
    return pair.kind == CrossedSurface::muscle && pair.muscle == first && pair.other == second;
  });
  return static_cast<std::size_t>(found - pairs.begin());
}

void CoupledJudge::raise_depth(StepRecord& record, const DeepBodies& bodies, double depth_m) const {
  double& deepest_m = record.depths_in_muscles_m.at(muscle_pair(bodies));
  deepest_m = std::max(deepest_m, depth_m);
}

void CoupledJudge::judge_bodies(const Simulation& simulation, std::span<const Contact> in_bones,
                                std::span<const Contact> in_muscles, StepRecord& record) {
  const auto depths_of = [](const Body& body, std::span<const Contact> truth) {
    std::vector<Contact> own;
    std::copy_if(truth.begin(), truth.end(), std::back_inserter(own),
                 [&](const Contact& contact) { return body.has_node(contact.node); });
    return depth_statistics(own);
  };
  record.muscles.resize(m_bodies.size());
  for (std::size_t i = 0; i < m_bodies.size(); ++i) {
    const Body& body = m_bodies[i];
    MuscleRecord& muscle = record.muscles[i];
    muscle.in_bones = depths_of(body, in_bones);
    muscle.in_muscles = depths_of(body, in_muscles);
    muscle.edge_stretch =
        m_stretch_of_bodies[i].measure(std::span(simulation.positions())
                                           .subspan(static_cast<std::size_t>(body.first_node),
                                                    static_cast<std::size_t>(body.last_node - body.first_node)));
  }
}

std::vector<double> CoupledJudge::depths(const Simulation& simulation) {
  std::vector<double> depths_m(simulation.positions().size(), 0.0);
  m_referee.judge(simulation.bone_poses(), simulation.positions(), simulation.free_nodes(), m_truth);
  for (const Contact& contact : m_truth) {
    depths_m[contact.node] = std::max(depths_m[contact.node], contact.depth_m);
  }
  return depths_m;
}

DepthsAroundNodes CoupledJudge::surface_depths(const Simulation& simulation) {
  return m_surface.measure_around_nodes(m_referee, simulation.bone_poses(), simulation.positions(), m_truth,
                                        budgets_of_a_shape * m_budget);
}

double CoupledJudge::share_inside_bones(std::span<const Vec3> points, std::span<const RigidMotion> poses) const {
  const auto is_inside = [&](const Vec3& point) {
    for (std::size_t bone = 0; bone < poses.size(); ++bone) {
      const RefereeTree& tree = m_referee.tree(static_cast<int>(bone));
      if (tree.winding_number(poses[bone].apply_inverse(point) - tree.centre_m()) > 0.5) return true;
    }
    return false;
  };
  return static_cast<double>(std::ranges::count_if(points, is_inside)) / static_cast<double>(points.size());
}

long judging_budget(const Scene& scene, int threads) {
  const auto nodes = static_cast<long>(scene.muscle_mesh.vertices.size());
  const auto effects = static_cast<long>(scene.effects.size());
  const long steps = static_cast<long>(scene.loop.substeps) * scene.loop.iterations;
  return std::max(least_budget,
                  judging_factor * nodes * steps * (node_ns + effects * node_and_effect_ns) / work_unit_ns / threads);
}

}  // namespace musclebench

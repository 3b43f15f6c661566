#include "bench/cases/coupled_judge.hpp"

#include <algorithm>
#include <iterator>

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
/// A unit of the Referee's work, and what a node costs the loop in a substep and iteration, alone and for every effect.
/// Calibrated on one thread of the EPYC that the reports are measured on, with the preset `paper` (5 effects) and no
/// collision: four LHDL muscles take 66 to 100 ns a node and substep, which these constants, from below, call 60. A
/// unit takes 20 ns, up to 30 where triangles are tested against triangles. So a spent budget is some 15 times the
/// frame.
constexpr long work_unit_ns = 20;
constexpr long node_ns = 10;
constexpr long node_and_effect_ns = 10;

std::vector<int> carriers_of(const Scene& scene, std::span<const BoundNode> bound_nodes) {
  std::vector<int> carriers(scene.muscle_mesh.vertices.size(), -1);
  for (const BoundNode& bound : bound_nodes) {
    carriers[bound.node] = bound.bone;
  }
  return carriers;
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

CoupledJudge::CoupledJudge(const Scene& scene, std::span<const BoundNode> bound_nodes, const Simulation& simulation,
                           int threads)
    : m_referee(scene.bones, static_cast<int>(scene.muscle_mesh.vertices.size())),
      m_surface(scene.muscle_mesh.triangles, carriers_of(scene, bound_nodes), static_cast<int>(scene.bones.size())),
      m_bone_vertices(scene.bones, scene.muscle_mesh, carriers_of(scene, bound_nodes)),
      m_crossings(scene.bones, scene.muscle_mesh, scene.bodies(), carriers_of(scene, bound_nodes)),
      m_tunnelling(static_cast<int>(scene.bones.size()), static_cast<int>(scene.muscle_mesh.vertices.size())),
      m_stretch(scene.muscle_mesh),
      m_floor_m(least_movement * bounding_box(scene.muscle_mesh.vertices).diagonal().norm()),
      m_budget(judging_budget(scene, threads)) {
  if (scene.muscles.size() > 1) {
    m_bodies = scene.bodies();
    for (const Body& body : m_bodies) m_stretch_of_bodies.emplace_back(scene.mesh_of(body));
  }
  if (!scene.muscle_pairs.empty()) {
    m_muscle_referee.emplace(scene.muscle_mesh, judged_muscles_of(scene));
  }
  // The state at rest is where tunnelling starts from; all memory that judging needs is taken on the way.
  LastDetection nothing;
  const auto poses = simulation.bone_poses();
  nothing.bone_poses.assign(poses.begin(), poses.end());
  nothing.positions = simulation.positions();
  StepRecord at_rest;
  m_budget *= budgets_at_rest;
  judge(simulation, nothing, at_rest, CrossingTest::always);
  m_budget /= budgets_at_rest;
  m_at_rest = at_rest.depth;
  m_in_muscles_at_rest = at_rest.in_muscles;
  m_crossings_at_rest = at_rest.crossings;
}

void CoupledJudge::judge(const Simulation& simulation, const LastDetection& detection, StepRecord& record,
                         CrossingTest crossings) {
  const ScopedTimer timer(record.judging_ns);
  const std::vector<Vec3>& positions = simulation.positions();
  m_referee.judge(detection.bone_poses, detection.positions, simulation.free_nodes(), m_truth);
  m_work = m_referee.last_effort().work;
  record.difference = compare_contacts(detection.contacts, m_truth);
  record.stuck_nodes = count_stuck_nodes(detection, m_truth, positions, m_floor_m);

  const auto poses = simulation.bone_poses();
  m_referee.judge(poses, positions, simulation.free_nodes(), m_truth);
  m_work += m_referee.last_effort().work;
  record.depth = depth_statistics(m_truth);
  record.tunnelled_nodes = m_tunnelling.update(m_referee, poses, positions, simulation.free_nodes(), m_truth);
  m_work += m_tunnelling.last_work();

  std::vector<Contact> in_muscles;
  if (m_muscle_referee) {
    m_muscle_referee->judge(positions, in_muscles);
    m_work += m_muscle_referee->last_work();
    record.in_muscles = depth_statistics(in_muscles);
  }

  judge_bodies(simulation, m_truth, in_muscles, record);

  m_node_work = m_work;

  const long least = m_budget / 8;
  // Bones' vertices come first: what a budget leaves open of them has the coarser bound.
  const DeepestBoneVertex vertex = m_bone_vertices.measure(poses, positions, std::max((m_budget - m_work) / 2, least));
  record.bone_vertex_depth_m = vertex.depth_m;
  record.bone_vertex_depth_bound_m = vertex.bound_m;
  m_work += m_bone_vertices.last_work();
  const DeepestSurfacePoint surface =
      m_surface.measure(m_referee, poses, positions, m_truth, std::max(m_budget - m_work, least));
  record.surface_depth_m = surface.depth_m;
  record.surface_depth_bound_m = surface.bound_m;
  m_work += m_surface.last_work();
  record.judgement_complete = surface.complete && vertex.complete();
  judge_crossings(simulation, crossings, record);
  record.edge_stretch = m_stretch.measure(positions);
  record.judged = true;
}

/// The muscles' tree has been refitted. A test costs what the scene's size says, so the last one tells what the next
/// takes.
void CoupledJudge::judge_crossings(const Simulation& simulation, CrossingTest test, StepRecord& record) {
  m_crossing_work = 0;
  m_crossing_credit += std::max(m_budget - m_work, m_budget / 8);
  if (test != CrossingTest::always && m_crossing_credit < m_crossing_estimate) return;
  record.crossings =
      m_crossings.count(m_referee, m_bone_vertices.muscle_tree(), simulation.bone_poses(), simulation.positions());
  m_crossing_work = m_crossing_estimate = m_crossings.last_work();
  m_crossing_credit = 0;
  const CrossingSums sums = sums_of(m_crossings.pairs(), record.crossings);
  record.bone_crossings = sums.in_bones;
  record.muscle_crossings = sums.in_muscles;
  record.self_intersecting_triangles = sums.in_itself;
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
  return judging_factor * nodes * steps * (node_ns + effects * node_and_effect_ns) / work_unit_ns / threads;
}

}  // namespace musclebench

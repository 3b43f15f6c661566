#include "bench/cases/coupled_judge.hpp"

#include <algorithm>

#include "core/measure/stuck_nodes.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {
namespace {

/// Of the muscle's diagonal: a movement below that is none.
constexpr double least_movement = 1e-6;

std::vector<int> carriers_of(const Scene& scene, std::span<const BoundNode> bound_nodes) {
  std::vector<int> carriers(scene.muscle.mesh.vertices.size(), -1);
  for (const BoundNode& bound : bound_nodes) {
    carriers[bound.node] = bound.bone;
  }
  return carriers;
}

}  // namespace

CoupledJudge::CoupledJudge(const Scene& scene, std::span<const BoundNode> bound_nodes, const Simulation& simulation)
    : m_referee(scene.bones, static_cast<int>(scene.muscle.mesh.vertices.size())),
      m_surface(scene.muscle.mesh.triangles, carriers_of(scene, bound_nodes), static_cast<int>(scene.bones.size())),
      m_bone_vertices(scene.bones, scene.muscle.mesh, carriers_of(scene, bound_nodes)),
      m_passages(static_cast<int>(scene.bones.size()), static_cast<int>(scene.muscle.mesh.vertices.size())),
      m_floor_m(least_movement * bounding_box(scene.muscle.mesh.vertices).diagonal().norm()) {
  // The state at rest is where passages start from; all memory that judging needs is taken on the way.
  LastDetection nothing;
  const auto poses = simulation.bone_poses();
  nothing.bone_poses.assign(poses.begin(), poses.end());
  nothing.positions = simulation.particles().positions;
  StepRecord at_rest;
  judge(simulation, nothing, at_rest);
}

void CoupledJudge::judge(const Simulation& simulation, const LastDetection& detection, StepRecord& record) {
  const std::vector<Vec3>& positions = simulation.particles().positions;
  m_referee.judge(detection.bone_poses, detection.positions, simulation.free_nodes(), m_truth);
  record.difference = compare_contacts(detection.contacts, m_truth);
  record.stuck_nodes = count_stuck_nodes(detection, m_truth, positions, m_floor_m);

  const auto poses = simulation.bone_poses();
  m_referee.judge(poses, positions, simulation.free_nodes(), m_truth);
  record.depth = depth_statistics(m_truth);
  record.tunnelled_nodes = m_passages.update(m_referee, poses, positions, simulation.free_nodes(), m_truth);
  record.surface_depth_m = m_surface.measure(m_referee, poses, positions, m_truth).depth_m;
  record.bone_vertex_depth_m = m_bone_vertices.measure(poses, positions).depth_m;
  record.judged = true;
}

std::vector<double> CoupledJudge::depths(const Simulation& simulation) {
  std::vector<double> depths_m(simulation.particles().size(), 0.0);
  m_referee.judge(simulation.bone_poses(), simulation.particles().positions, simulation.free_nodes(), m_truth);
  for (const Contact& contact : m_truth) {
    depths_m[contact.node] = std::max(depths_m[contact.node], contact.depth_m);
  }
  return depths_m;
}

}  // namespace musclebench

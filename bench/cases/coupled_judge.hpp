#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/effects/effect_registry.hpp"
#include "core/measure/bone_vertex_depth.hpp"
#include "core/measure/step_record.hpp"
#include "core/measure/surface_depth.hpp"
#include "core/measure/tunnelling_tracker.hpp"
#include "core/referee/referee.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// What the truth says of a coupled run, frame by frame: how deep muscle and bones are in each other, which nodes went
/// through a bone, which are held for nothing.
class CoupledJudge {
 public:
  /// `simulation` has not made a frame yet.
  CoupledJudge(const Scene& scene, std::span<const BoundNode> bound_nodes, const Simulation& simulation);

  /// Fills in the judged figures of `record` after a frame, whose last detection was `detection`.
  void judge(const Simulation& simulation, const LastDetection& detection, StepRecord& record);

  /// Of every node, m: > 0 inside a bone, its largest; 0 for free and bound nodes.
  [[nodiscard]] std::vector<double> depths(const Simulation& simulation);

 private:
  Referee m_referee;
  SurfaceDepthMeter m_surface;
  BoneVertexDepthMeter m_bone_vertices;
  TunnellingTracker m_passages;
  double m_floor_m;  // of a movement that counts, for stuck nodes
  std::vector<Contact> m_truth;
};

}  // namespace musclebench

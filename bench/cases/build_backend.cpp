#include "bench/cases/build_backend.hpp"

namespace musclebench {

BuiltBackend build_backend(const Case& resolved, const std::function<void(double share)>& report) {
  BuiltBackend built;
  built.backend = make_backend(resolved.scene, resolved.backend, resolved.parameters, resolved.colliders);
  built.backend->report_build_to(report);
  if (resolved.scene.muscles.size() > 1) built.backend->tell_apart(resolved.scene.bodies());
  if (resolved.prune) {
    built.reach = predict_reach(resolved.scene);
    built.backend->expect_within(expected_boxes(built.reach));
  }
  for (const Bone& bone : resolved.scene.bones) {
    bone.shared.start_accounting();
  }
  {
    const ScopedTimer timer(built.build_ns);
    built.backend->build(resolved.scene.bones, resolved.scene.muscle_mesh, resolved.threads);
  }
  for (const Bone& bone : resolved.scene.bones) {
    built.build_ns += bone.shared.reused_build_ns();
  }
  return built;
}

std::vector<PrunedResult> pruned_results(const CollisionBackend& backend, const std::vector<BoneReach>& reach) {
  std::vector<PrunedResult> results;
  for (const PrunedBone& pruned : backend.pruned_bones()) {
    results.push_back({pruned, reach[static_cast<std::size_t>(pruned.bone)]});
  }
  return results;
}

void release_shared(const Scene& scene) {
  for (const Bone& bone : scene.bones) {
    bone.shared.release();
  }
}

}  // namespace musclebench

#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backends/registry.hpp"
#include "bench/cases/advise_plan.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// The scene that all kernels measure: the one in MUSCLEBENCH_MICRO_SCENE, or synthetic/iliacus.
const Scene& micro_scene();

/// That scene with its own preset (empty) or another: loaded anew.
Scene load_micro_scene(const std::string& preset);

/// The backends that are raced for speed: those with a [[race]] in their study.
std::vector<std::string> raced_backends();

/// The backend that detects nothing: what it leaves is the loop itself.
std::string control_backend();

/// What a step of the backend takes, as its study guesses for the reference muscle; 0: unknown.
double guessed_step_ms(const BackendEntry& backend);

/// Parameters of a backend as in a run; fields are kept in the folder MUSCLEBENCH_MICRO_STRUCTURES, where it is given.
Settings run_settings(const std::string& backend);

/// The same without clearance cache: for kernels that query the same positions again, which expires no safe sphere.
Settings cold_settings(const std::string& backend);

/// `bones` and `muscle` outlive the backend.
std::unique_ptr<CollisionBackend> built_backend(const std::string& name, const Settings& settings,
                                                std::span<const Bone> bones, const TriangleMesh& muscle,
                                                int threads = 1);

}  // namespace musclebench

#pragma once

#include <functional>
#include <string>

#include "core/pbd/simulation.hpp"
#include "core/recording/recording_writer.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Runs all frames of `scene`, whose simulation stands before the first, and writes each of their collision steps. Says
/// why, in words, when the simulation blew up before the last frame; else empty. The writer is not finished.
std::string record_frames(Simulation& simulation, const Scene& scene, RecordingWriter& writer,
                          const std::function<void(int frames_done)>& report);

}  // namespace musclebench

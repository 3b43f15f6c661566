#pragma once

#include <span>

#include "bench/cases/case.hpp"
#include "bench/cases/scene_source.hpp"
#include "core/recording/recording.hpp"

namespace musclebench {

/// Both are frames of the range.
struct FrameRange {
  int first;
  int last;
};

/// What a recording of these frames of the case begins with. `choice`: as its scene was loaded.
RecordingHeader recording_header(const Case& resolved, const SceneChoice& choice, const FrameRange& frames,
                                 std::span<const int> free_nodes);

}  // namespace musclebench

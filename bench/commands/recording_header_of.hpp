#pragma once

#include <span>

#include "bench/cases/case.hpp"
#include "bench/commands/command_options.hpp"
#include "core/recording/recording.hpp"

namespace musclebench {

/// Both are frames of the range.
struct FrameRange {
  int first;
  int last;
};

/// What a recording of these frames of the case begins with.
RecordingHeader recording_header(const Case& resolved, const SceneOptions& options, const FrameRange& frames,
                                 std::span<const int> free_nodes);

}  // namespace musclebench

#pragma once

#include <optional>
#include <vector>

#include "core/recording/recording.hpp"

namespace musclebench {

/// One frame as recorded.
struct RecordedFrame {
  int frame = 0;  ///< 1-based
  double angle_deg = 0;
  std::vector<RecordedStep> steps;
  std::optional<RecordedStep> lead_in;  ///< the step before the first, where the source leaves out the frame before
};

/// Recorded frames, one after the other, wherever they are kept.
class FrameSource {
 public:
  FrameSource() = default;
  FrameSource(const FrameSource&) = default;
  FrameSource(FrameSource&&) = default;
  FrameSource& operator=(const FrameSource&) = default;
  FrameSource& operator=(FrameSource&&) = default;
  virtual ~FrameSource() = default;

  [[nodiscard]] virtual const RecordingHeader& header() const = 0;
  /// Before the first frame again.
  virtual void rewind() = 0;
  /// The next of `header().frames()` frames. Throws InputError when it can't be read.
  virtual void read(RecordedFrame& frame) = 0;
};

}  // namespace musclebench

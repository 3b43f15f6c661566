#pragma once

#include "core/recording/frame_source.hpp"

namespace musclebench {

/// Calls `look` with every so many-th frame of the recording and the last, and `lead_in` with the step before one that
/// does not follow another: what keeps state between steps starts from there. After a gap all safe spheres are new, so
/// fewer expire than in a run. `frame` is where frames are read to.
template <typename LeadIn, typename Look>
void for_each_replayed_frame(FrameSource& recording, int stride, RecordedFrame& frame, const LeadIn& lead_in,
                             const Look& look) {
  const int frames = recording.header().frames();
  const auto is_replayed = [&](int index) { return index % stride == 0 || index == frames; };
  recording.rewind();
  for (int index = 1; index <= frames; ++index) {
    recording.read(frame);
    if (is_replayed(index)) {
      if (frame.lead_in) lead_in(*frame.lead_in);
      look(frame);
    } else if (is_replayed(index + 1)) {
      lead_in(frame.steps.back());
    }
  }
}

}  // namespace musclebench

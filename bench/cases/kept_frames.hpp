#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/pbd/simulation.hpp"
#include "core/recording/frame_source.hpp"

namespace musclebench {

/// Some frames of a run, held in memory: a recording that lives no longer than its process.
class KeptFrames final : public FrameSource, public CollisionObserver {
 public:
  /// With `muscle_contact` what contact between muscles is asked about is kept, too.
  KeptFrames(int nodes, std::span<const int> free_nodes, bool muscle_contact = false);

  /// The steps that follow belong to this frame.
  void begin_frame(int frame, double angle_deg);
  /// Of the steps that follow only the last is kept, as what goes before the next frame.
  void begin_lead_in();

  void before_stages(std::span<const Vec3> positions) override;
  void before_detection(const CollisionStep& step) override;
  void after_detection(const CollisionStep& /*step*/, std::span<const Contact> /*contacts*/) override {}

  /// Its frames are the kept ones.
  [[nodiscard]] const RecordingHeader& header() const override { return m_header; }
  void rewind() override { m_next = 0; }
  void read(RecordedFrame& frame) override { frame = m_frames.at(m_next++); }

 private:
  RecordingHeader m_header;
  std::vector<RecordedFrame> m_frames;
  std::vector<Vec3> m_muscle_positions;   ///< of the step that goes on
  std::optional<RecordedStep> m_lead_in;  ///< to the frame that has not begun
  bool m_is_leading_in = false;
  std::size_t m_next = 0;
};

}  // namespace musclebench

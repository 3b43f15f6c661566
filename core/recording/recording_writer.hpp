#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/base/output_file.hpp"
#include "core/base/sha256.hpp"
#include "core/recording/recording.hpp"
#include "core/recording/step_codec.hpp"

namespace musclebench {

/// Throws InputError when `file` could not be written, or holds something else than a recording. Leaves nothing behind.
void require_recording_writable(const std::filesystem::path& file);

/// Streams a recording to the disk, a frame at a time, under a temporary name beside `file`. Every failure is an
/// InputError; a writer that ends without `finish` leaves nothing behind.
class RecordingWriter {
 public:
  RecordingWriter(std::filesystem::path file, const RecordingHeader& header);
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;
  ~RecordingWriter();

  /// `muscle_positions`: where muscles touch. False when positions cannot be rounded (StepEncoder::encode).
  bool add_step(std::span<const Vec3> substep_start, std::span<const RigidMotion> previous_bone_poses,
                std::span<const Vec3> positions, std::span<const RigidMotion> bone_poses,
                std::span<const Vec3> muscle_positions = {});

  /// After all steps of all frames: seals the file and gives it its name.
  RecordingFile finish();

  /// The temporary name.
  [[nodiscard]] const std::filesystem::path& part() const { return m_part; }

 private:
  void put(std::string_view bytes);
  void put_block();

  std::filesystem::path m_file;
  std::filesystem::path m_part;
  OutputFile m_output;
  Sha256 m_hash;
  RecordingFile m_written;
  StepEncoder m_encoder;
  int m_steps_per_frame;
  int m_steps = 0;  // of this frame
  std::string m_frame;
  std::string m_block;
  bool m_finished = false;
};

}  // namespace musclebench

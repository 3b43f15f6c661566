#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/recording/frame_source.hpp"
#include "core/recording/step_codec.hpp"

namespace musclebench {

/// Reads a recording from the disk, a frame at a time.
class RecordingReader final : public FrameSource {
 public:
  /// Reads the whole file once, to check its hash, where its ends are those of a recording. Throws InputError that says
  /// what is wrong: no recording, of another version, truncated, or changed (with the hash that it ends in and the hash
  /// that it has).
  explicit RecordingReader(std::filesystem::path file);

  [[nodiscard]] const RecordingHeader& header() const override { return m_header; }
  [[nodiscard]] const RecordingFile& file() const { return m_written; }

  void rewind() override;
  /// Frames that follow are predicted from this one, so none can be left out. Throws InputError after the last, or when
  /// the file was changed after it was opened.
  void read(RecordedFrame& frame) override;

 private:
  [[noreturn]] void refuse(std::string_view problem) const;
  void check_ends();
  void check_hash();
  void read_header();
  void check_claim();
  bool unpack_frame(double most_bytes);
  void require_room_for_steps(const RecordedFrame& frame) const;
  void read_bytes(std::string& bytes, std::size_t size);

  std::filesystem::path m_path;
  std::ifstream m_stream;
  RecordingFile m_written;
  RecordingHeader m_header;
  std::streamoff m_first_block = 0;
  int m_frames_read = 0;
  StepDecoder m_decoder;
  std::string m_block;
  std::string m_bytes;
};

}  // namespace musclebench

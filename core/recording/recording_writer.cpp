#include "core/recording/recording_writer.hpp"

#include <cassert>
#include <cstdint>
#include <fstream>
#include <limits>
#include <unistd.h>
#include <zstd.h>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/recording/recording_header.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

constexpr int compression_level = 3;  // higher ones take ten times as long for a hundredth less

template <typename Number>
std::string bytes_of(Number number) {
  return {reinterpret_cast<const char*>(&number), sizeof number};
}

fs::path part_of(const fs::path& file) {
  return file.parent_path() / fmt::format(".{}.{}.part", file.filename().string(), getpid());
}

bool holds_recording(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string begin(recording_magic.size(), '\0');
  stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return stream && begin == recording_magic;
}

}  // namespace

void require_recording_writable(const fs::path& file) {
  if (!file.has_filename() || fs::is_directory(file)) {
    throw InputError(file.string(), "is a folder; choose a file name for --out");
  }
  if (fs::exists(file) && !(fs::is_regular_file(file) && (fs::is_empty(file) || holds_recording(file)))) {
    throw InputError(file.string(),
                     "holds something else than a recording and would be replaced; choose another --out");
  }
  const fs::path part = part_of(file);
  OutputFile(part).close();
  fs::remove(part);
}

RecordingWriter::RecordingWriter(fs::path file, const RecordingHeader& header)
    : m_file(std::move(file)),
      m_part(part_of(m_file)),
      m_output(m_part),
      m_encoder(header),
      m_steps_per_frame(header.steps_per_frame()) {
  const std::string text = text_of(header);
  try {
    put(recording_magic);
    put(recording_version);
    put(bytes_of(std::uint64_t{text.size()}));
    put(text);
  } catch (...) {  // a constructor that throws has no destructor
    std::error_code ignored;
    fs::remove(m_part, ignored);
    throw;
  }
}

RecordingWriter::~RecordingWriter() {
  if (!m_finished) {
    std::error_code ignored;
    fs::remove(m_part, ignored);
  }
}

bool RecordingWriter::add_step(std::span<const Vec3> substep_start, std::span<const RigidMotion> previous_bone_poses,
                               std::span<const Vec3> positions, std::span<const RigidMotion> bone_poses,
                               std::span<const Vec3> muscle_positions) {
  if (!m_encoder.encode(substep_start, previous_bone_poses, positions, bone_poses, m_frame, muscle_positions)) {
    return false;
  }
  if (++m_steps == m_steps_per_frame) {
    put_block();
    m_frame.clear();
    m_steps = 0;
  }
  return true;
}

RecordingFile RecordingWriter::finish() {
  assert(m_steps == 0);
  put(bytes_of(std::uint32_t{0}));
  m_written.sha256 = m_hash.hex_digest();
  const std::string end = std::string(recording_hash_mark) + m_written.sha256;
  m_output.stream() << end;
  m_written.bytes += end.size();
  m_output.close();
  std::error_code failure;
  fs::rename(m_part, m_file, failure);
  if (failure) {
    throw InputError(m_file.string(), fmt::format("cannot be written ({})", failure.message()));
  }
  m_finished = true;
  return m_written;
}

void RecordingWriter::put(std::string_view bytes) {
  m_hash.add(bytes);
  m_output.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  m_output.check();
  m_written.bytes += bytes.size();
}

void RecordingWriter::put_block() {
  m_block.resize(ZSTD_compressBound(m_frame.size()));
  const std::size_t size =
      ZSTD_compress(m_block.data(), m_block.size(), m_frame.data(), m_frame.size(), compression_level);
  if (ZSTD_isError(size) != 0 || size > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(m_file.string(), "cannot hold so large a frame; record with fewer substeps or iterations");
  }
  put(bytes_of(static_cast<std::uint32_t>(size)));
  put(std::string_view(m_block.data(), size));
}

}  // namespace musclebench

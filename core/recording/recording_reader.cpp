#include "core/recording/recording_reader.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <zstd.h>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/base/system_memory.hpp"
#include "core/recording/recording_header.hpp"

namespace musclebench {

namespace {

constexpr std::size_t chunk_bytes = std::size_t{1} << 20U;
constexpr std::size_t end_bytes = recording_hash_mark.size() + recording_hash_digits;

template <typename Number>
Number number_of(std::string_view bytes) {
  Number number{};
  std::memcpy(&number, bytes.data(), sizeof number);
  return number;
}

/// What the steps of a frame take unpacked, generously: two poses a bone, three positions a node.
double most_bytes_of_a_frame(const RecordingHeader& header) {
  const double a_step =
      sizeof(RecordedStep) + 2.0 * sizeof(RigidMotion) * header.bones + 3.0 * sizeof(Vec3) * header.nodes;
  return a_step * header.steps_per_frame();
}

/// A step that nothing moves in: an order and a width.
constexpr std::size_t least_bytes_of_a_step = 2;

/// What compressed bytes say that they unpack to; nothing where they say nothing, or more than they can: a block of
/// Zstandard has four bytes or more and unpacks to 128 KiB or less.
std::optional<std::size_t> claimed_bytes(std::string_view packed) {
  constexpr unsigned long long least_block = 4;
  constexpr unsigned long long most_unpacked = 128 << 10;
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  const bool is_told = size != ZSTD_CONTENTSIZE_ERROR && size != ZSTD_CONTENTSIZE_UNKNOWN;
  return is_told && size <= (packed.size() / least_block + 1) * most_unpacked ? std::optional<std::size_t>(size)
                                                                              : std::nullopt;
}

}  // namespace

RecordingReader::RecordingReader(std::filesystem::path file) : m_path(std::move(file)), m_decoder(m_header) {
  // Asked first: opening a pipe would wait for its writer.
  if (std::filesystem::is_regular_file(m_path)) {
    m_stream.open(m_path, std::ios::binary);
  }
  if (!m_stream.is_open()) {
    refuse("cannot be read; is the path right?");
  }
  m_written.bytes = std::filesystem::file_size(m_path);
  std::string first_line(recording_magic.size(), '\0');
  if (!m_stream.read(first_line.data(), static_cast<std::streamsize>(first_line.size())) ||
      first_line != recording_magic) {
    refuse("is not a recording of musclebench; make one with `musclebench record`");
  }
  std::getline(m_stream, first_line);
  if (first_line + '\n' != recording_version) {
    refuse(fmt::format("is a recording of version '{}', this program reads version {}; record it again",
                       first_line.substr(0, 20), recording_version.substr(0, recording_version.size() - 1)));
  }
  check_ends();
  check_hash();
  read_header();
  rewind();
}

void RecordingReader::rewind() {
  m_stream.clear();
  m_stream.seekg(m_first_block);
  m_frames_read = 0;
  m_decoder = StepDecoder(m_header);
}

void RecordingReader::read(RecordedFrame& frame) {
  if (m_frames_read == m_header.frames()) {
    refuse(fmt::format("has no more than {} frames", m_frames_read));
  }
  if (!unpack_frame(most_bytes_of_a_frame(m_header))) {
    refuse("holds a frame that cannot be read; record it again");
  }
  require_room_for_steps(frame);
  frame.lead_in.reset();
  frame.frame = m_frames_read + 1;
  frame.angle_deg = m_header.angles_deg[static_cast<std::size_t>(m_frames_read)];
  frame.steps.resize(static_cast<std::size_t>(m_header.steps_per_frame()));
  std::string_view rest = m_bytes;
  for (RecordedStep& step : frame.steps) {
    if (!m_decoder.decode(rest, step)) {
      refuse("holds a frame that cannot be read; record it again");
    }
  }
  if (!rest.empty()) {
    refuse("holds a frame that is longer than its steps; record it again");
  }
  ++m_frames_read;
}

void RecordingReader::refuse(std::string_view problem) const { throw InputError(m_path.string(), problem); }

/// Whether the file ends in a hash and begins with a header, before all of it is read for the hash: a large file of
/// something else is told at once.
void RecordingReader::check_ends() {
  constexpr std::string_view cut = "is truncated: it does not end in its hash; record or copy it again";
  if (m_written.bytes < end_bytes) {
    refuse(cut);
  }
  m_stream.seekg(static_cast<std::streamoff>(m_written.bytes - end_bytes));
  read_bytes(m_bytes, end_bytes);
  if (!m_bytes.starts_with(recording_hash_mark)) {
    refuse(cut);
  }
  constexpr std::size_t before_header = recording_magic.size() + recording_version.size() + sizeof(std::uint64_t);
  m_stream.seekg(static_cast<std::streamoff>(before_header - sizeof(std::uint64_t)));
  read_bytes(m_bytes, sizeof(std::uint64_t));
  const auto size = number_of<std::uint64_t>(m_bytes);
  if (size > m_written.bytes - std::min<std::uintmax_t>(m_written.bytes, before_header + end_bytes)) {
    refuse("has a header that is longer than the file; record it again");
  }
  const auto byte_at = [&](std::uint64_t offset) {
    m_stream.seekg(static_cast<std::streamoff>(offset));
    read_bytes(m_bytes, 1);
    return m_bytes.front();
  };
  if (size < 2 || byte_at(before_header) != '{' || byte_at(before_header + size - 1) != '}') {
    refuse("has a header that cannot be read; record it again");
  }
}

void RecordingReader::check_hash() {
  m_stream.seekg(0);
  Sha256 hash;
  std::uintmax_t left = m_written.bytes - end_bytes;
  while (left > 0) {
    read_bytes(m_bytes, static_cast<std::size_t>(std::min<std::uintmax_t>(left, chunk_bytes)));
    hash.add(m_bytes);
    left -= m_bytes.size();
  }
  read_bytes(m_bytes, end_bytes);
  const std::string expected = m_bytes.substr(recording_hash_mark.size());
  m_written.sha256 = hash.hex_digest();
  if (m_written.sha256 != expected) {
    refuse(fmt::format("was changed after it was recorded: its hash is {}, it ends in {}; record or copy it again",
                       m_written.sha256, expected));
  }
}

void RecordingReader::read_header() {
  m_stream.seekg(static_cast<std::streamoff>(recording_magic.size() + recording_version.size()));
  read_bytes(m_bytes, sizeof(std::uint64_t));
  const auto size = number_of<std::uint64_t>(m_bytes);
  read_bytes(m_bytes, size);
  m_header = header_of(m_bytes, m_path.string());
  m_first_block = m_stream.tellg();
  check_claim();
}

/// The first step says where every node is, in at least a byte a coordinate, so that a header that claims more nodes
/// than there are is told before memory is taken for them. What the frame itself claims proves nothing: it is unpacked.
void RecordingReader::check_claim() {
  const auto least_bytes = 3 * static_cast<std::size_t>(m_header.nodes);
  if (!unpack_frame(std::numeric_limits<double>::infinity()) || m_bytes.size() < least_bytes) {
    refuse(fmt::format("has a header that claims {} nodes, which its first frame does not hold; record it again",
                       m_header.nodes));
  }
}

/// The next frame, into `m_bytes`; false where it can't be unpacked or claims more than `most_bytes`, before memory is
/// taken for it.
bool RecordingReader::unpack_frame(double most_bytes) {
  read_bytes(m_block, sizeof(std::uint32_t));
  read_bytes(m_block, number_of<std::uint32_t>(m_block));
  const std::optional<std::size_t> size = claimed_bytes(m_block);
  if (!size || static_cast<double>(*size) > most_bytes) return false;
  m_bytes.resize(*size);
  return ZSTD_decompress(m_bytes.data(), m_bytes.size(), m_block.data(), m_block.size()) == *size;
}

/// Before memory is taken for the steps of the frame in `m_bytes`. Those in which nothing moves take next to nothing in
/// the file, and as much as any other here.
void RecordingReader::require_room_for_steps(const RecordedFrame& frame) const {
  const auto steps = static_cast<std::size_t>(m_header.steps_per_frame());
  if (m_bytes.size() / least_bytes_of_a_step < steps) {
    refuse(
        fmt::format("has a header that claims {} steps a frame, which a frame does not hold; record it again", steps));
  }
  if (frame.steps.size() != steps) {  // else they take the place of those of the frame before
    require_memory(static_cast<std::size_t>(most_bytes_of_a_frame(m_header)), m_path.string(),
                   "record it with fewer substeps or iterations");
  }
}

void RecordingReader::read_bytes(std::string& bytes, std::size_t size) {
  const std::streamoff offset = m_stream.tellg();
  if (offset < 0 ||
      size > m_written.bytes - std::min<std::uintmax_t>(m_written.bytes, static_cast<std::uintmax_t>(offset))) {
    refuse("is truncated, or was changed while it was read; record or copy it again");
  }
  bytes.resize(size);
  if (!m_stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    refuse("is truncated, or was changed while it was read; record or copy it again");
  }
}

}  // namespace musclebench

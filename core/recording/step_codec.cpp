#include "core/recording/step_codec.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

namespace musclebench {

namespace {

static_assert(std::endian::native == std::endian::little, "recordings are little-endian");

using Coordinates = StepPredictor::Coordinates;

constexpr int bits_a_byte = 8;
constexpr std::size_t pose_bytes = sizeof(double) * 12;
constexpr double largest_coordinate = 4503599627370496;  // 2^52: whole numbers and their double differences are exact

/// Beyond so many iterations the history would cost more memory than it saves on the disk.
constexpr int longest_lag = 16;

/// Small numbers of either sign become small numbers without one.
std::uint64_t folded(std::uint64_t difference) { return (difference << 1U) ^ (0 - (difference >> 63U)); }
std::uint64_t unfolded(std::uint64_t number) { return (number >> 1U) ^ (0 - (number & 1U)); }

char byte_of(std::uint64_t number, int byte) {
  return static_cast<char>(static_cast<unsigned char>(number >> static_cast<unsigned>(bits_a_byte * byte)));
}

/// Writes what `actual` differs from `predicted`: the bytes a difference, then the lowest bytes of all, then the next.
void put_differences(const Coordinates& actual, const Coordinates& predicted, std::string& bytes) {
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < actual.size(); ++i) {
    all |= folded(actual[i] - predicted[i]);
  }
  const int width = (std::bit_width(all) + bits_a_byte - 1) / bits_a_byte;
  bytes += static_cast<char>(width);
  const std::size_t begin = bytes.size();
  bytes.resize(begin + static_cast<std::size_t>(width) * actual.size());
  char* plane = bytes.data() + begin;
  for (int byte = 0; byte < width; ++byte, plane += actual.size()) {
    for (std::size_t i = 0; i < actual.size(); ++i) {
      plane[i] = byte_of(folded(actual[i] - predicted[i]), byte);
    }
  }
}

bool take_byte(std::string_view& bytes, int most, int& value) {
  if (bytes.empty()) {
    return false;
  }
  value = static_cast<unsigned char>(bytes.front());
  bytes.remove_prefix(1);
  return value <= most;
}

bool take_differences(std::string_view& bytes, const Coordinates& predicted, Coordinates& actual) {
  int width = 0;
  const std::size_t size = predicted.size();
  if (!take_byte(bytes, sizeof(std::uint64_t), width) || bytes.size() / size < static_cast<std::size_t>(width)) {
    return false;
  }
  actual.assign(size, 0);
  for (int byte = 0; byte < width; ++byte) {
    const auto shift = static_cast<unsigned>(bits_a_byte * byte);
    const char* plane = bytes.data();
    for (std::size_t i = 0; i < size; ++i) {
      actual[i] |= std::uint64_t{static_cast<unsigned char>(plane[i])} << shift;
    }
    bytes.remove_prefix(size);
  }
  for (std::size_t i = 0; i < size; ++i) {
    actual[i] = predicted[i] + unfolded(actual[i]);
  }
  return true;
}

void put_poses(std::span<const RigidMotion> poses, std::string& bytes) {
  for (const RigidMotion& pose : poses) {
    bytes.append(reinterpret_cast<const char*>(pose.rotation.data()), 9 * sizeof(double));
    bytes.append(reinterpret_cast<const char*>(pose.translation_m.data()), 3 * sizeof(double));
  }
}

bool take_poses(std::string_view& bytes, std::size_t bones, std::vector<RigidMotion>& poses) {
  if (bytes.size() / pose_bytes < bones) {
    return false;
  }
  poses.resize(bones);
  for (RigidMotion& pose : poses) {
    std::memcpy(pose.rotation.data(), bytes.data(), 9 * sizeof(double));
    std::memcpy(pose.translation_m.data(), bytes.data() + 9 * sizeof(double), 3 * sizeof(double));
    bytes.remove_prefix(pose_bytes);
  }
  return true;
}

std::size_t coordinates_of(const RecordingHeader& header) { return 3 * static_cast<std::size_t>(header.nodes); }

}  // namespace

StepPredictor::StepPredictor(std::size_t coordinates, int iterations)
    : m_lag(static_cast<std::size_t>(iterations <= longest_lag ? iterations : 1)), m_last(coordinates, 0) {}

void StepPredictor::predict(const Coordinates& from, int order, Coordinates& predicted) const {
  predicted = from;
  const std::size_t known = m_displacements.size();
  if (order == 0 || known < m_lag) {
    return;
  }
  const Coordinates& recent = m_displacements[known - m_lag];
  if (order == 1 || known < 2 * m_lag) {
    for (std::size_t i = 0; i < from.size(); ++i) {
      predicted[i] += recent[i];
    }
    return;
  }
  const Coordinates& earlier = m_displacements[known - 2 * m_lag];
  for (std::size_t i = 0; i < from.size(); ++i) {
    predicted[i] += 2 * recent[i] - earlier[i];
  }
}

void StepPredictor::advance(const Coordinates& from, const Coordinates& positions) {
  Coordinates displacement;
  if (m_displacements.size() == 2 * m_lag) {
    displacement = std::move(m_displacements.front());
    m_displacements.pop_front();
  }
  displacement.resize(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    displacement[i] = positions[i] - from[i];
  }
  m_displacements.push_back(std::move(displacement));
  m_last = positions;
}

StepEncoder::StepEncoder(const RecordingHeader& header)
    : m_steps_per_m(1 / header.rounding_m),
      m_iterations(header.iterations),
      m_muscle_contact(header.muscle_contact),
      m_predictor(coordinates_of(header), header.iterations) {}

bool StepEncoder::encode(std::span<const Vec3> substep_start, std::span<const RigidMotion> previous_bone_poses,
                         std::span<const Vec3> positions, std::span<const RigidMotion> bone_poses, std::string& bytes,
                         std::span<const Vec3> muscle_positions) {
  const bool new_substep = m_steps % m_iterations == 0;
  if (!round(positions, m_positions) || (new_substep && !round(substep_start, m_start))) {
    return false;
  }
  assert(muscle_positions.size() == (m_muscle_contact ? positions.size() : 0));
  if (m_muscle_contact && !round(muscle_positions, m_muscle_positions)) {
    return false;
  }
  if (new_substep) {
    put_poses(previous_bone_poses, bytes);
    put_poses(bone_poses, bytes);
    put_differences(m_start, m_predictor.last(), bytes);
  }
  const Coordinates& from = new_substep ? m_start : m_predictor.last();
  const int order = best_order(from, m_positions);
  bytes += static_cast<char>(order);
  m_predictor.predict(from, order, m_predicted);
  put_differences(m_positions, m_predicted, bytes);
  if (m_muscle_contact) put_differences(m_muscle_positions, m_positions, bytes);  // most nodes are in no other muscle
  m_predictor.advance(from, m_positions);
  ++m_steps;
  return true;
}

bool StepEncoder::round(std::span<const Vec3> points, Coordinates& rounded) const {
  rounded.resize(3 * points.size());
  std::size_t next = 0;
  for (const Vec3& point : points) {
    for (const double coordinate_m : point) {
      const double steps = std::nearbyint(coordinate_m * m_steps_per_m);
      if (!(std::abs(steps) < largest_coordinate)) {
        return false;
      }
      rounded[next++] = static_cast<std::uint64_t>(static_cast<std::int64_t>(steps));
    }
  }
  return true;
}

/// The order whose differences have the fewest bits.
int StepEncoder::best_order(const Coordinates& from, const Coordinates& positions) {
  int best = 0;
  long fewest_bits = -1;
  for (int order = 0; order < StepPredictor::orders; ++order) {
    m_predictor.predict(from, order, m_predicted);
    long bits = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      bits += std::bit_width(folded(positions[i] - m_predicted[i]));
    }
    if (fewest_bits < 0 || bits < fewest_bits) {
      fewest_bits = bits;
      best = order;
    }
  }
  return best;
}

StepDecoder::StepDecoder(const RecordingHeader& header)
    : m_rounding_m(header.rounding_m),
      m_iterations(header.iterations),
      m_muscle_contact(header.muscle_contact),
      m_bones(static_cast<std::size_t>(header.bones)),
      m_predictor(coordinates_of(header), header.iterations) {}

bool StepDecoder::decode(std::string_view& bytes, RecordedStep& step) {
  const bool new_substep = m_steps % m_iterations == 0;
  if (new_substep && !(take_poses(bytes, m_bones, m_previous_poses) && take_poses(bytes, m_bones, m_poses) &&
                       take_differences(bytes, m_predictor.last(), m_start))) {
    return false;
  }
  const Coordinates& from = new_substep ? m_start : m_predictor.last();
  int order = 0;
  if (!take_byte(bytes, StepPredictor::orders - 1, order)) {
    return false;
  }
  m_predictor.predict(from, order, m_predicted);
  if (!take_differences(bytes, m_predicted, m_positions) ||
      (m_muscle_contact && !take_differences(bytes, m_positions, m_muscle_positions))) {
    return false;
  }
  m_predictor.advance(from, m_positions);
  ++m_steps;
  to_metres(m_start, step.substep_start);
  to_metres(m_positions, step.positions);
  to_metres(m_muscle_positions, step.muscle_positions);
  step.previous_bone_poses = m_previous_poses;
  step.bone_poses = m_poses;
  return true;
}

void StepDecoder::to_metres(const Coordinates& coordinates, std::vector<Vec3>& points) const {
  points.resize(coordinates.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      points[i][static_cast<Eigen::Index>(axis)] =
          static_cast<double>(static_cast<std::int64_t>(coordinates[3 * i + axis])) * m_rounding_m;
    }
  }
}

}  // namespace musclebench

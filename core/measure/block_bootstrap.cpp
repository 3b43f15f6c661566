#include "core/measure/block_bootstrap.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/percentile.hpp"

namespace musclebench {

namespace {

constexpr double block_frames = 10;
constexpr std::size_t draw_count = 2000;

/// SplitMix64 (Steele, Lea and Flood 2014): the n-th number of a stream without those before it.
std::uint64_t stream_number(std::uint64_t seed, std::uint64_t n) {
  std::uint64_t bits = seed + (n + 1) * 0x9e3779b97f4a7c15ULL;
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebULL;
  return bits ^ (bits >> 31);
}

/// Estimates of different values are drawn independently.
std::uint64_t seed_of(std::span<const double> values) {
  std::uint64_t seed = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    seed ^= stream_number(std::bit_cast<std::uint64_t>(values[i]), i);
  }
  return seed;
}

/// In values, which may be some of the motion's frames only.
std::size_t block_length(std::span<const int> frames) {
  std::vector<int> steps;
  for (std::size_t i = 1; i < frames.size(); ++i) steps.push_back(frames[i] - frames[i - 1]);
  const double spacing = steps.empty() ? 1.0 : std::max(1.0, median(steps));
  const auto length = static_cast<std::size_t>(std::max(1.0, std::nearbyint(block_frames / spacing)));
  return std::min(length, frames.size() / 3);
}

}  // namespace

MedianEstimate block_bootstrap_median(std::span<const int> frames, std::span<const double> values) {
  assert(!values.empty() && frames.size() == values.size() && std::ranges::is_sorted(frames));
  const std::size_t count = values.size();
  const double middle = median(std::vector<double>(values.begin(), values.end()));
  if (count < fewest_bootstrap_frames) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    return {middle, unknown, unknown};
  }
  const std::size_t length = block_length(frames);
  const std::size_t blocks = (count + length - 1) / length;
  const std::uint64_t seed = seed_of(values);
  std::vector<double> medians(draw_count);
  std::vector<double> drawn(count);
  for (std::size_t draw = 0; draw < draw_count; ++draw) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t start = stream_number(seed, draw * blocks + i / length) % count;
      drawn[i] = values[(start + i % length) % count];
    }
    medians[draw] = median(drawn);
  }
  return {middle, percentile(medians, 0.025), percentile(medians, 0.975)};
}

}  // namespace musclebench

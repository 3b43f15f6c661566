#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

namespace musclebench {

/// Random numbers that a seed fixes on every machine: the standard's distributions differ between libraries.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : m_generator(seed) {}

  /// Uniform in [0, 1).
  double share() { return static_cast<double>(m_generator() >> 11) * 0x1p-53; }
  /// Uniform in 0 .. count - 1; `count` > 0 and far below 2^64.
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(m_generator() % count); }

 private:
  std::mt19937_64 m_generator;
};

}  // namespace musclebench

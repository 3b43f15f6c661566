#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/contact.hpp"

namespace musclebench {

/// Depths of contacts over a whole run, m, in classes at most 1.6 % wide, so that millions of them take 40 kB.
class DepthHistogram {
 public:
  /// Takes what one frame left: the true depths, finite and >= 0, of the nodes inside at its end, and how many
  /// `contacts` the backend answered last, false ones too. As many as exceed the nodes inside count with a depth of 0.
  void add(std::span<const Contact> inside, int contacts) {
    for (const Contact& contact : inside) ++m_counts[class_of(contact.depth_m)];
    m_total += std::max(static_cast<long>(inside.size()), static_cast<long>(contacts));
  }

  /// The depth that a share of at most `1 - share` of all contacts exceeds (0.99: the 99th percentile), the middle of
  /// its class. Nothing without contacts.
  [[nodiscard]] std::optional<double> percentile(double share) const {
    if (m_total == 0) return std::nullopt;
    auto deeper = static_cast<long>(std::floor((1 - share) * static_cast<double>(m_total) + 1e-6));
    for (std::size_t i = m_counts.size(); i-- > 0;) {
      deeper -= m_counts[i];
      if (deeper < 0) return middle_of(i);
    }
    return 0;
  }

 private:
  static constexpr std::size_t classes_an_octave = 64;
  static constexpr int first_exponent = -59;  ///< of std::frexp: depths from 1e-18 m
  static constexpr int octaves = 80;

  /// No logarithm, whose last bit depends on the machine.
  static std::size_t class_of(double depth_m) {
    int exponent = 0;
    const double mantissa = std::frexp(depth_m, &exponent);  // 0.5 to 1
    if (!(depth_m > 0) || exponent < first_exponent) return 0;
    const auto octave = static_cast<std::size_t>(std::min(exponent - first_exponent, octaves - 1));
    return octave * classes_an_octave + static_cast<std::size_t>((mantissa - 0.5) * 2 * classes_an_octave);
  }
  static double middle_of(std::size_t index) {
    const double mantissa = 0.5 + (static_cast<double>(index % classes_an_octave) + 0.5) / (2.0 * classes_an_octave);
    return std::ldexp(mantissa, first_exponent + static_cast<int>(index / classes_an_octave));
  }

  std::vector<long> m_counts = std::vector<long>(octaves * classes_an_octave);
  long m_total = 0;
};

}  // namespace musclebench

#include "core/fibres/moment_arm.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Dense>

#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

namespace {

struct Slope {
  double value = 0;
  double error = 0;
};

/// At sample `at` of the parabola through samples from `first` to before `last`, three or more.
Slope parabola_slope(std::span<const double> angles, std::span<const double> lengths, std::size_t first,
                     std::size_t last, std::size_t at) {
  const auto count = static_cast<Eigen::Index>(last - first);
  const double reach = std::max(std::abs(angles[first] - angles[at]), std::abs(angles[last - 1] - angles[at]));
  Eigen::MatrixX3d powers(count, 3);
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double angle = (angles[first + static_cast<std::size_t>(i)] - angles[at]) / reach;
    powers.row(i) << 1, angle, angle * angle;
    values[i] = lengths[first + static_cast<std::size_t>(i)] - lengths[at];
  }
  const Eigen::Matrix3d inverse = (powers.transpose() * powers).inverse();
  const Eigen::Vector3d parabola = inverse * (powers.transpose() * values);
  const double scatter2 = count > 3 ? (values - powers * parabola).squaredNorm() / static_cast<double>(count - 3) : 0.0;
  return {parabola[1] / reach, std::sqrt(scatter2 * inverse(1, 1)) / reach};
}

/// What a slope is taken over: so many samples, or those within an angle where they are more.
struct Reach {
  std::size_t samples;
  double angle_rad;  ///< to either side
};
constexpr Reach wide_reach{7, 5 / degrees_per_radian};
constexpr Reach narrow_reach{5, 5.0 / 7 * wide_reach.angle_rad};

/// The samples about `at`, between `first` and `last`: as many as there are.
std::pair<std::size_t, std::size_t> window(std::span<const double> angles, std::size_t first, std::size_t last,
                                           std::size_t at, const Reach& reach) {
  const std::size_t count = std::min(reach.samples, last - first);
  std::size_t from = std::clamp(at, first + count / 2, last - count + count / 2) - count / 2;
  std::size_t to = from + count;
  const auto is_near = [&](std::size_t sample) { return std::abs(angles[sample] - angles[at]) <= reach.angle_rad; };
  while (from > first && is_near(from - 1)) --from;
  while (to < last && is_near(to)) ++to;
  return {from, to};
}

MomentArm arm_within(std::span<const double> angles, std::span<const double> lengths, std::size_t first,
                     std::size_t last, std::size_t at) {
  const auto [wide_first, wide_last] = window(angles, first, last, at, wide_reach);
  const auto [narrow_first, narrow_last] = window(angles, first, last, at, narrow_reach);
  const Slope wide = parabola_slope(angles, lengths, wide_first, wide_last, at);
  const Slope narrow = parabola_slope(angles, lengths, narrow_first, narrow_last, at);
  return {wide.value, std::hypot(wide.error, wide.value - narrow.value)};
}

}  // namespace

std::vector<std::optional<MomentArm>> moment_arms(std::span<const double> angles_rad,
                                                  std::span<const double> lengths_m) {
  std::vector<std::optional<MomentArm>> arms(angles_rad.size());
  const auto sense = [&](std::size_t i) {
    const double step = angles_rad[i + 1] - angles_rad[i];
    return step > 0 ? 1 : step < 0 ? -1 : 0;
  };
  for (std::size_t first = 0; first + 1 < angles_rad.size();) {
    std::size_t last = first + 1;
    while (last + 1 < angles_rad.size() && sense(last) == sense(first)) ++last;
    if (sense(first) != 0 && last - first >= 2) {
      for (std::size_t at = first; at <= last; ++at) {
        if (!arms[at]) arms[at] = arm_within(angles_rad, lengths_m, first, last + 1, at);
      }
    }
    first = last;
  }
  return arms;
}

}  // namespace musclebench

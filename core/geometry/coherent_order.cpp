#include "core/geometry/coherent_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

namespace musclebench {

namespace {

constexpr int bits_an_axis = 10;

/// The bits of three coordinates in turn.
std::uint32_t place_on_curve(const Vec3& share) {
  constexpr double cells = 1U << static_cast<unsigned>(bits_an_axis);
  std::uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::min(cells * share[axis], cells - 1);
    const std::uint32_t number = cell > 0 ? static_cast<std::uint32_t>(cell) : 0;
    for (int bit = 0; bit < bits_an_axis; ++bit) {
      code |= (number >> bit & 1U) << (3 * bit + axis);
    }
  }
  return code;
}

}  // namespace

std::vector<int> coherent_order(std::span<const Vec3> positions, std::span<const int> nodes) {
  const auto position = [&](int place) -> const Vec3& {
    return positions[static_cast<std::size_t>(nodes[static_cast<std::size_t>(place)])];
  };
  std::vector<int> as_they_are(nodes.size());
  std::iota(as_they_are.begin(), as_they_are.end(), 0);
  Eigen::AlignedBox3d box;
  for (const int place : as_they_are) {
    if (position(place).allFinite()) {
      box.extend(position(place));
    }
  }
  const double extent = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  if (!(extent > 0 && std::isfinite(extent))) {
    return as_they_are;
  }
  std::vector<std::pair<std::uint32_t, int>> by_code;
  by_code.reserve(nodes.size());
  for (const int place : as_they_are) {
    const bool finite = position(place).allFinite();
    by_code.emplace_back(finite ? place_on_curve((position(place) - box.min()) / extent) : 0, place);
  }
  std::sort(by_code.begin(), by_code.end());
  std::vector<int> along_curve;
  along_curve.reserve(nodes.size());
  for (const auto& [code, place] : by_code) {
    along_curve.push_back(place);
  }
  const auto way = [&](const std::vector<int>& order) {
    double sum = 0;
    for (std::size_t i = 1; i < order.size(); ++i) {
      const double step = ((position(order[i]) - position(order[i - 1])) / extent).norm();
      sum += std::isfinite(step) ? step : 0;
    }
    return sum;
  };
  return way(along_curve) < way(as_they_are) ? along_curve : as_they_are;
}

}  // namespace musclebench

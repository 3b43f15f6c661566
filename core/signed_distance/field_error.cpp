#include "core/signed_distance/field_error.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/base/percentile.hpp"

namespace musclebench {

FieldError estimate_error(const SignedSurface& surface, const FieldErrorSamples& wanted, const FieldValue& value) {
  std::mt19937_64 generator(wanted.seed);
  const auto unit = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  FieldError result;
  std::vector<double> errors;
  // A surface fills enough of its own box for this many tries; the limit only keeps odd shapes from an endless loop.
  for (long tries = 0; std::ssize(errors) < wanted.count && tries < 1000L * wanted.count; ++tries) {
    const Vec3 share(unit(), unit(), unit());
    const Vec3 point = wanted.box.min() + share.cwiseProduct(wanted.box.sizes());
    const std::optional<double> approximate = value(point);
    const std::optional<double> exact = approximate ? surface.distance(point, wanted.reach_m) : std::nullopt;
    if (!exact) {
      continue;
    }
    errors.push_back(std::abs(*exact - *approximate));
    result.mean_m += errors.back();
    if ((*exact < 0) != (*approximate < 0)) {
      ++result.wrong_signs;
      result.deepest_wrong_sign_m = std::max(result.deepest_wrong_sign_m, std::abs(*exact));
    }
  }
  if (errors.empty()) {
    return result;
  }
  std::sort(errors.begin(), errors.end());
  result.samples = static_cast<int>(errors.size());
  result.largest_m = errors.back();
  result.p99_m = errors[percentile_index(errors.size(), 0.99)];
  result.mean_m /= static_cast<double>(errors.size());
  return result;
}

}  // namespace musclebench

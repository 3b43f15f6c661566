#include "core/base/quantity_words.hpp"

#include <fmt/format.h>

namespace musclebench {

std::string in_percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

std::string in_millimetres(double length_m) { return fmt::format("{:.3g} mm", 1e3 * length_m); }

}  // namespace musclebench

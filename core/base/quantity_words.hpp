#pragma once

#include <string>

namespace musclebench {

/// "1.23 %", of a share.
std::string in_percent(double share);
/// "0.123 mm"
std::string in_millimetres(double length_m);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <string_view>

#include "bench/cases/case.hpp"

namespace musclebench {

/// Throws InputError where `folder` holds the result of another case, which would be replaced: another scene, preset,
/// backend or parameter. The same case of another build or of changed input files may be replaced. `mode`: as in
/// json_of_case.
void require_no_other_case(const std::filesystem::path& folder, const Case& resolved, std::string_view mode);

}  // namespace musclebench

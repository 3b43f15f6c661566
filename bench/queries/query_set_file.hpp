#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/measure/contact_sites.hpp"
#include "datasets/queries/query_set.hpp"

namespace musclebench {

/// `QuerySet::difficulty` of a point that no node was at; else a ContactDifficulty.
constexpr std::int32_t around_the_bone = static_cast<std::int32_t>(contact_difficulties.size());

/// The name of a difficulty in a query set.
std::string_view difficulty_name(std::int32_t difficulty);

/// As datasets/queries/README.md describes it, as a whole or not at all. Returns the hash that it ends in. Throws
/// InputError where the file can't be written.
std::string write_query_set(const std::filesystem::path& path, const QuerySet& set);

/// Throws InputError where the file is none, is cut off or was changed, or where an index in it is out of range.
QuerySet read_checked_query_set(const std::filesystem::path& path);

/// Signed distances to the queries' bones, in metres: little-endian doubles without a head, in the order of the set,
/// NaN where there is no answer. Throws InputError where the file has another number of them.
std::vector<double> read_answers(const std::filesystem::path& path, const QuerySet& set);

}  // namespace musclebench

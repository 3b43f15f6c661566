#include "bench/results/other_case.hpp"

#include <fmt/format.h>

#include "bench/results/manifest.hpp"
#include "bench/results/result_folder.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

/// The first key that both have and that differs; empty for none. Another build may know other keys.
std::string differing_key(const Json& mine, const Json& theirs) {
  for (const auto& [key, value] : mine.items()) {
    if (!theirs.contains(key) || theirs[key] == value) {
      continue;
    }
    std::string inner = value.is_object() && theirs[key].is_object() ? differing_key(value, theirs[key]) : key;
    if (!inner.empty()) {
      return inner;
    }
  }
  return {};
}

std::string text_at(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : "unknown";
}

}  // namespace

void require_no_other_case(const std::filesystem::path& folder, const Case& resolved, std::string_view mode) {
  const Json manifest = read_manifest(folder);
  if (!manifest.is_object() || !manifest.contains("case") || !manifest["case"].is_object()) {
    return;
  }
  const Json& theirs = manifest["case"];
  const std::string key = differing_key(Json::parse(text_of(json_of_case(resolved, mode))), theirs);
  if (!key.empty()) {
    throw InputError(folder.string(),
                     fmt::format("holds the result of another case ({} with {}, differing in '{}'); choose another "
                                 "--out, or replace it with --force",
                                 text_at(theirs, "scene"), text_at(theirs, "backend"), key));
  }
}

}  // namespace musclebench

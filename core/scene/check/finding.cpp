#include "core/scene/check/finding.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace musclebench {

namespace {

std::string_view beginning_of(FindingKind kind) {
  switch (kind) {
    case FindingKind::cannot_act:
      return "can't act";
    case FindingKind::acts_in_part:
      return "acts in part";
    case FindingKind::contradiction:
      return "contradiction";
    default:
      return "the scene calls for";
  }
}

}  // namespace

std::string_view name_of(FindingKind kind) {
  switch (kind) {
    case FindingKind::cannot_act:
      return "cannot_act";
    case FindingKind::acts_in_part:
      return "acts_in_part";
    case FindingKind::contradiction:
      return "contradiction";
    default:
      return "lacking";
  }
}

std::string text_of(const Finding& finding) {
  std::string text = fmt::format("{} [{}]: {}{}{}: {}", beginning_of(finding.kind), finding.id, finding.place,
                                 finding.place.empty() ? "" : ": ", finding.where, finding.what);
  std::vector<std::string> cures;
  if (!finding.add.empty()) {
    // A table takes in all keys below it.
    const bool is_table = finding.add.front().starts_with('[');
    cures.push_back(fmt::format("add {}{}", fmt::join(finding.add, " "), is_table ? " at the end of the file" : ""));
  }
  if (!finding.remove.empty()) cures.push_back(fmt::format("remove {}", fmt::join(finding.remove, " ")));
  if (!cures.empty()) text += fmt::format("; {}", fmt::join(cures, ", or "));
  return text;
}

}  // namespace musclebench

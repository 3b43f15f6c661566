#pragma once

#include <optional>

#include "core/base/scoped_timer.hpp"

namespace musclebench {

/// Where structures come from: they were built, or found in a folder where an earlier build has kept them.
struct StructureOrigin {
  bool is_from_file = false;
  /// What that build took, where it is noted beside what it kept; the time of loading says nothing about it.
  std::optional<Nanoseconds> kept_build_ns = {};

  /// Of structures that only together do: from files where all are.
  [[nodiscard]] StructureOrigin with(const StructureOrigin& other) const {
    const bool are_both = is_from_file && other.is_from_file;
    const bool are_timed = are_both && kept_build_ns && other.kept_build_ns;
    return {are_both, are_timed ? std::optional(*kept_build_ns + *other.kept_build_ns) : std::nullopt};
  }
};

}  // namespace musclebench

#pragma once

#include <optional>

#include "core/base/scoped_timer.hpp"

namespace musclebench {

/// Where a backend's structures come from: this process built them, or read them from files of an earlier build.
struct StructureOrigin {
  bool is_from_file = false;
  /// Duration of the earlier build, if the files contain it. The time of loading says nothing about it.
  std::optional<Nanoseconds> kept_build_ns = {};

  /// The origin of two structures that are needed together. They are from files only if both are.
  [[nodiscard]] StructureOrigin with(const StructureOrigin& other) const {
    const bool are_both = is_from_file && other.is_from_file;
    const bool are_timed = are_both && kept_build_ns && other.kept_build_ns;
    return {are_both, are_timed ? std::optional(*kept_build_ns + *other.kept_build_ns) : std::nullopt};
  }
};

}  // namespace musclebench

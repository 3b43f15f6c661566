#pragma once

#include <span>
#include <string_view>

namespace musclebench {

/// A text file of `datasets/` that the program carries with it.
struct EmbeddedFile {
  std::string_view name;  ///< without ending: "synthetic/iliacus", "paper"
  std::string_view text;
};

/// The scene files of `datasets/scenes`.
std::span<const EmbeddedFile> embedded_scenes();

/// The preset files of `datasets/presets`.
std::span<const EmbeddedFile> embedded_presets();

}  // namespace musclebench

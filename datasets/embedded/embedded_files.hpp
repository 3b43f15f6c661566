#pragma once

#include <span>
#include <string_view>

namespace musclebench {

/// A text file of `datasets/` that the program carries with it.
struct EmbeddedFile {
  std::string_view name;    ///< without ending: "synthetic/iliacus", "paper"
  std::string_view folder;  ///< below `datasets`: of the meshes that it names beside it; empty: it names none
  std::string_view text;
};

/// The scene files of `datasets/scenes`, of the effects' folders, and of the data sets that come with the project.
std::span<const EmbeddedFile> embedded_scenes();

/// The preset files of `datasets/presets`.
std::span<const EmbeddedFile> embedded_presets();

/// The folder `datasets` of the sources that the program was built from. It may be gone since.
std::string_view datasets_of_build();

}  // namespace musclebench

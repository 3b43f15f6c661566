#pragma once

#include <string>

namespace musclebench {

/// One thing that is odd about a scene that can be run all the same.
struct SceneWarning {
  std::string rule;  ///< stable, such as "unit"
  std::string text;  ///< one line
};

}  // namespace musclebench

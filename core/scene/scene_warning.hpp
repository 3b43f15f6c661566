#pragma once

#include <string>

namespace musclebench {

/// A warning about a scene that can still be run.
struct SceneWarning {
  std::string rule;  ///< name of the rule, such as "unit"; it does not change between versions
  std::string text;  ///< one line
};

}  // namespace musclebench

#pragma once

#include <string>

namespace musclebench {

/// Fibres that a command line asks for.
struct FibreRequest {
  int count = 0;            ///< of each muscle; 0: none
  std::string option = {};  ///< that asks, for messages
  bool is_required = true;  ///< false: the scene may go without (`Scene::fibres_refused`)
};

}  // namespace musclebench

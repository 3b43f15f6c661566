#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {

/// What the reader complains of; "no error" where it takes the scene.
inline std::string error_of(const SceneRequest& request) {
  try {
    (void)read_scene(request);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

inline void expect_mentions(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(text.find(word), std::string::npos) << "'" << word << "' is not in: " << text;
  }
}

}  // namespace musclebench

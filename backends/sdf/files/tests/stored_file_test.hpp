#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/temporary_folder.hpp"

namespace musclebench {

/// A file in a folder of its own, which goes with the test.
class StoredFileTest : public testing::Test {
 protected:
  explicit StoredFileTest(const std::string& path_in_folder) : m_path(m_folder / path_in_folder) {}

  void change(const std::function<void(std::string&)>& edit) const {
    std::ifstream in(m_path, std::ios::binary);
    std::string content((std::istreambuf_iterator<char>(in)), {});
    in.close();
    edit(content);
    std::ofstream(m_path, std::ios::binary) << content;
  }

  /// Why `load` refuses the file: one line that begins with its path. "accepted" where it does not.
  [[nodiscard]] std::string refusal_by(const std::function<void()>& load) const {
    try {
      load();
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      EXPECT_EQ(std::string(error.what()).find(m_path.string()), 0U) << error.what();
      return error.what();
    }
    return "accepted";
  }

  TemporaryFolder m_folder;
  std::filesystem::path m_path;
};

}  // namespace musclebench

#include "core/base/atomic_file.hpp"

#include <cstddef>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/temporary_folder.hpp"

namespace musclebench {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
 protected:
  static std::string text_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// Names in the folder.
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(m_folder.path()), fs::directory_iterator()));
  }

  TemporaryFolder m_folder;
};

TEST_F(AtomicFile, IsWrittenWholeIntoAFolderThatIsCreated) {
  const fs::path path = m_folder / "made" / "a.bin";
  write_atomically(path, [](std::ostream& out) { out << "one\n"; });
  EXPECT_EQ(text_of(path), "one\n");
  write_atomically(path, [](std::ostream& out) { out << "two"; });
  EXPECT_EQ(text_of(path), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(path.parent_path()), fs::directory_iterator()), 1);
}

TEST_F(AtomicFile, ThatIsNotFinishedLeavesWhatWasThere) {
  const fs::path path = m_folder / "a.bin";
  write_atomically(path, [](std::ostream& out) { out << "before"; });
  EXPECT_THROW(write_atomically(path,
                                [](std::ostream& out) {
                                  out << "half";
                                  throw std::runtime_error("stopped");
                                }),
               std::runtime_error);
  EXPECT_THROW(write_atomically(path,
                                [](std::ostream& out) {
                                  out << "half";
                                  out.setstate(std::ios::badbit);  // as on a full disk
                                }),
               InputError);
  EXPECT_EQ(text_of(path), "before");
  EXPECT_EQ(files(), 1U);
}

TEST_F(AtomicFile, IsNotFoundWhileItIsWritten) {
  const fs::path path = m_folder / "a.bin";
  write_atomically(path, [&](std::ostream& out) {
    out << "half" << std::flush;
    EXPECT_FALSE(fs::exists(path));
  });
  EXPECT_TRUE(fs::exists(path));
}

TEST_F(AtomicFile, NamesThePathThatCannotBeWritten) {
  fs::create_directories(m_folder / "folder" / "full");
  try {
    write_atomically(m_folder / "folder", [](std::ostream& out) { out << "text"; });
    ADD_FAILURE() << "a folder was replaced";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find((m_folder / "folder").string()), std::string::npos) << error.what();
  }
  EXPECT_EQ(files(), 1U);
}

}  // namespace
}  // namespace musclebench

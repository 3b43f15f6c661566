// Replays the corpus that libFuzzer starts from through the same functions. A file named refused_* has to be refused,
// any other has to be read: a corpus that a reader does not understand would start nowhere.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/fuzz/fuzzed_reader.hpp"

namespace musclebench {

static void PrintTo(const FuzzedReader& reader, std::ostream* out) { *out << reader.name; }  // NOLINT: GoogleTest's

namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string name_of(const testing::TestParamInfo<FuzzedReader>& info) { return std::string(info.param.name); }

class CorpusOf : public testing::TestWithParam<FuzzedReader> {
 protected:
  /// Name and bytes of all files, those that the program makes among them.
  [[nodiscard]] static std::vector<std::pair<std::string, std::string>> files() {
    std::vector<std::pair<std::string, std::string>> files;
    if (const fs::path folder = fs::path(MUSCLEBENCH_CORPUS) / GetParam().name; fs::is_directory(folder)) {
      for (const auto& file : fs::directory_iterator(folder)) {
        files.emplace_back(file.path().filename().string(), content_of(file.path()));
      }
    }
    if (GetParam().make_seeds != nullptr) {
      for (std::string& seed : GetParam().make_seeds()) files.emplace_back("a seed that is made", std::move(seed));
    }
    return files;
  }
};

TEST_P(CorpusOf, IsReadOrRefusedAsItsNameSays) {
  std::size_t read = 0;
  for (const auto& [name, bytes] : files()) {
    const bool is_refused = name.starts_with("refused_");
    EXPECT_EQ(reads(GetParam(), bytes), !is_refused) << name;
    read += is_refused ? 0 : 1;
  }
  EXPECT_GT(read, 0U) << "nothing to start from";
}

TEST_P(CorpusOf, SurvivesBeingCutAndChanged) {
  for (const auto& [name, bytes] : files()) {
    for (const std::size_t share : {1, 2, 3}) {
      const std::size_t offset = bytes.size() * share / 4;
      EXPECT_NO_THROW((void)reads(GetParam(), std::string_view(bytes).substr(0, offset))) << name;
      std::string changed = bytes;
      changed[offset] = static_cast<char>(changed[offset] ^ '\x40');
      EXPECT_NO_THROW((void)reads(GetParam(), changed)) << name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Corpus, CorpusOf, testing::ValuesIn(fuzzed_readers().begin(), fuzzed_readers().end()),
                         name_of);

}  // namespace
}  // namespace musclebench

#include "backends/sdf/files/kept_fields.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "core/base/temporary_folder.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// A field that is a number, kept as text.
class KeptFieldsTest : public testing::Test {
 protected:
  KeptFields<int>::Found found(const std::string& built_with, double radius_m) {
    const KeptFields<int> kept{
        [&] { return ++m_built; },
        [](const std::filesystem::path& path, const std::string&) -> std::optional<int> {
          std::ifstream in(path);
          int value = 0;
          return in >> value ? std::optional(value) : std::nullopt;
        },
        [](int field, const std::filesystem::path& path, const std::string&) { std::ofstream(path) << field; }};
    return kept.load_or_build(m_folder, built_with, "field", {make_sphere(radius_m, 1), true, {}}, 1);
  }

  TemporaryFolder m_temporary;
  std::filesystem::path m_folder = m_temporary.path();
  int m_built = 0;
};

TEST_F(KeptFieldsTest, BuildsEachOnceByWhatItIsAndOfWhat) {
  for (const bool again : {false, true}) {
    EXPECT_EQ(found("8cells", 0.1).field, 1);
    EXPECT_EQ(found("16cells", 0.1).field, 2);
    EXPECT_EQ(found("8cells", 0.2).field, 3);
    EXPECT_EQ(found("8cells", 0.1).origin.is_from_file, true) << again;
  }
  EXPECT_EQ(m_built, 3);
}

TEST_F(KeptFieldsTest, NotesWhatBuildingTook) {
  EXPECT_FALSE(found("8cells", 0.1).origin.kept_build_ns) << "it is the run's own";
  const std::filesystem::path path =
      m_folder / content_address("8cells", surface_digest({make_sphere(0.1, 1), true, {}}), "field");
  note_build(path, 123'456'789'012, 4);
  EXPECT_EQ(found("8cells", 0.1).origin.kept_build_ns, 123'456'789'012);
  for (const char* damaged : {"", "{", "[]", "{\"build_ns\": -1}", "{\"build_ns\": \"soon\"}"}) {
    std::ofstream(path.string() + ".json") << damaged;
    EXPECT_FALSE(found("8cells", 0.1).origin.kept_build_ns) << damaged;
    EXPECT_TRUE(found("8cells", 0.1).origin.is_from_file) << "the field itself is there";
  }
}

TEST_F(KeptFieldsTest, OnlyBuildsWithoutAFolder) {
  m_folder.clear();
  EXPECT_EQ(found("8cells", 0.1).field, 1);
  EXPECT_EQ(found("8cells", 0.1).field, 2);
}

}  // namespace
}  // namespace musclebench

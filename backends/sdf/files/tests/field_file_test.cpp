#include "backends/sdf/files/field_file.hpp"

#include <fstream>
#include <functional>
#include <iterator>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/files/tests/stored_file_test.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

class FieldFile : public StoredFileTest {
 protected:
  FieldFile() : StoredFileTest("deep/bone.field") {}

  [[nodiscard]] std::string refusal(const std::string& digest, const GridShape& shape) const {
    return refusal_by([&] { (void)load_field(m_path, digest, shape); });
  }
  [[nodiscard]] std::string refusal() const { return refusal(m_digest, m_shape); }

  void expect_refusal_of_change(const std::string& words, const std::function<void(std::string&)>& edit) const {
    save_field(m_field, m_digest, m_path);
    change(edit);
    EXPECT_NE(refusal().find(words), std::string::npos) << refusal();
  }

  RepairedMesh m_bone{make_sphere(0.1, 2), true, {}};
  GridShape m_shape = grid_over(m_bone.mesh, {.cells = 6}, "sphere");
  std::string m_digest = surface_digest(m_bone);
  CubicField m_field = build_field(SignedSurface(m_bone), m_shape, 1);
};

TEST_F(FieldFile, ComesBackAsItWas) {
  EXPECT_FALSE(load_field(m_path, m_digest, m_shape));
  save_field(m_field, m_digest, m_path);
  const std::optional<CubicField> loaded = load_field(m_path, m_digest, m_shape);
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->values(), m_field.values());
  EXPECT_EQ(loaded->mask(), m_field.mask());
  EXPECT_EQ(loaded->shape(), m_field.shape());
  EXPECT_EQ(loaded->bytes(), m_field.bytes());
  EXPECT_EQ(loaded->facts().lipschitz_bound, m_field.facts().lipschitz_bound);
  EXPECT_EQ(loaded->facts().error.p99_m, m_field.facts().error.p99_m);
  EXPECT_GT(loaded->facts().error.samples, 0);
  for (const double x : {0.0, 0.3, 0.7, 0.99, 1.001}) {
    EXPECT_EQ(loaded->value({x, 0.1, -0.2}), m_field.value({x, 0.1, -0.2}));
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(m_path.parent_path()), {}), 1) << "something is left";
}

TEST_F(FieldFile, OfAnotherSurfaceIsRefused) {
  save_field(m_field, m_digest, m_path);
  RepairedMesh other = m_bone;
  other.mesh.vertices[3].x() += 1e-15;
  EXPECT_NE(refusal(surface_digest(other), m_shape).find("another surface"), std::string::npos);
  other = m_bone;
  other.clean = false;
  EXPECT_NE(refusal(surface_digest(other), m_shape).find("another surface"), std::string::npos);
}

TEST_F(FieldFile, OfOtherParametersIsRefused) {
  save_field(m_field, m_digest, m_path);
  const GridShape finer = grid_over(m_bone.mesh, {.cells = 7}, "sphere");
  EXPECT_NE(refusal(m_digest, finer).find("6 x 6 x 6 cells, wanted are 7 x 7 x 7"), std::string::npos);
  const GridShape wider = grid_over(m_bone.mesh, {.cells = 6, .margin = 0.1}, "sphere");
  EXPECT_NE(refusal(m_digest, wider).find("another box"), std::string::npos);
}

TEST_F(FieldFile, ThatIsDamagedIsRefused) {
  expect_refusal_of_change("too short", [](std::string& content) { content.resize(50); });
  expect_refusal_of_change("too short", [](std::string& content) { content.clear(); });
  expect_refusal_of_change("not a field file", [](std::string& content) { content[0] = 'x'; });
  expect_refusal_of_change("byte order", [](std::string& content) { std::swap(content[8], content[11]); });
  expect_refusal_of_change("format version 1", [](std::string& content) { content[12] = 1; });
  expect_refusal_of_change("truncated", [](std::string& content) { content.pop_back(); });
  expect_refusal_of_change("goes on", [](std::string& content) { content += '\0'; });
  for (const double share : {0.3, 0.6, 0.9999}) {
    expect_refusal_of_change("checksum", [&](std::string& content) {
      content[static_cast<std::size_t>(share * static_cast<double>(content.size()))] ^= 4;
    });
  }
}

TEST_F(FieldFile, ThatIsNoRegularFileIsRefused) {
  std::filesystem::create_directories(m_path.parent_path());
  ASSERT_EQ(mkfifo(m_path.c_str(), 0600), 0);
  EXPECT_NE(refusal().find("is no regular file"), std::string::npos) << refusal();
}

TEST_F(FieldFile, ThatCannotBeWrittenIsAnError) {
  std::filesystem::create_directories(m_folder.path());
  std::ofstream(m_folder / "deep") << "a file where the folder should be";
  EXPECT_THROW(save_field(m_field, m_digest, m_path), InputError);
}

}  // namespace
}  // namespace musclebench

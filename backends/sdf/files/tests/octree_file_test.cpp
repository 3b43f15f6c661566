#include "backends/sdf/files/octree_file.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>

#include <gtest/gtest.h>

#include "backends/sdf/files/field_file.hpp"
#include "backends/sdf/files/tests/stored_file_test.hpp"
#include "backends/sdf/octree/octree_entry.hpp"
#include "backends/sdf/octree/octree_polynomial.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

class OctreeFile : public StoredFileTest {
 protected:
  OctreeFile() : StoredFileTest("deep/bone.octree") { save_octree(m_field, m_digest, m_settings, m_path); }

  [[nodiscard]] std::string refusal(const std::string& digest, const OctreeSettings& settings) const {
    return refusal_by([&] { (void)load_octree(m_path, digest, settings); });
  }
  void expect_refusal(const std::string& words, const std::function<void(std::string&)>& edit) const {
    save_octree(m_field, m_digest, m_settings, m_path);
    change(edit);
    EXPECT_NE(refusal(m_digest, m_settings).find(words), std::string::npos) << refusal(m_digest, m_settings);
  }

  RepairedMesh m_bone{make_sphere(0.1, 2), true, {}};
  OctreeSettings m_settings{.max_error_m = 1e-3};
  std::string m_digest = surface_digest(m_bone);
  OctreeField m_field = build_octree(SignedSurface(m_bone), m_bone.mesh, m_settings, "ball", 1);
};

TEST_F(OctreeFile, ComesBackAsItWas) {
  const OctreeField read = load_octree(m_path, m_digest, m_settings).value();
  EXPECT_EQ(read.entries(), m_field.entries());
  EXPECT_EQ(read.coefficients(), m_field.coefficients());
  EXPECT_EQ(std::memcmp(&read.quality(), &m_field.quality(), sizeof(OctreeQuality)), 0);
  const Vec3 point(0.07, 0.06, 0.03);
  EXPECT_EQ(read.value(point), m_field.value(point));
  EXPECT_EQ(read.leaf_count(), m_field.leaf_count());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(m_path.parent_path()), {}), 1) << "nothing else is left";
}

TEST_F(OctreeFile, IsNothingWhereThereIsNone) {
  EXPECT_FALSE(load_octree(m_folder / "none.octree", m_digest, m_settings));
}

TEST_F(OctreeFile, SaysWhatDiffers) {
  EXPECT_NE(refusal(surface_digest({make_sphere(0.1, 3), true, {}}), m_settings).find("another surface"),
            std::string::npos);
  EXPECT_NE(refusal(m_digest, {.max_error_m = 2e-3}).find("built to 1 mm, wanted is 2"), std::string::npos);
  EXPECT_NE(refusal(m_digest, {.max_error_m = 1e-3, .margin = 0.1}).find("another margin"), std::string::npos);
}

TEST_F(OctreeFile, RefusesWhatIsDamaged) {
  expect_refusal("not an adaptive field's", [](std::string& content) { content[0] = 'x'; });
  expect_refusal("another byte order", [](std::string& content) { std::swap(content[8], content[11]); });
  expect_refusal("format version 9", [](std::string& content) { content[12] = 9; });
  expect_refusal("too short", [](std::string& content) { content.resize(100); });
  expect_refusal("truncated", [](std::string& content) { content.resize(content.size() - 4); });
  expect_refusal("goes on after its end", [](std::string& content) { content += "more"; });
  expect_refusal("checksum", [](std::string& content) { content.back() ^= 1; });
  expect_refusal("checksum", [](std::string& content) { content[60] ^= 1; });
}

/// Whose checksum fits.
TEST_F(OctreeFile, RefusesWhatIsNoTree) {
  const auto expect_no_tree = [&](const auto& change_parts) {
    OctreeShape shape = m_field.shape();
    OctreeQuality quality = m_field.quality();
    std::vector<std::uint32_t> entries = m_field.entries();
    std::vector<float> coefficients = m_field.coefficients();
    change_parts(shape, quality, entries, coefficients);
    save_octree(OctreeField(shape, quality, entries, coefficients), m_digest, m_settings, m_path);
    EXPECT_NE(refusal(m_digest, m_settings).find("does not hold an octree"), std::string::npos)
        << refusal(m_digest, m_settings);
  };
  using octree_entry::Kind;
  expect_no_tree([](auto&, auto&, auto& entries, auto&) {
    entries.back() = octree_entry::entry(Kind::split, entries.size() - 7);
  });
  expect_no_tree([](auto&, auto&, auto& entries, auto&) { entries.back() = octree_entry::entry(Kind::split, 0); });
  expect_no_tree([](auto&, auto&, auto& entries, auto& coefficients) {
    entries.back() = octree_entry::entry(Kind::outside, coefficients.size() - 19);
  });
  expect_no_tree(
      [](auto&, auto&, auto&, auto& coefficients) { coefficients.resize(coefficients.size() - cubic_terms - 1); });
  expect_no_tree([](auto&, auto&, auto&, auto& coefficients) { coefficients[3] = std::nanf(""); });
  expect_no_tree([](auto&, auto& quality, auto&, auto&) { quality.excess_m = -1; });
  expect_no_tree([](auto& shape, auto&, auto&, auto&) { shape.roots[1] = 1 << 30; });
  expect_no_tree([](auto& shape, auto&, auto&, auto&) { shape.root_edge_m = 0; });
}

TEST_F(OctreeFile, LeavesNothingBehindWhereItCannotWrite) {
  EXPECT_THROW(save_octree(m_field, m_digest, m_settings, m_path / "below a file"), InputError);
}

}  // namespace
}  // namespace musclebench

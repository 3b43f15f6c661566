#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <toml++/toml.h>

#include "core/bvh/triangle_bvh.hpp"
#include "datasets/synthetic_hip.hpp"

namespace musclebench {

namespace {

Vec3 point_of(const toml::node& node) {
  const toml::array& row = *node.as_array();
  return {row[0].value_or(1e9), row[1].value_or(1e9), row[2].value_or(1e9)};
}

}  // namespace

// The scenes hold coordinates of points on surfaces that code makes: a change of a bone has to renew them.
TEST(SyntheticScenes, AttachmentOutlinesLieOnTheirBones) {
  const std::filesystem::path folder = std::filesystem::path(MUSCLEBENCH_SOURCE_DIR) / "datasets/scenes/synthetic";
  std::map<std::string, TriangleBvh> bones;
  bones.emplace("hip_bone", TriangleBvh(synthetic_hip_mesh("hip_bone")));
  bones.emplace("femur", TriangleBvh(synthetic_hip_mesh("femur")));
  for (const std::string muscle : {"adductor_brevis", "gluteus_maximus", "gluteus_medius", "iliacus"}) {
    SCOPED_TRACE(muscle);
    const toml::table scene = toml::parse_file((folder / (muscle + ".toml")).string());
    EXPECT_EQ(scene["muscle"]["mesh"].value_or(std::string()), "synthetic:" + muscle);
    const toml::array* attachments = scene["attachment"].as_array();
    ASSERT_NE(attachments, nullptr);
    ASSERT_EQ(attachments->size(), 2U);
    for (const toml::node& attachment : *attachments) {
      const toml::table& table = *attachment.as_table();
      const std::string bone = table["bone"].value_or(std::string());
      const toml::array* outline = table["outline_m"].as_array();
      ASSERT_NE(outline, nullptr);
      EXPECT_GE(outline->size(), 5U);
      for (const toml::node& point : *outline) {
        const Vec3 corner = point_of(point);
        EXPECT_TRUE(bones.at(bone).closest_point(corner, 0.0003).has_value()) << bone << ": " << corner.transpose();
      }
    }
  }
}

}  // namespace musclebench

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/scene/tests/scene_errors.hpp"

namespace musclebench {
namespace {

/// A tube along z, 10 mm thick, beside a block.
SceneRequest with_ring(const std::string& ring, const std::string& more = "") {
  SceneRequest request;
  request.name = "test";
  request.file = "test.toml";
  request.text = more +
                 "[[bone]]\nname = \"block\"\nmesh = \"synthetic:block\"\n"
                 "[muscle]\nname = \"tube\"\nmesh = \"synthetic:tube\"\n[[retinaculum]]\n" +
                 ring;
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "tube") return make_capsule(0.005, 0.05, 24);
    TriangleMesh block = make_box(Vec3(0.01, 0.01, 0.01), 1);
    for (Vec3& at : block.vertices) at.x() += 0.03;
    return block;
  };
  return request;
}

const std::string place = "name = \"strap\"\nbone = \"block\"\ncentre_m = [0, 0, 0.01]\naxis = [0, 0, 2]\n";

TEST(ReadRetinacula, ARingHasAPlaceASizeAndTheNodesThatRunThroughIt) {
  const Scene scene = read_scene(with_ring(place + "radius_m = 0.006\nslide_m = 0.02\n"));
  ASSERT_EQ(scene.retinacula.size(), 1U);
  const Retinaculum& ring = scene.retinacula[0];
  EXPECT_EQ(ring.name, "strap");
  EXPECT_EQ(ring.bone, 0);
  EXPECT_EQ(ring.axis, Vec3(0, 0, 1));
  EXPECT_EQ(ring.half_width_m, 0.006);
  ASSERT_FALSE(ring.nodes.empty());
  for (const int node : ring.nodes) {
    const double z = scene.muscle_mesh.vertices[static_cast<std::size_t>(node)].z();
    EXPECT_LE(std::abs(z - 0.01), 0.026);
  }
  EXPECT_EQ(read_scene(with_ring(place + "radius_m = 0.006\nhalf_width_m = 0.01\n")).retinacula[0].half_width_m, 0.01);
}

TEST(ReadRetinacula, WhatHoldsNoTendonIsRefusedWithItsCure) {
  const auto refusal = [](const std::string& ring) { return error_of(with_ring(ring)); };
  expect_mentions(refusal("name = \"strap\"\nbone = \"block\"\ncentre_m = [0.04, 0, 0.01]\naxis = [0, 0, 1]\n"
                          "radius_m = 0.006\n"),
                  {"test.toml:", "centre_m", "nothing of tube", "mm from the centre"});
  expect_mentions(refusal(place + "radius_m = 0.004\nhalf_width_m = 0.006\n"),
                  {"test.toml:", "radius_m", "5.00 mm from the ring's axis"});
  expect_mentions(refusal(place + "radius_m = 0.006\nhalf_width_m = 0.0001\n"),
                  {"test.toml:", "half_width_m", "edges of tube", "or more"});
  expect_mentions(refusal("name = \"strap\"\nbone = \"block\"\ncentre_m = [0, 0, 0.01]\naxis = [0, 0, 0]\n"
                          "radius_m = 0.006\n"),
                  {"axis", "has no length"});
  expect_mentions(refusal(place + "radius_m = 0.0\n"), {"radius_m"});
  expect_mentions(refusal(place + "radius_m = 1.25\n"), {"radius_m", "would hold nothing; is it in metres?"});
  expect_mentions(refusal(place + "radius_m = 0.006\n[[retinaculum]]\n" + place + "radius_m = 0.006\n"),
                  {"'strap' is the name of an earlier ring"});
  expect_mentions(refusal(place + "radius_m = 0.006\nwidth_m = 0.1\n"), {"width_m", "is unknown"});
}

}  // namespace
}  // namespace musclebench

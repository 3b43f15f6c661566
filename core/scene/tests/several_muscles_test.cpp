// What of a scene belongs to one of its muscles: attachments and masses.
#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/scene/prepare_simulation.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

/// A ball and a small one on a box; each is attached where it touches.
Scene two_balls_on_a_box() {
  SceneRequest request;
  request.name = request.file = "two.toml";
  request.text = R"(
[loop]
density_kg_per_m3 = 1000.0
[effects.attachment]
[[bone]]
name = "box"
mesh = "synthetic:box"
[[muscle]]
name = "large"
mesh = "synthetic:large"
[[muscle]]
name = "small"
mesh = "synthetic:small"
[[attachment]]
name = "of large"
bone = "box"
muscle = "large"
outline_m = [[-0.03, -0.01, 0.01], [-0.01, -0.01, 0.01], [-0.01, 0.01, 0.01], [-0.03, 0.01, 0.01]]
distance_m = 0.003
[[attachment]]
name = "of small"
bone = "box"
muscle = "small"
outline_m = [[0.01, -0.01, 0.01], [0.03, -0.01, 0.01], [0.03, 0.01, 0.01], [0.01, 0.01, 0.01]]
distance_m = 0.003
)";
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "box") return make_box(Vec3(0.04, 0.02, 0.01), 4);
    const double radius_m = name == "large" ? 0.012 : 0.006;
    TriangleMesh mesh = make_sphere(radius_m, name == "large" ? 3 : 2);
    for (Vec3& vertex : mesh.vertices) vertex += Vec3(name == "large" ? -0.02 : 0.02, 0, 0.0105 + radius_m);
    return mesh;
  };
  return read_scene(request);
}

TEST(SeveralMuscles, AnAttachmentBindsNodesOfItsOwn) {
  const Scene scene = two_balls_on_a_box();
  ASSERT_EQ(scene.attachments.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_FALSE(scene.attachments[i].nodes.empty());
    for (const int node : scene.attachments[i].nodes) {
      EXPECT_TRUE(scene.muscles[i].body.has_node(node)) << i;
      EXPECT_LT(scene.muscle_mesh.vertices[static_cast<std::size_t>(node)].z(), 0.0136) << "far from the box";
    }
  }
}

TEST(SeveralMuscles, EachHasTheMassOfItsVolume) {
  const Scene scene = two_balls_on_a_box();
  for (const Muscle& muscle : scene.muscles) {
    const double volume_m3 = body_volume_m3(scene.muscle_mesh.vertices, scene.muscle_mesh.triangles, muscle.body);
    const int nodes = muscle.body.last_node - muscle.body.first_node;
    EXPECT_NEAR(node_mass_kg(scene, muscle) * nodes, 1000 * volume_m3, 1e-12) << muscle.body.name;
  }
}

}  // namespace
}  // namespace musclebench

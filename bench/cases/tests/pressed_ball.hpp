#pragma once

#include <map>
#include <string>

#include <fmt/format.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {

// The small scene of several tests, in parts: a ball on a plate, which a rod presses, and a second ball beside it that
// it leans on.

/// `keys_of_rod`: lines for its backend.
inline std::string plate_and_rod(int rod_to_deg, const std::string& keys_of_rod = "") {
  return fmt::format(R"(
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[[bone]]
name = "rod"
mesh = "synthetic:rod"
{}[bone.motion]
axis = [0, 1, 0]
centre_m = [0.05, 0, 0]
from_deg = 0
to_deg = {}
course = "there"
)",
                     keys_of_rod, rod_to_deg);
}

constexpr const char* one_ball = R"(
[muscle]
name = "ball"
mesh = "synthetic:ball"
)";

/// Named `ball` and `other`.
constexpr const char* two_balls = R"(
[[muscle]]
name = "ball"
mesh = "synthetic:ball"
[[muscle]]
name = "other"
mesh = "synthetic:other"
[contact]
muscle_contact = true
)";

/// Binds the ball to the plate.
constexpr const char* foot_of_ball = R"(
[[attachment]]
name = "foot"
bone = "plate"
muscle = "ball"
outline_m = [[-0.01, -0.01, 0], [0.01, -0.01, 0], [0.01, 0.01, 0], [-0.01, 0.01, 0]]
distance_m = 0.002
)";

inline TriangleMesh displaced(TriangleMesh mesh, const Vec3& by_m) {
  for (Vec3& vertex : mesh.vertices) vertex += by_m;
  return mesh;
}

/// By the names in the parts above. `subdivisions`: of the balls. Throws std::out_of_range.
inline TriangleMesh pressed_ball_mesh(const std::string& name, int subdivisions = 2) {
  const std::map<std::string, TriangleMesh> meshes = {
      {"plate", displaced(make_box(Vec3(0.04, 0.04, 0.01), 4), Vec3(0, 0, -0.01))},
      {"rod", displaced(make_capsule(0.01, 0.02, 24), Vec3(0.034, 0, 0.03))},
      {"ball", displaced(make_sphere(0.02, subdivisions), Vec3(0, 0, 0.0205))},
      {"other", displaced(make_sphere(0.02, subdivisions), Vec3(-0.0392, 0, 0.0205))},
  };
  return meshes.at(name);
}

}  // namespace musclebench

#pragma once

#include <string>

#include "core/mesh/shapes.hpp"
#include "core/referee/tests/test_bones.hpp"
#include "core/scene/read_scene.hpp"

/// Scenes whose forces a formula tells.
namespace musclebench::force_scenes {

inline std::string bone(const std::string& name) {
  return "[[bone]]\nname = \"" + name + "\"\nmesh = \"synthetic:" + name + "\"\n";
}

inline std::string muscle(const std::string& name) {
  return "[[muscle]]\nname = \"" + name + "\"\nmesh = \"synthetic:" + name + "\"\n";
}

inline SceneRequest request_of(const std::string& text) {
  SceneRequest request;
  request.name = request.file = "forces.toml";
  request.text = text;
  return request;
}

/// A block of 60 x 20 x 20 mm over two rails 0.4 mm wide, 15 mm to its left and right.
inline Scene block_on_rails() {
  SceneRequest request = request_of(R"(
[loop]
frames = 60
substeps = 20
time_step_s = 1e-3
density_kg_per_m3 = 1060
[effects.gravity]
[effects.damping]
rate_per_s = 50
[effects.edge_length]
compliance_m_per_n = 1e-5
[effects.volume]
[effects.bending]
[effects.friction]
[effects.surface_contact]
)" + bone("left") + bone("right") + muscle("block"));
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "block") return moved(make_box(Vec3(0.03, 0.01, 0.01), 6), Vec3(0, 0, 0.01));
    return moved(make_box(Vec3(0.0002, 0.02, 0.005), 1), Vec3(name == "left" ? -0.015 : 0.015, 0, -0.005));
  };
  return read_scene(request);
}

/// A strap of 100 mm from a bone that stands to one that turns about an axis 30 mm below its end. `pulls`: what pulls,
/// in the words of a scene file.
inline Scene taut_strap(const std::string& pulls = "[effects.edge_length]\ncompliance_m_per_n = 0.05\n") {
  SceneRequest request = request_of(R"(
[loop]
frames = 30
substeps = 20
time_step_s = 1e-3
density_kg_per_m3 = 1060
bone_motion = "interpolated"
[effects.damping]
rate_per_s = 100
[effects.attachment]
[effects.volume]
)" + pulls + bone("left") + bone("right") +
                                    R"([bone.motion]
axis = [0, 1, 0]
centre_m = [0.05, 0, -0.03]
from_deg = 0
to_deg = 20
course = "there"
)" + muscle("strap") + R"(fibres = "between_attachments"
[[attachment]]
name = "origin"
bone = "left"
outline_m = [[-0.05, -0.01, -0.01], [-0.05, 0.01, -0.01], [-0.05, 0.01, 0.01], [-0.05, -0.01, 0.01]]
distance_m = 0.001
[[attachment]]
name = "insertion"
bone = "right"
outline_m = [[0.05, -0.01, -0.01], [0.05, 0.01, -0.01], [0.05, 0.01, 0.01], [0.05, -0.01, 0.01]]
distance_m = 0.001
)");
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "strap") return make_box(Vec3(0.05, 0.005, 0.002), 10);
    return moved(make_box(Vec3(0.002, 0.02, 0.02), 1), Vec3(name == "left" ? -0.052 : 0.052, 0, 0));
  };
  request.fibres = {4, "test"};
  return read_scene(request);
}

/// A ball that liquid inflates by 30 %, between a plate and a lid that comes down by 6 mm; with `two`, a second ball
/// lies on the first.
inline Scene pressed_ball(bool two) {
  SceneRequest request = request_of(R"(
[loop]
frames = 120
rest_frames = 80
substeps = 20
time_step_s = 1e-3
density_kg_per_m3 = 500
bone_motion = "interpolated"
[effects.damping]
rate_per_s = 40
[effects.edge_length]
compliance_m_per_n = 0.01
[effects.volume]
pressure = 1.3
)" + bone("plate") + bone("lid") + R"([bone.motion]
axis = [0, 1, 0]
centre_m = [-10, 0, 0.05]
from_deg = 0
to_deg = 0.03438
course = "there"
)");
  request.text += muscle("ball");
  if (two) {
    request.text += muscle("other") + "[contact]\nmuscle_contact = true\n";
  }
  const double top_m = two ? 0.0801 : 0.0401;
  request.synthetic_mesh = [top_m](const std::string& name) {
    if (name == "ball") return moved(make_sphere(0.02, 4), Vec3(0, 0, 0.02005));
    if (name == "other") return moved(make_sphere(0.02, 4), Vec3(0, 0, 0.06005));
    return moved(make_box(Vec3(0.04, 0.04, 0.005), 32), Vec3(0, 0, name == "plate" ? -0.005 : top_m + 0.005));
  };
  return read_scene(request);
}

/// A box that is attached whole to a plate, and a smaller box that lies on it.
inline Scene stacked_boxes() {
  SceneRequest request = request_of(R"(
[loop]
frames = 60
substeps = 20
time_step_s = 1e-3
density_kg_per_m3 = 1060
[effects.gravity]
[effects.damping]
rate_per_s = 50
[effects.attachment]
[effects.edge_length]
compliance_m_per_n = 0.05
[effects.volume]
[effects.friction]
)" + bone("plate") + muscle("lower") +
                                    muscle("upper") + R"([contact]
muscle_contact = true
[[attachment]]
name = "foot"
bone = "plate"
muscle = "lower"
outline_m = [[-0.03, -0.03, 0], [0.03, -0.03, 0], [0.03, 0.03, 0], [-0.03, 0.03, 0]]
distance_m = 0.05
)");
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "plate") return moved(make_box(Vec3(0.04, 0.04, 0.005), 4), Vec3(0, 0, -0.005));
    if (name == "lower") return moved(make_box(Vec3(0.02, 0.02, 0.005), 4), Vec3(0, 0, 0.0051));
    return moved(make_box(Vec3(0.01, 0.01, 0.01), 4), Vec3(0, 0, 0.0202));
  };
  return read_scene(request);
}

}  // namespace musclebench::force_scenes

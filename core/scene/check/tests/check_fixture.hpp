#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"
#include "core/scene/check/scene_check.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {

/// Meshes of the scenes here: `plate` 40 x 40 x 4 mm, `lid` the same 26 mm above it, `block` 40 x 40 x 40 mm below z =
/// 2 mm; `ball` of 10 mm radius above the plate, `other` the same 15 mm beside it, `far` 100 mm away; `bowl`: an open
/// ball.
inline TriangleMesh check_mesh_named(const std::string& name) {
  const auto shifted = [](TriangleMesh mesh, const Vec3& by) {
    for (Vec3& vertex : mesh.vertices) vertex += by;
    return mesh;
  };
  if (name == "plate") return make_box(Vec3(0.02, 0.02, 0.002), 8);
  if (name == "lid") return shifted(make_box(Vec3(0.02, 0.02, 0.002), 8), Vec3(0, 0, 0.026));
  if (name == "block") return shifted(make_box(Vec3(0.02, 0.02, 0.02), 8), Vec3(0, 0, -0.018));
  if (name == "other") return shifted(make_sphere(0.01, 2), Vec3(0.015, 0, 0.0125));
  if (name == "far") return shifted(make_sphere(0.01, 2), Vec3(0.1, 0, 0.0125));
  TriangleMesh ball = shifted(make_sphere(0.01, 2), Vec3(0, 0, 0.0125));
  if (name == "bowl") ball.triangles.pop_back();
  return ball;
}

inline Scene check_scene_of(const std::string& text) {
  SceneRequest request;
  request.name = request.file = "test.toml";
  request.text = text;
  request.synthetic_mesh = check_mesh_named;
  return read_scene(request);
}

inline std::string bone_text(std::string_view name, std::string_view motion = "") {
  return fmt::format("[[bone]]\nname = \"{0}\"\nmesh = \"synthetic:{0}\"\n{1}", name, motion);
}

/// About an axis 50 mm beside the plate, `degrees` there in 10 frames of one step.
inline std::string turning(double degrees) {
  return fmt::format(
      "[bone.motion]\naxis = [0, 1, 0]\ncentre_m = [-0.05, 0, 0]\nfrom_deg = 0\nto_deg = {}\n"
      "course = \"there\"\n",
      degrees);
}

inline std::string muscle_text(std::string_view name, std::string_view more = "") {
  return fmt::format("[[muscle]]\nname = \"{0}\"\nmesh = \"synthetic:{0}\"\n{1}", name, more);
}

/// About the middle of a ball.
inline std::string ring_text(std::string_view muscle, double radius_m) {
  return fmt::format(
      "[[retinaculum]]\nname = \"ring\"\nbone = \"plate\"\nmuscle = \"{}\"\ncentre_m = [0, 0, 0.0125]\n"
      "axis = [0, 0, 1]\nradius_m = {}\n",
      muscle, radius_m);
}

inline std::string attachment_text(std::string_view bone, std::string_view muscle, double distance_m,
                                   double z_m = 0.002) {
  return fmt::format(
      "[[attachment]]\nname = \"on_{0}\"\nbone = \"{0}\"\nmuscle = \"{1}\"\ndistance_m = {2}\n"
      "outline_m = [[-0.02, -0.02, {3}], [0.02, -0.02, {3}], [0.02, 0.02, {3}], [-0.02, 0.02, {3}]]\n",
      bone, muscle, distance_m, z_m);
}

inline constexpr const char* short_loop = "[loop]\nframes = 10\nsubsteps = 1\n";

inline const Finding* find_finding(const Findings& findings, std::string_view id, std::string_view where = "") {
  const auto found = std::ranges::find_if(findings, [&](const Finding& finding) {
    return finding.id == id && finding.where.find(where) != std::string::npos;
  });
  return found == findings.end() ? nullptr : &*found;
}

inline bool is_found(const Scene& scene, std::string_view id, std::string_view where = "",
                     const CheckOptions& options = {}) {
  return find_finding(check_scene(scene, options), id, where) != nullptr;
}

inline double figure_of(const Finding& finding, std::string_view name) {
  const auto found = std::ranges::find(finding.figures, name, &Figure::name);
  EXPECT_NE(found, finding.figures.end()) << finding.id << " has no figure " << name;
  return found == finding.figures.end() ? NAN : found->value;
}

}  // namespace musclebench

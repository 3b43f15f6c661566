#include "datasets/synthetic/make_synthetic_hip.hpp"

#include "datasets/synthetic/synthetic_bones.hpp"
#include "datasets/synthetic/synthetic_isosurface.hpp"
#include "datasets/synthetic/synthetic_muscles.hpp"
#include "datasets/synthetic/synthetic_remesh.hpp"

namespace musclebench {

namespace {

constexpr double bone_cell_m = 0.0022;
constexpr double muscle_cell_m = 0.0022;
constexpr int hip_bone_vertices = 24000;
constexpr int femur_vertices = 20000;

TriangleMesh make_surface(const Field& field, const Vec3& lower_m, const Vec3& upper_m, double cell_m, int vertices) {
  return remesh_isotropic(largest_surface(extract_isosurface(field, lower_m, upper_m, cell_m)), field, vertices);
}

}  // namespace

TriangleMesh make_synthetic_hip_mesh(std::string_view name) {
  if (name == "hip_bone") {
    return make_surface(hip_bone_field(), Vec3(-0.08, -0.09, -0.08), Vec3(0.12, 0.12, 0.17), bone_cell_m,
                        hip_bone_vertices);
  }
  if (name == "femur") {
    return make_surface(femur_field(), Vec3(-0.09, -0.05, -0.45), Vec3(0.05, 0.09, 0.05), bone_cell_m, femur_vertices);
  }
  const MuscleShape muscle = muscle_shape(name);
  return make_surface(muscle.field, muscle.lower_m, muscle.upper_m, muscle_cell_m, muscle.vertices);
}

}  // namespace musclebench

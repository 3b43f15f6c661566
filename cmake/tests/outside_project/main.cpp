// One frame of a ball that a moving bone pushes aside, with the distance field and with the exact BVH.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "backends/bvh/bvh_backend.hpp"
#include "backends/sdf/sdf_backend.hpp"
#include "core/mesh/shapes.hpp"
#include "core/pbd/simulation.hpp"

using namespace musclebench;

namespace {

constexpr double bone_radius_m = 0.03;
constexpr double step_m = 0.004;

/// The smallest distance of a node from the bone's centre after a frame in which the bone moves towards the ball.
double closest_after_a_frame(const BackendEntry& entry, const std::vector<Bone>& bones, const TriangleMesh& ball) {
  const auto backend = entry.make(Parameters(entry.parameters, {}, "outside"));
  backend->build(bones, ball, 1);
  Particles particles;
  particles.positions = ball.vertices;
  particles.velocities.assign(ball.vertices.size(), Vec3::Zero());
  particles.inverse_masses.assign(ball.vertices.size(), 1);
  const std::vector<Body> body = {{"ball", 0, static_cast<int>(ball.vertices.size()), 0, ball.triangles.size()}};
  LoopParameters loop;
  Simulation simulation(loop, particles, NodeOrder(ball.vertices, body), {}, *backend, entry.default_response,
                        [](double frame, std::vector<RigidMotion>& poses) {
                          poses.assign(1, RigidMotion{Mat3::Identity(), Vec3(frame * step_m, 0, 0)});
                        });
  simulation.step_frame(1);
  double closest_m = 1;
  for (const Vec3& position : simulation.positions()) {
    closest_m = std::min(closest_m, (position - Vec3(step_m, 0, 0)).norm());
  }
  return closest_m;
}

}  // namespace

int main() {
  const std::vector<Bone> bones = {{"bone", repair_mesh(make_sphere(bone_radius_m, 4), "bone")}};
  TriangleMesh ball = make_sphere(0.01, 3);
  for (Vec3& vertex : ball.vertices) {
    vertex.x() += bone_radius_m + 0.0101;
  }
  for (const BackendEntry& entry : {sdf_entry(), bvh_entry()}) {
    const double closest_m = closest_after_a_frame(entry, bones, ball);
    std::printf("%s: the nearest node is %.3f mm from the bone's centre\n", entry.name.c_str(), closest_m * 1e3);
    if (std::abs(closest_m - bone_radius_m) > 1e-4) {
      return 1;
    }
  }
  return 0;
}

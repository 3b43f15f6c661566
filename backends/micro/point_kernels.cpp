#include "backends/micro/point_kernels.hpp"

#include <random>

#include "core/mesh/mesh_size.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

std::vector<Vec3> points_near(const Scene& scene, const Bone& bone, std::size_t count) {
  const std::vector<Vec3>& vertices = scene.muscle_mesh.vertices;
  const Eigen::AlignedBox3d box = bounding_box(bone.surface.mesh.vertices);
  std::mt19937 random(1);
  std::normal_distribution<double> jitter(0, 0.002);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 point = vertices[i % vertices.size()] + Vec3(jitter(random), jitter(random), jitter(random));
    if (box.contains(point)) {
      points.push_back(point);
    }
  }
  return points;
}

std::vector<Vec3> points_far(const Bone& bone, std::size_t count) {
  const Eigen::AlignedBox3d box = bounding_box(bone.surface.mesh.vertices);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> share(-0.05, 1.05);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 shares(share(random), share(random), share(random));
    points.push_back(box.min() + shares.cwiseProduct(box.sizes()));
  }
  return points;
}

const SignedSurface& surface_of(const Bone& bone) {
  static std::map<const Bone*, std::unique_ptr<SignedSurface>> surfaces;
  return kept(surfaces, bone, [&] { return SignedSurface(bone.surface); });
}

}  // namespace musclebench

#include "core/scene/check/bone_thickness.hpp"

#include <algorithm>
#include <limits>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

std::vector<ThicknessSample> sample_thickness(const Bone& bone, const Eigen::AlignedBox3d& within) {
  constexpr std::size_t most_thicknesses = 2000;
  const TriangleMesh& mesh = bone.surface.mesh;
  const double diagonal_m = bounding_box(mesh.vertices).diagonal().norm();
  const auto corner = [&](std::size_t t, std::size_t k) -> const Vec3& {
    return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])];
  };
  const auto middle_of = [&](std::size_t t) -> Vec3 { return (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3; };
  std::vector<std::size_t> near;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (within.contains(middle_of(t))) near.push_back(t);
  }
  const TriangleBvh& tree = bone.tree();
  std::vector<ThicknessSample> samples;
  std::vector<PathCrossing> crossings;
  const std::size_t stride = (near.size() + most_thicknesses - 1) / most_thicknesses;
  for (std::size_t i = 0; i < near.size(); i += stride) {
    const std::size_t t = near[i];
    const Vec3 normal = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).stableNormalized();
    const Vec3 middle = middle_of(t);
    // A little inside, so that the triangle itself is not met.
    const Vec3 from = middle - 1e-7 * diagonal_m * normal;
    tree.find_crossings(from, middle - diagonal_m * normal, crossings);
    if (crossings.empty() || crossings.front().entering) continue;
    samples.push_back({crossings.front().share * diagonal_m, tree.area_normal(static_cast<int>(t)).norm()});
  }
  return samples;
}

ThinShare share_thinner_than(double limit_m, const std::vector<ThicknessSample>& samples) {
  if (samples.empty()) return {};
  double whole_m2 = 0;
  double thinner_m2 = 0;
  double thinnest_m = std::numeric_limits<double>::infinity();
  for (const ThicknessSample& sample : samples) {
    whole_m2 += sample.area_m2;
    thinner_m2 += sample.thickness_m < limit_m ? sample.area_m2 : 0;
    thinnest_m = std::min(thinnest_m, sample.thickness_m);
  }
  return {whole_m2 > 0 ? thinner_m2 / whole_m2 : 0, thinnest_m};
}

}  // namespace musclebench

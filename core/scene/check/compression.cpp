#include "core/scene/check/compression.hpp"

#include "core/base/percentile.hpp"

namespace musclebench {

namespace {

std::vector<double> side_lengths_m(const TriangleMesh& mesh) {
  std::vector<double> lengths_m;
  lengths_m.reserve(3 * mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
      lengths_m.push_back(
          (mesh.vertices[static_cast<std::size_t>(to)] - mesh.vertices[static_cast<std::size_t>(from)]).norm());
    }
  }
  return lengths_m;
}

}  // namespace

std::vector<Compression> compressions(const Scene& scene, const PoseEstimates& poses) {
  constexpr double share = 0.05;
  std::vector<Compression> found;
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    const Body& body = scene.muscles[muscle].body;
    TriangleMesh mesh = scene.mesh_of(body);
    const std::vector<double> rest_m = side_lengths_m(mesh);
    Compression& most = found.emplace_back(Compression{.muscle = muscle});
    for (std::size_t pose = 1; pose < poses.count(); ++pose) {
      mesh.vertices = poses.positions(pose, body);
      std::vector<double> ratios = side_lengths_m(mesh);
      for (std::size_t side = 0; side < ratios.size(); ++side) ratios[side] /= rest_m[side];
      const double ratio = percentile(std::move(ratios), share);
      if (ratio < most.edge_ratio) {
        most.edge_ratio = ratio;
        most.angle_rad = poses.angle_rad(pose);
      }
    }
  }
  return found;
}

}  // namespace musclebench

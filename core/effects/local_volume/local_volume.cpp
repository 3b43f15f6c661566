#include "core/effects/local_volume/local_volume.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "core/constraints/volume_constraints.hpp"
#include "core/effects/constraint_effect.hpp"
#include "core/effects/volume/volume.hpp"

namespace musclebench {

namespace {

struct Patch {
  Vec3 centre;
  double area_m2;
};

Vec3 longest_axis(const std::vector<Patch>& patches) {
  Vec3 middle = Vec3::Zero();
  double area_m2 = 0;
  for (const Patch& patch : patches) {
    middle += patch.area_m2 * patch.centre;
    area_m2 += patch.area_m2;
  }
  if (!(area_m2 > 0)) return Vec3::UnitZ();
  middle /= area_m2;
  Mat3 covariance = Mat3::Zero();
  for (const Patch& patch : patches) {
    const Vec3 arm = patch.centre - middle;
    covariance += patch.area_m2 / area_m2 * arm * arm.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvectors().col(2);
}

/// Bands of equal area along the axis.
std::vector<int> bands_of(const std::vector<Patch>& patches, int count) {
  const Vec3 axis = longest_axis(patches);
  std::vector<double> along;
  for (const Patch& patch : patches) along.push_back(axis.dot(patch.centre));
  std::vector<std::size_t> order(patches.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return along[i]; });
  const double area_m2 = std::accumulate(patches.begin(), patches.end(), 0.0,
                                         [](double sum, const Patch& patch) { return sum + patch.area_m2; });
  std::vector<int> bands(patches.size(), 0);
  double before_m2 = 0;
  int wanted = 0;  // by area, from which large triangles may skip bands
  int band = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const double share = area_m2 > 0 ? (before_m2 + 0.5 * patches[order[i]].area_m2) / area_m2 : 0;
    const int of_share = std::min(count - 1, static_cast<int>(share * count));
    if (i > 0 && of_share > wanted) ++band;
    wanted = of_share;
    bands[order[i]] = band;
    before_m2 += patches[order[i]].area_m2;
  }
  return bands;
}

std::unique_ptr<Effect> make_local_volume(const EffectInput& input, const Parameters& parameters) {
  const auto count = static_cast<int>(parameters.integer("regions"));
  return make_constraint_effect("local_volume",
                                VolumeConstraints(input.mesh, input.bodies, input.order,
                                                  {.pressure = parameters.number("pressure"),
                                                   .projection_scale = parameters.number("projection_scale")},
                                                  bands_along_bodies(input.mesh, input.bodies, count)));
}

std::vector<ParameterSpec> local_volume_parameters() {
  std::vector<ParameterSpec> parameters = volume_parameters();
  parameters.insert(parameters.begin(),
                    parameter::integer({.name = "regions",
                                        .default_value = 8,
                                        .minimum = 1,
                                        .maximum = VolumeConstraints::most_regions,
                                        .help = "bands of equal surface area along the muscle, each of which keeps its "
                                                "volume"}));
  return parameters;
}

}  // namespace

std::vector<int> bands_along_bodies(const TriangleMesh& mesh, const std::vector<Body>& bodies, int count) {
  std::vector<int> bands;
  bands.reserve(mesh.triangles.size());
  for (const Body& body : bodies) {
    std::vector<Patch> patches;
    for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
      const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])]; };
      patches.push_back(
          {(corner(0) + corner(1) + corner(2)) / 3, 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm()});
    }
    const std::vector<int> own = bands_of(patches, count);
    bands.insert(bands.end(), own.begin(), own.end());
  }
  return bands;
}

EffectEntry local_volume_entry() {
  return {.name = "local_volume",
          .help = "each of several regions along the muscle keeps its volume",
          .parameters = local_volume_parameters(),
          .make = make_local_volume,
          .remedies = {{Requirement::volume}},
          .inert_at_zero = {"projection_scale"},
          .colour = "#86A593"};
}

}  // namespace musclebench

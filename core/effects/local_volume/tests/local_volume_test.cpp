#include "core/effects/local_volume/local_volume.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {
namespace {

/// Along z, from -0.06 to 0.06 m.
TriangleMesh tube() { return make_capsule(0.01, 0.05, 32); }

double mean_radius_m(const std::vector<Vec3>& nodes, const std::vector<Vec3>& rest, double from_m, double to_m) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (rest[i].z() < from_m || rest[i].z() > to_m) continue;
    sum += std::hypot(nodes[i].x(), nodes[i].y());
    ++count;
  }
  return sum / count;
}

TEST(LocalVolume, BandsAreOfEqualAreaAndFollowOneAnotherAlongTheMuscle) {
  const Fixture f(tube());
  const std::vector<int> bands = bands_along_bodies(f.mesh, f.bodies, 8);
  std::vector<double> area(8, 0);
  std::vector<double> height(8, 0);
  for (std::size_t t = 0; t < bands.size(); ++t) {
    const auto& [a, b, c] = f.mesh.triangles[t];
    const double own =
        0.5 * (f.mesh.vertices[b] - f.mesh.vertices[a]).cross(f.mesh.vertices[c] - f.mesh.vertices[a]).norm();
    const auto band = static_cast<std::size_t>(bands[t]);
    ASSERT_LT(band, 8U);
    area[band] += own;
    height[band] += own * (f.mesh.vertices[a] + f.mesh.vertices[b] + f.mesh.vertices[c]).z() / 3;
  }
  const auto [least, most] = std::ranges::minmax(area);
  EXPECT_GT(least, 0.8 * most);
  const double direction = height[7] / area[7] > height[0] / area[0] ? 1 : -1;
  for (std::size_t band = 1; band < 8; ++band) {
    EXPECT_GT(direction * (height[band] / area[band] - height[band - 1] / area[band - 1]), 0.005);
  }
}

TEST(LocalVolume, MoreRegionsThanTrianglesLeaveNoGap) {
  const Fixture f(make_box(Vec3(0.01, 0.01, 0.05), 1));
  const std::vector<int> bands = bands_along_bodies(f.mesh, f.bodies, 64);
  const int most = std::ranges::max(bands);
  for (int band = 0; band <= most; ++band) EXPECT_GT(std::ranges::count(bands, band), 0) << band;
}

TEST(LocalVolume, OneRegionIsTheWholeVolumeToTheBit) {
  Fixture f(tube());
  Nodes whole = f.particles();
  for (Vec3& x : whole.predicted) x.x() *= 0.8;
  Nodes region = whole;
  f.project(*f.make("volume"), whole, 3);
  f.project(*f.make("local_volume", {{"regions", std::int64_t{1}}}), region, 3);
  EXPECT_EQ(whole.predicted, region.predicted);
}

TEST(LocalVolume, RegionsFillTheMuscle) {
  for (const double far_m : {0.0, 1000.0}) {
    Fixture f(tube());
    for (Vec3& x : f.mesh.vertices) x += Vec3(0, far_m, 0);
    const auto volume = f.make("local_volume", {{"pressure", 1.2}});
    Nodes p = f.particles();
    f.project(*volume, p, 60);
    EXPECT_NEAR(surface_volume_m3(p.predicted, f.mesh.triangles) / surface_volume_m3(f.mesh.vertices, f.mesh.triangles),
                1.2, 1e-6);
  }
}

TEST(LocalVolume, MovesNothingAtRest) {
  Fixture f(tube());
  const auto volume = f.make("local_volume");
  Nodes p = f.particles();
  const RigidMotion motion = RigidMotion::about_axis(Vec3(1, 2, 3).normalized(), Vec3(0.1, 0, 0), 1.0);
  for (Vec3& x : p.predicted) x = motion.apply(x);
  const std::vector<Vec3> before = p.predicted;
  f.project(*volume, p);
  for (std::size_t i = 0; i < p.size(); ++i) ASSERT_LT((p.predicted[i] - before[i]).norm(), 1e-15);
}

/// One end of a tube is squeezed and held. With one constraint on the whole volume the other end takes up what is
/// displaced; with regions it stays as it is.
TEST(LocalVolume, ASqueezedEndDoesNotInflateTheOther) {
  Fixture f(tube());
  const auto project_squeezed = [&](const char* effect) {
    Nodes p = f.particles();
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (f.mesh.vertices[i].z() > -0.02) continue;
      p.predicted[i].head<2>() *= 0.7;
      p.inverse_masses[i] = 0;
    }
    f.project(*f.make(effect), p, 50);
    return mean_radius_m(p.predicted, f.mesh.vertices, 0.02, 0.05) /
           mean_radius_m(f.mesh.vertices, f.mesh.vertices, 0.02, 0.05);
  };
  // A third of the tube has lost half of its volume, which is a quarter of what the rest holds.
  EXPECT_GT(project_squeezed("volume"), 1.1);
  EXPECT_NEAR(project_squeezed("local_volume"), 1, 5e-3);
}

TEST(LocalVolume, KeepsLinearAndAngularMomentum) {
  Fixture f(tube());
  const auto volume = f.make("local_volume", {{"regions", std::int64_t{12}}});
  Nodes p = f.particles();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> factor(0.9, 1.1);
  for (std::size_t i = 0; i < p.size(); ++i) {
    p.predicted[i] *= factor(random);
    p.inverse_masses[i] = std::pow(factor(random), 20);
  }
  const std::vector<Vec3> before = p.predicted;
  f.project(*volume, p);
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
  double scale = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec3 momentum = (p.predicted[i] - before[i]) / p.inverse_masses[i];
    linear += momentum;
    angular += before[i].cross(momentum);
    scale += momentum.norm();
  }
  EXPECT_GT(scale, 1e-3);
  EXPECT_LT(linear.norm(), 1e-12 * scale);
  EXPECT_LT(angular.norm(), 1e-12 * scale);
}

TEST(LocalVolume, BoundNodesDoNotMove) {
  Fixture f(tube());
  const auto volume = f.make("local_volume", {{"pressure", 1.5}});
  Nodes p = f.particles();
  p.inverse_masses[7] = 0;
  f.project(*volume, p);
  EXPECT_EQ(p.predicted[7], f.mesh.vertices[7]);
  EXPECT_NE(p.predicted[8], f.mesh.vertices[8]);
}

}  // namespace
}  // namespace musclebench

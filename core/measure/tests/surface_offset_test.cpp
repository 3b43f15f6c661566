#include "core/measure/surface_offset.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/base/random_numbers.hpp"
#include "core/contact/tests/shape_backend.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_sampler.hpp"
#include "core/referee/tests/test_bones.hpp"

namespace musclebench {
namespace {

constexpr double bound_m = 0.01;

/// A roof: 60 mm wide, 40 mm high, 100 mm long, whose ridge is as sharp as its height makes it.
TriangleMesh make_wing(double half_width_m) {
  const double h = half_width_m;
  TriangleMesh mesh;
  mesh.vertices = {{-h, -0.05, 0}, {h, -0.05, 0}, {0, -0.05, 0.04}, {-h, 0.05, 0}, {h, 0.05, 0}, {0, 0.05, 0.04}};
  mesh.triangles = {{0, 1, 2}, {5, 4, 3}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}};
  return mesh;
}

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
};

std::vector<NamedMesh> shapes() {
  return {{"sphere", make_sphere(0.02, 4)}, {"plate", make_box({0.05, 0.05, 0.004}, 4)}, {"wing", make_wing(0.006)}};
}

/// One bone, whose sites lie all over it.
class Surface {
 public:
  explicit Surface(TriangleMesh mesh, int sites = 400)
      : m_bones{bone_of(mesh)}, m_referee(m_bones, 0), m_diagonals_m{bounding_box(mesh.vertices).diagonal().norm()} {
    const SurfaceSampler sampler(mesh);
    RandomNumbers random(1);
    for (int i = 0; i < sites; ++i) {
      const SurfaceSample sample = sampler.draw(random);
      m_sites.push_back({.surface_point_m = sample.point, .outward = sample.normal});
    }
  }

  [[nodiscard]] double distance_m(const Vec3& point) const { return m_referee.signed_distance(0, point); }
  [[nodiscard]] std::vector<ContactSite>& sites() { return m_sites; }
  [[nodiscard]] const std::vector<Bone>& bones() const { return m_bones; }
  [[nodiscard]] std::span<const double> diagonals_m() const { return m_diagonals_m; }
  [[nodiscard]] const Referee& referee() const { return m_referee; }

  [[nodiscard]] std::vector<SiteOffset> measure(const AskInside& ask) const {
    return measure_offsets(ask, m_referee, m_diagonals_m, m_sites, bound_m);
  }

  /// Of a method that takes points for inside where `is_inside` says so.
  template <typename IsInside>
  [[nodiscard]] OffsetStatistics offsets(const IsInside& is_inside) const {
    const auto ask = [&](std::span<const Vec3> points_m, std::span<const int> asked, std::vector<char>& inside) {
      for (const int i : asked) {
        const auto at = static_cast<std::size_t>(i);
        inside[at] = static_cast<char>(is_inside(points_m[at]));
      }
    };
    return *offset_statistics(m_sites, measure(ask), 1, 1).all;
  }

 private:
  std::vector<Bone> m_bones;
  Referee m_referee;
  std::vector<double> m_diagonals_m;
  std::vector<ContactSite> m_sites;
};

TEST(SurfaceOffset, AShiftedSurfaceIsFoundWhereItIs) {
  for (const NamedMesh& shape : shapes()) {
    const Surface surface(shape.mesh);
    for (const double shift_mm : {0.01, 0.1, 1.0, 3.0}) {
      for (const double sign : {1.0, -1.0}) {
        const double shift_m = sign * shift_mm * 1e-3;
        SCOPED_TRACE(shape.name + " shifted by " + std::to_string(shift_m));
        const OffsetStatistics found = surface.offsets([&](const Vec3& p) { return surface.distance_m(p) < shift_m; });
        EXPECT_EQ(found.sites, 400);
        EXPECT_EQ(found.open_sites, 0);
        EXPECT_NEAR(found.p99_offset_m, std::abs(shift_m), 0.01 * std::abs(shift_m));
        EXPECT_NEAR(found.max_offset_m, std::abs(shift_m), 0.01 * std::abs(shift_m));
        EXPECT_NEAR(found.p99_inward_m, std::max(0.0, -shift_m), 0.01 * std::abs(shift_m));
        EXPECT_NEAR(found.p99_outward_m, std::max(0.0, shift_m), 0.01 * std::abs(shift_m));
      }
    }
  }
}

TEST(SurfaceOffset, AnExactSurfaceHasNone) {
  for (const NamedMesh& shape : shapes()) {
    const Surface surface(shape.mesh);
    const OffsetStatistics found = surface.offsets([&](const Vec3& p) { return surface.distance_m(p) < 0; });
    EXPECT_EQ(found.max_offset_m, 0) << shape.name;
    EXPECT_EQ(found.open_sites, 0) << shape.name;
  }
}

TEST(SurfaceOffset, WhatNeverAnswersHasTheBound) {
  const Surface surface(make_sphere(0.02, 3));
  const OffsetStatistics found = surface.offsets([](const Vec3&) { return false; });
  EXPECT_EQ(found.open_sites, found.sites);
  EXPECT_EQ(found.p99_inward_m, bound_m);
  EXPECT_EQ(found.max_offset_m, bound_m);
  EXPECT_EQ(found.p99_outward_m, 0);
}

TEST(SurfaceOffset, WhatAlwaysAnswersIsOpenOutwards) {
  const Surface surface(make_sphere(0.02, 3));
  const OffsetStatistics found = surface.offsets([](const Vec3&) { return true; });
  EXPECT_EQ(found.open_sites, found.sites);
  EXPECT_GE(found.p99_outward_m, bound_m * 0.999);
  EXPECT_EQ(found.max_inward_m, 0);
}

TEST(SurfaceOffset, APlateThatIsMissedIsOpenThoughItIsThin) {
  const Surface surface(make_box({0.05, 0.05, 0.0005}, 4), 200);
  // The faces of the plate, shifted by more than half of its thickness: nothing is left of it.
  const OffsetStatistics found = surface.offsets([&](const Vec3& p) { return surface.distance_m(p) < -0.0008; });
  EXPECT_EQ(found.p99_inward_m, bound_m);
  EXPECT_GT(found.open_sites, 190);
}

TEST(SurfaceOffset, NearARidgeASurfaceFurtherInIsNotTakenForAMissingOne) {
  Surface surface(make_wing(0.006), 0);
  // So near the ridge that the medial axis is at a fifth of the shift.
  const Vec3 normal = Vec3(0.04, 0, 0.006).normalized();
  surface.sites().push_back({.surface_point_m = Vec3(0.0003, 0, 0.038), .outward = normal});
  const OffsetStatistics found = surface.offsets([&](const Vec3& p) { return surface.distance_m(p) < -0.001; });
  EXPECT_EQ(found.open_sites, 0);
  EXPECT_NEAR(found.max_inward_m, 0.001, 1e-5);
}

TEST(SurfaceOffset, VoxelsAreOutByAtMostTheirDiagonal) {
  const Surface surface(make_sphere(0.02, 4), 1000);
  constexpr double cell_m = 0.001;
  // Every cell that the ball touches: its corner nearest to the centre is inside.
  const OffsetStatistics found = surface.offsets([&](const Vec3& p) {
    Vec3 nearest;
    for (int k = 0; k < 3; ++k) {
      const double low_m = std::floor(p[k] / cell_m) * cell_m;
      nearest[k] = std::clamp(0.0, low_m, low_m + cell_m);
    }
    return nearest.norm() < 0.02;
  });
  EXPECT_EQ(found.open_sites, 0);
  EXPECT_GT(found.p99_outward_m, 0.7 * cell_m);
  EXPECT_LE(found.max_outward_m, std::sqrt(3.0) * cell_m * 1.01);
  EXPECT_LT(found.max_inward_m, 1e-4);
}

TEST(SurfaceOffset, ABackendIsAskedAboutTheBoneOfTheSite) {
  Surface surface(make_sphere(0.02, 5));
  // The other bone covers the first wherever it is: its contacts say nothing of the first one's surface.
  ShapeBackend backend({ball(Vec3::Zero(), 0.0195), ball(Vec3::Zero(), 1000)});
  const SurfaceOffsets found =
      offset_statistics(surface.sites(), surface.measure(ask_backend(backend, 2, 100, surface.sites())), 1, 1);
  // The mesh of the ball lies a little inside of it.
  EXPECT_NEAR(found.all->p99_inward_m, 0.0005, 2e-5);
  EXPECT_EQ(found.all->open_sites, 0);
}

TEST(SurfaceOffset, StatisticsCountContactsAndKeepPairsAndDifficultiesApart) {
  std::vector<ContactSite> sites(4);
  sites[0] = {.bone = 0, .muscle = 0, .contacts = 98, .difficulty = ContactDifficulty::flat};
  sites[1] = {.bone = 0, .muscle = 1, .contacts = 1, .difficulty = ContactDifficulty::thin};
  sites[2] = {.bone = 1, .muscle = 1, .contacts = 1, .difficulty = ContactDifficulty::thin};
  sites[3] = {.bone = 1, .muscle = 0, .contacts = 1, .difficulty = ContactDifficulty::ridge};
  const std::vector<SiteOffset> offsets{{0.001, false}, {-0.002, false}, {0.003, false}, {-0.004, true}};
  const SurfaceOffsets found = offset_statistics(sites, offsets, 2, 2);
  // 101 contacts: the 100th smallest length.
  EXPECT_EQ(found.all->p99_offset_m, 0.003);
  EXPECT_EQ(found.all->max_offset_m, 0.004);
  EXPECT_EQ(found.all->p99_inward_m, 0.002);
  EXPECT_EQ(found.all->p99_outward_m, 0.001);
  EXPECT_EQ(found.all->open_sites, 1);
  ASSERT_EQ(found.of_pairs.size(), 4U);
  EXPECT_EQ(found.of_pairs[1]->max_inward_m, 0.002);
  EXPECT_EQ(found.of_pairs[2]->max_inward_m, 0.004);
  EXPECT_EQ(found.of_pairs[3]->max_outward_m, 0.003);
  ASSERT_EQ(found.of_muscles.size(), 2U);
  EXPECT_EQ(found.of_muscles[1]->sites, 2);
  EXPECT_EQ(found.of_difficulties[static_cast<std::size_t>(ContactDifficulty::thin)]->max_offset_m, 0.003);
  EXPECT_FALSE(found.of_difficulties[static_cast<std::size_t>(ContactDifficulty::concave)]);
}

TEST(ContactSites, AreSpreadOverAllContactsOfAPair) {
  ContactSiteSampler sampler(2, {{.name = "a", .last_node = 10}, {.name = "b", .first_node = 10, .last_node = 20}});
  std::vector<Vec3> positions(20, Vec3::Zero());
  const std::vector<RigidMotion> poses{{Mat3::Identity(), Vec3(1, 0, 0)}, {}};
  for (int step = 0; step < 3000; ++step) {
    positions[3].y() = step;
    std::vector<Contact> truth{{3, 0, 0.25, Vec3::UnitZ()}};
    if (step == 1500) truth.push_back({12, 1, 0.5, Vec3::UnitX()});
    sampler.add(poses, positions, truth);
  }
  const std::vector<ContactSite> sites = sampler.sites();
  ASSERT_EQ(sites.size(), 751U);
  EXPECT_EQ(sites[0].contacts, 4);
  EXPECT_EQ(sites[100].surface_point_m, Vec3(-1, 4 * 100, 0.25));
  EXPECT_EQ(sites[749].surface_point_m, Vec3(-1, 4 * 749, 0.25));
  EXPECT_EQ(sites[750].surface_point_m, Vec3(0.5, 0, 0));
  EXPECT_EQ(sites[750].contacts, 1);
  EXPECT_EQ(sites[750].bone, 1);
  EXPECT_EQ(sites[750].muscle, 1);
}

TEST(ContactSites, AreToldApartByDifficulty) {
  // A plate 1 mm thick, 40 mm wide, a block on it.
  const Surface plate(make_box({0.1, 0.1, 0.0005}, 1), 0);
  const Surface block(make_box(Vec3::Constant(0.1), 1), 0);
  TriangleMesh muscle;
  muscle.vertices.resize(6, Vec3::Zero());
  muscle.triangles = {{0, 1, 2}, {3, 4, 5}};
  const std::vector<int> free_nodes{1, 2, 3, 4, 5};
  const auto difficulty = [&](const Surface& of, const Vec3& point, const Vec3& outward, int node = 3) {
    std::vector<ContactSite> sites{{.node = node, .surface_point_m = point, .outward = outward}};
    classify_sites(of.referee(), of.diagonals_m(), muscle, free_nodes, sites);
    return sites[0].difficulty;
  };
  EXPECT_EQ(difficulty(block, {0, 0, 0.1}, Vec3::UnitZ()), ContactDifficulty::flat);
  EXPECT_EQ(difficulty(block, {0, 0, 0.1}, Vec3::UnitZ(), 1), ContactDifficulty::attached_border);
  EXPECT_EQ(difficulty(block, {0, 0.0995, 0.1}, Vec3::UnitZ()), ContactDifficulty::ridge);
  EXPECT_EQ(difficulty(plate, {0, 0, 0.0005}, Vec3::UnitZ()), ContactDifficulty::thin);
  // In a pit of the block's complement: a ball's inside.
  TriangleMesh bowl = make_sphere(0.01, 4);
  for (Triangle& t : bowl.triangles) std::swap(t[1], t[2]);
  append(bowl, make_box(Vec3::Constant(0.1), 1));
  const Surface hollow(bowl, 0);
  EXPECT_EQ(difficulty(hollow, {0, 0, -0.01}, Vec3::UnitZ()), ContactDifficulty::concave);
}

}  // namespace
}  // namespace musclebench

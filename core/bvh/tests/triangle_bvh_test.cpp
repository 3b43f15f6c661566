#include "core/bvh/triangle_bvh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/bvh/tests/closest_by_brute_force.hpp"
#include "core/bvh/tests/exact_answers.hpp"
#include "core/bvh/triangle_bvh_search.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

ClosestPoint brute_force(const TriangleMesh& mesh, const Vec3& point) {
  return closest_by_brute_force(static_cast<int>(mesh.triangles.size()),
                                [&](int triangle) { return closest_on(mesh, triangle, point); });
}

/// Random triangles, some of them degenerate: the worst input for a tree.
TriangleMesh soup(int triangles) {
  TriangleMesh mesh;
  mesh.vertices = random_points(1, 3 * triangles);
  for (int t = 0; t < triangles; ++t) {
    mesh.triangles.push_back({3 * t, 3 * t + 1, t % 10 == 0 ? 3 * t : 3 * t + 2});
  }
  return mesh;
}

ClosestCandidate closest_listed(const TriangleBvh& tree, const Vec3& point, const CandidateLeaves& list,
                                double enough_m = std::numeric_limits<double>::infinity()) {
  TriangleBvh::Search search;
  tree.begin_candidate_search(point, list, search);
  return tree.finish_candidate_search(search, list, enough_m);
}

class TriangleBvhShapes : public testing::TestWithParam<TriangleMesh> {};

TEST_P(TriangleBvhShapes, ClosestPointIsThatOfBruteForce) {
  const TriangleMesh& mesh = GetParam();
  const TriangleBvh tree(mesh);
  int start = 0;
  for (const Vec3& point : random_points(1.5, 300)) {
    const ClosestPoint expected = brute_force(mesh, point);
    const std::optional<ClosestPoint> found = tree.closest_point(point);
    ASSERT_TRUE(found);
    expect_equal(*found, expected);
    start = (start + 37) % static_cast<int>(mesh.triangles.size());
    expect_equal(tree.closest_point_from(point, start), expected);
  }
}

TEST_P(TriangleBvhShapes, TheLargestDistanceOnlyDecidesWhetherThereIsAnAnswer) {
  const TriangleMesh& mesh = GetParam();
  const TriangleBvh tree(mesh);
  for (const Vec3& point : random_points(1.5, 100)) {
    const double distance = brute_force(mesh, point).distance_m;
    EXPECT_FALSE(tree.closest_point(point, 0.999 * distance));
    const std::optional<ClosestPoint> found = tree.closest_point(point, 1.001 * distance);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->distance_m, distance);
  }
}

TEST_P(TriangleBvhShapes, WindingNumberIsTheSumOfSolidAngles) {
  const TriangleMesh& mesh = GetParam();
  const TriangleBvh tree(mesh);
  for (const Vec3& point : random_points(1.5, 200)) {
    const double expected = exact_winding(mesh, point);
    const double found = tree.winding_number(point);
    EXPECT_NEAR(found, expected, 0.2);
    if (std::abs(expected - 0.5) > 1e-9) {
      EXPECT_EQ(found > 0.5, expected > 0.5) << point.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, TriangleBvhShapes,
                         testing::Values(make_sphere(1, 4), make_box({0.5, 1, 0.25}, 1), make_box({0.5, 1, 0.25}, 9),
                                         make_capsule(0.3, 0.9, 24), soup(500), soup(3)));

/// Surfaces that are hard for single precision, with points that are hard for a search: on the surface, at equal
/// distances from several triangles, beyond the tips of slivers, far away.
struct HardCase {
  std::string name;
  TriangleMesh mesh;
  std::vector<Vec3> points;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name.
void PrintTo(const HardCase& hard, std::ostream* out) { *out << hard.name; }

/// Slivers of all widths between two powers of ten, so close together that several are nearly the closest.
TriangleMesh slivers(std::mt19937& random, double thinnest, double widest) {
  std::uniform_real_distribution<double> unit(-1, 1);
  TriangleMesh mesh;
  for (int t = 0; t < 400; ++t) {
    const Vec3 start(unit(random), 0.01 * unit(random), 0.01 * unit(random));
    const Vec3 along(unit(random), 0.3 * unit(random), 0.3 * unit(random));
    const Vec3 across(0.1 * unit(random), unit(random), unit(random));
    const double width = std::pow(10.0, thinnest + 0.5 * (1 + unit(random)) * (widest - thinnest));
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(),
                         {start, start + along, start + 0.5 * (1 + unit(random)) * along + width * across});
    // Which corner comes first decides how closest_on_triangle errs.
    mesh.triangles.push_back({first + t % 3, first + (t + 1) % 3, first + (t + 2) % 3});
  }
  return mesh;
}

/// Slivers of which closest_on_triangle misses the closest point, each next to a plain triangle that it then takes to
/// be closer.
TriangleMesh slivers_over_triangles(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  TriangleMesh mesh;
  for (int t = 0; t < 200; ++t) {
    const Vec3 start(unit(random), unit(random), unit(random));
    const Vec3 along(unit(random), unit(random), unit(random));
    const Vec3 across = along.unitOrthogonal();
    const Vec3 beside = std::pow(10.0, 0.4 * unit(random) - 4.4) * along.cross(across);
    const double width = std::pow(10.0, 0.5 * unit(random) - 12.3);
    const double share = 0.5 * (1 + unit(random));
    for (const auto& [offset, height] : {std::pair(Vec3(Vec3::Zero()), width), std::pair(beside, 0.3)}) {
      const int first = static_cast<int>(mesh.vertices.size());
      mesh.vertices.insert(mesh.vertices.end(),
                           {start + offset, start + offset + along, start + offset + share * along + height * across});
      mesh.triangles.push_back({first + t % 3, first + (t + 1) % 3, first + (t + 2) % 3});
    }
  }
  return mesh;
}

/// Three coincident plane grids with different diagonals and windings.
TriangleMesh coincident_sheets() {
  TriangleMesh mesh;
  constexpr int side = 12;
  for (int i = 0; i < side * side; ++i) {
    mesh.vertices.emplace_back(i % side / 6.0 - 1, i / side / 6.0 - 1, 0.25);
  }
  for (int sheet = 0; sheet < 3; ++sheet) {
    for (int i = 0; i < (side - 1) * (side - 1); ++i) {
      const int a = i % (side - 1) + side * (i / (side - 1));
      const int b = a + 1;
      const int c = a + side;
      const int d = c + 1;
      if (sheet == 1) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      } else {
        mesh.triangles.push_back({a, d, b});
        mesh.triangles.push_back({a, c, d});
      }
    }
  }
  return mesh;
}

/// Random points, vertices, middles of triangles and of edges, and points close to them and above them.
std::vector<Vec3> points_about(const TriangleMesh& mesh, std::mt19937& random, int count) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::uniform_int_distribution<std::size_t> any(0, mesh.triangles.size() - 1);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const Triangle& t = mesh.triangles[any(random)];
    const Vec3& a = corner(mesh, t, 0);
    const Vec3& b = corner(mesh, t, 1);
    const Vec3& c = corner(mesh, t, 2);
    const Vec3 away(unit(random), unit(random), unit(random));
    const std::array<Vec3, 4> on = {a, 0.5 * (a + b), (a + b + c) / 3, 3 * b - 2 * a};
    const double distance = i % 3 == 0 ? 0 : std::pow(10.0, 4 * unit(random) - 3);
    points.emplace_back(i % 5 == 4 ? Vec3(1.5 * away) : Vec3(on[static_cast<std::size_t>(i % 4)] + distance * away));
    const Vec3 normal = (b - a).cross(c - a).stableNormalized();
    points.emplace_back(on[2] + unit(random) * normal);
  }
  points.emplace_back(1e3, -2e4, 5e3);
  points.emplace_back(3e9, 1e7, -1e8);
  points.emplace_back(1e20, 1e20, -1e20);
  return points;
}

std::vector<HardCase> hard_cases() {
  std::mt19937 random(17);
  std::vector<HardCase> cases;
  const auto add = [&](const std::string& name, const TriangleMesh& mesh) {
    cases.push_back({name, mesh, points_about(mesh, random, 300)});
  };
  add("soup", soup(400));
  add("slivers", slivers(random, -17, -1));
  // So thin that closest_on_triangle may take any point of them for the closest one.
  add("thin_slivers", slivers(random, -12, -7));
  add("slivers_over_triangles", slivers_over_triangles(random));
  add("sheets", coincident_sheets());
  TriangleMesh points_and_segments = soup(300);
  for (Triangle& t : points_and_segments.triangles) {
    t[2] = t[0] % 2 == 0 ? t[0] : t[1];
    t[1] = t[0] % 4 == 1 ? t[0] : t[1];
  }
  add("points_and_segments", points_and_segments);
  TriangleMesh point;
  point.vertices = {{1, 2, 3}};
  point.triangles = {{0, 0, 0}, {0, 0, 0}};
  add("one_point", point);
  const std::size_t plain = cases.size();
  for (const double scale : {1e-6, 1e3}) {
    for (std::size_t i = 0; i < plain; ++i) {
      HardCase scaled = cases[i];
      scaled.name += scale < 1 ? "_tiny" : "_large";
      for (std::vector<Vec3>* positions : {&scaled.mesh.vertices, &scaled.points}) {
        for (Vec3& position : *positions) {
          position *= scale;
        }
      }
      cases.push_back(scaled);
    }
  }
  for (const double offset : {10.0, 1e6, 1e12}) {
    for (std::size_t i = 0; i < plain; ++i) {
      HardCase moved = cases[i];
      moved.name += offset < 1e3 ? "_moved" : offset < 1e9 ? "_far_away" : "_farther_away";
      for (std::vector<Vec3>* positions : {&moved.mesh.vertices, &moved.points}) {
        for (Vec3& position : *positions) {
          position += offset * Vec3(1, -0.7, 0.3);
        }
      }
      cases.push_back(moved);
    }
  }
  return cases;
}

class TriangleBvhHardCases : public testing::TestWithParam<HardCase> {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(TriangleBvhHardCases, AnswersAreThoseOfBruteForceOnEverySimdTarget) {
  const auto& [name, mesh, points] = GetParam();
  const TriangleBvh tree(mesh);
  std::vector<ClosestPoint> expected;
  for (const Vec3& point : points) {
    expected.push_back(brute_force(mesh, point));
  }
  const auto count = static_cast<int>(mesh.triangles.size());
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    for (std::size_t i = 0; i < points.size(); ++i) {
      SCOPED_TRACE(name + " " + hwy::TargetName(target) + " point " + std::to_string(i));
      expect_equal(tree.closest_point(points[i]).value(), expected[i]);
      expect_equal(tree.closest_point_from(points[i], static_cast<int>(7 * i) % count), expected[i]);
      expect_equal(tree.closest_point_from(points[i], expected[i].triangle), expected[i]);
      // The bound is a double, which the root of a square need not be.
      const double bound = expected[i].distance_m * (1 + 1e-15);
      expect_equal(tree.closest_point(points[i], bound).value(), expected[i]);
      if (testing::Test::HasFailure()) {
        return;
      }
    }
  }
}

/// A list about each point, searched from points very close to it, near it and far from it.
TEST_P(TriangleBvhHardCases, ACandidateListAnswersAsASearchDoesOrIsNotCertain) {
  const auto& [name, mesh, points] = GetParam();
  const TriangleBvh tree(mesh);
  const std::vector<Vec3> directions = random_points(1, static_cast<int>(points.size()));
  Vec3 lower = mesh.vertices.front();
  Vec3 upper = lower;
  for (const Vec3& vertex : mesh.vertices) {
    lower = lower.cwiseMin(vertex);
    upper = upper.cwiseMax(vertex);
  }
  const double size = (upper - lower).norm();
  int cleared = 0;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    for (std::size_t i = 0; i < points.size(); i += 3) {
      const double distance = tree.closest_point(points[i]).value().distance_m;
      for (const double reach : {0.0, 0.03 * size, 0.5 * size}) {
        CandidateLeaves list;
        tree.list_candidate_leaves(points[i], distance + reach, list);
        for (const double share : {0.0, 1e-6, 0.01, 0.1}) {
          SCOPED_TRACE(name + " " + hwy::TargetName(target) + " point " + std::to_string(i));
          const Vec3 point = points[i] + share * size * directions[i];
          if (list.empty()) {
            continue;
          }
          const ClosestCandidate listed = closest_listed(tree, point, list);
          // A bound alone is returned only where it exceeds `enough_m`, and it holds.
          const ClosestPoint exact = brute_force(mesh, point);
          const ClosestCandidate less = closest_listed(tree, point, list, 0.7 * exact.distance_m);
          EXPECT_LE(less.clearance_m, exact.distance_m);
          EXPECT_TRUE(less.clearance_m == 0 || less.clearance_m > 0.7 * exact.distance_m);
          cleared += less.clearance_m > 0 ? 1 : 0;
          if (listed.certain) {
            expect_equal(listed.closest, exact);
            expect_equal(closest_listed(tree, point, list, exact.distance_m).closest, exact);
          } else {
            EXPECT_GE(listed.closest.triangle, 0);
          }
        }
        if (testing::Test::HasFailure()) {
          return;
        }
      }
    }
  }
  EXPECT_GT(cleared, 0) << name;
}

TEST_P(TriangleBvhHardCases, AClearanceIsNeverMoreThanTheDistance) {
  const auto& [name, mesh, points] = GetParam();
  const TriangleBvh tree(mesh);
  const int count = static_cast<int>(mesh.triangles.size());
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    for (std::size_t i = 0; i < points.size(); ++i) {
      SCOPED_TRACE(name + " " + hwy::TargetName(target) + " point " + std::to_string(i));
      const Clearance clearance = tree.clearance_from(points[i], static_cast<int>(7 * i) % count);
      const double distance = brute_force(mesh, points[i]).distance_m;
      ASSERT_LE(clearance.distance_m, distance);
      ASSERT_GE(clearance.triangle, 0);
      ASSERT_LT(clearance.triangle, count);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, TriangleBvhHardCases, testing::ValuesIn(hard_cases()),
                         [](const auto& hard) { return hard.param.name; });

TEST(TriangleBvh, ACandidateListIsCertainWhileThePointStaysNear) {
  const TriangleMesh mesh = make_sphere(0.1, 5);
  const TriangleBvh tree(mesh);
  int certain = 0;
  int asked = 0;
  for (const Vec3& random : random_points(1, 200)) {
    const Vec3 centre = (0.1 + 0.002 * random.x()) * random.normalized();
    CandidateLeaves list;
    tree.list_candidate_leaves(centre, tree.closest_point(centre)->distance_m + 0.008, list);
    ASSERT_FALSE(list.empty());
    for (const double moved : {0.0, 5e-4, 1e-3}) {
      const Vec3 point = centre + moved * Vec3(random.y(), random.z(), random.x()).normalized();
      ++asked;
      certain += closest_listed(tree, point, list).certain ? 1 : 0;
      EXPECT_FALSE(closest_listed(tree, centre + Vec3(0, 0, 0.05), list).certain);
    }
  }
  EXPECT_EQ(certain, asked);
}

TEST(TriangleBvh, AClearanceIsNineTenthsOfTheDistanceFromAnyStart) {
  const TriangleMesh mesh = make_sphere(0.1, 4);
  const TriangleBvh tree(mesh);
  int start = 0;
  for (const Vec3& point : random_points(0.3, 300)) {
    start = (start + 371) % static_cast<int>(mesh.triangles.size());
    const double distance = brute_force(mesh, point).distance_m;
    const Clearance clearance = tree.clearance_from(point, start);
    EXPECT_GE(clearance.distance_m, 0.9 * distance - 3e-6);
    EXPECT_LE(tree.clearance_from(point, clearance.triangle).distance_m, distance);
  }
}

TEST(TriangleBvh, PointsThatAreNotFiniteHaveNoClosestPoint) {
  const TriangleMesh mesh = make_sphere(1, 1);
  const TriangleBvh tree(mesh);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(tree.closest_point({0, nan, 0}));
  EXPECT_EQ(tree.closest_point_from({0, nan, 0}, 3).triangle, 3);
  EXPECT_FALSE(tree.closest_point({0, 0, 0}, nan));
  EXPECT_FALSE(tree.closest_point({0, 0, 0}, -1));
}

TEST(TriangleBvh, IsDeepEnoughForManyCoincidentTriangles) {
  TriangleMesh mesh = make_sphere(1, 0);
  const std::vector<Triangle> once = mesh.triangles;
  for (int copy = 0; copy < 500; ++copy) {
    mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
  }
  const TriangleBvh tree(mesh);
  const Vec3 point(0.3, 0.2, 1.4);
  EXPECT_EQ(tree.closest_point(point)->triangle, brute_force(mesh, point).triangle);
}

TEST(TriangleBvh, WindingNumberCountsNestedSurfaces) {
  TriangleMesh mesh = make_sphere(1, 3);
  const TriangleMesh inner = make_sphere(0.5, 3);
  const auto offset = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), inner.vertices.begin(), inner.vertices.end());
  for (const Triangle& t : inner.triangles) {
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  const TriangleBvh tree(mesh);
  EXPECT_NEAR(tree.winding_number({0.1, 0, 0.2}), 2, 0.1);
  EXPECT_NEAR(tree.winding_number({0.7, 0, 0.2}), 1, 0.1);
  EXPECT_NEAR(tree.winding_number({1.7, 0, 0.2}), 0, 0.1);
}

TEST(TriangleBvh, OfNoTrianglesHasNoClosestPoint) {
  const TriangleBvh tree((TriangleMesh()));
  EXPECT_FALSE(tree.closest_point(Vec3::Zero()));
  EXPECT_EQ(tree.winding_number(Vec3::Zero()), 0);
}

/// In the mouth of a bowl the winding number goes through 0.5 where there is no surface: dipoles may not decide there.
TEST(TriangleBvh, TheSideInAnOpeningIsThatOfTheExactWindingNumber) {
  TriangleMesh bowl = make_sphere(1, 4);
  std::erase_if(bowl.triangles, [&](const Triangle& t) {
    return std::ranges::all_of(t,
                               [&](int vertex) { return bowl.vertices[static_cast<std::size_t>(vertex)].z() > 0.3; });
  });
  const TriangleBvh tree(bowl);
  for (int i = 0; i < 40; ++i) {
    const double x = 0.02 * i;
    double low = 0;  // inside
    double high = 1.5;
    while (high - low > 1e-7) {
      const double middle = 0.5 * (low + high);
      (exact_winding(bowl, {x, 0.1, middle}) > 0.5 ? low : high) = middle;
    }
    EXPECT_GT(tree.winding_number({x, 0.1, low - 1e-7}), 0.5) << x;
    EXPECT_LT(tree.winding_number({x, 0.1, high + 1e-7}), 0.5) << x;
  }
}

}  // namespace
}  // namespace musclebench

#include "core/clearance/located_triangles.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/clearance/point_backend.hpp"
#include "core/mesh/shapes.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

/// Counts what it is asked.
struct Counts {
  long closest = 0;
  long lists = 0;
};

/// Goes through all triangles. `lists_nothing`: as a library that can't list would.
class SlowLibrary {
 public:
  SlowLibrary(const Bone& bone, Counts& counts, double list_share)
      : m_bone(bone), m_counts(counts), m_share(list_share) {}

  [[nodiscard]] int closest(const Vec3& point, int /*near*/) const {
    ++m_counts.closest;
    int best = -1;
    for (int i = 0; i < static_cast<int>(triangles().size()); ++i) {
      if (best < 0 || distance_m(point, i) < distance_m(point, best)) best = i;
    }
    return best;
  }
  void list_within(const Vec3& point, double radius_m, ListedTriangles& list) const {
    ++m_counts.lists;
    for (int i = 0; i < static_cast<int>(triangles().size()); ++i) {
      if (distance_m(point, i) < m_share * radius_m) {
        list.add(i);
        list.add(i);  // trees that split triangles tell them more than once
      }
    }
  }
  [[nodiscard]] bool is_inside(const Vec3& point) const { return m_bone.signed_distance().locate(point).inside; }
  [[nodiscard]] AnswerBound answer_bound() const {
    const double touching_m = touching_distance_m(m_bone.surface.mesh);
    return {touching_m, touching_m};
  }
  [[nodiscard]] std::size_t bytes() const { return sizeof(*this); }

 private:
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return m_bone.surface.mesh.triangles; }
  [[nodiscard]] double distance_m(const Vec3& point, int triangle) const {
    const auto& [a, b, c] = triangles()[static_cast<std::size_t>(triangle)];
    const std::vector<Vec3>& vertices = m_bone.surface.mesh.vertices;
    return std::sqrt(closest_on_triangle(point, vertices[static_cast<std::size_t>(a)],
                                         vertices[static_cast<std::size_t>(b)], vertices[static_cast<std::size_t>(c)])
                         .squared_distance_m2);
  }

  const Bone& m_bone;
  Counts& m_counts;
  double m_share;
};

/// Nodes that wander about the surface of a ball, with and without lists.
class LocatedTrianglesOfABall : public testing::Test {
 protected:
  std::vector<std::vector<Contact>> contacts_of(bool has_cache, double list_share, Counts& counts) {
    const Bone ball{"ball", repair_mesh(make_sphere(0.03, 4), "ball")};
    const auto backend = make_point_backend(
        {.capabilities = {.has_cache = has_cache},
         .build = build_on_triangles(Parameters({cull_parameter()}, {}, "slow"), [&](const Bone& bone) {
           return std::make_unique<const SlowLibrary>(bone, counts, list_share);
         })});
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<Vec3> nodes;
    std::vector<int> indices;
    for (int i = 0; i < 16; ++i) {
      nodes.push_back(0.0302 * Vec3(normal(random), normal(random), normal(random)).normalized());
      indices.push_back(i);
    }
    const TriangleMesh muscle{nodes, {}};
    backend->build(std::span(&ball, 1), muscle, 1);
    std::vector<std::vector<Contact>> found;
    for (int step = 0; step < 30; ++step) {
      for (Vec3& node : nodes) node += 5e-4 * Vec3(normal(random), normal(random), normal(random));
      backend->update(std::vector<RigidMotion>(1), nodes);
      backend->detect(nodes, indices, found.emplace_back());
    }
    return found;
  }
};

void expect_same(const std::vector<std::vector<Contact>>& one, const std::vector<std::vector<Contact>>& other) {
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t step = 0; step < one.size(); ++step) {
    ASSERT_EQ(one[step].size(), other[step].size()) << step;
    for (std::size_t i = 0; i < one[step].size(); ++i) {
      EXPECT_EQ(one[step][i].node, other[step][i].node);
      EXPECT_EQ(one[step][i].depth_m, other[step][i].depth_m);
      EXPECT_EQ(one[step][i].normal, other[step][i].normal);
    }
  }
}

TEST_F(LocatedTrianglesOfABall, ListsSaveTheLibraryMostQueriesAndChangeNoBit) {
  Counts without;
  Counts with;
  const auto truth = contacts_of(false, 1, without);
  const auto found = contacts_of(true, 1, with);
  expect_same(found, truth);
  EXPECT_EQ(without.lists, 0);
  EXPECT_GT(with.lists, 0);
  EXPECT_LT(3 * with.closest, 2 * without.closest);
}

TEST_F(LocatedTrianglesOfABall, ALibraryThatListsTooMuchIsAskedEachTime) {
  Counts without;
  Counts with;
  const auto truth = contacts_of(false, 1, without);
  const auto found = contacts_of(true, 1e6, with);  // each list has all triangles and overflows
  expect_same(found, truth);
  EXPECT_GT(with.closest, 100);
}

TEST(ListedTriangles, CountEachOnceAndSayWhenTheyOverflow) {
  ListedTriangles list;
  for (int i = 0; i < static_cast<int>(ListedTriangles::capacity); ++i) {
    list.add(i);
    list.add(i);
  }
  EXPECT_FALSE(list.has_overflowed());
  EXPECT_EQ(std::distance(list.begin(), list.end()), static_cast<std::ptrdiff_t>(ListedTriangles::capacity));
  list.add(100);
  EXPECT_TRUE(list.has_overflowed());
  list.clear();
  EXPECT_TRUE(list.empty());
}

}  // namespace
}  // namespace musclebench

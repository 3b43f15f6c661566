#include "core/effects/self_contact/self_contact.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/distance/triangle_distance.hpp"

namespace musclebench {
namespace {

constexpr double edge_m = 0.005;
constexpr double thickness_m = 0.001;
constexpr int rows = 5;

/// A strip along x that is folded back over itself: below at z = 0, above at z = `gap_m`, with `columns` nodes each.
TriangleMesh folded_sheet(double gap_m, int columns = 8) {
  TriangleMesh mesh;
  const auto add_column = [&](double x_m, double z_m) {
    for (int j = 0; j < rows; ++j) mesh.vertices.emplace_back(x_m, edge_m * j, z_m);
  };
  for (int i = 0; i < columns; ++i) add_column(edge_m * i, 0);
  add_column(edge_m * columns, 0.5 * gap_m);
  for (int i = columns - 1; i >= 0; --i) add_column(edge_m * (i + 0.3), gap_m);  // nodes are not above nodes
  const int last = static_cast<int>(mesh.vertices.size()) / rows - 1;
  for (int i = 0; i < last; ++i) {
    for (int j = 0; j + 1 < rows; ++j) {
      const int a = rows * i + j;
      mesh.triangles.push_back({a, a + rows, a + rows + 1});
      mesh.triangles.push_back({a, a + rows + 1, a + 1});
    }
  }
  return mesh;
}

struct Folding {
  explicit Folding(TriangleMesh of, int with_threads = 1)
      : mesh(std::move(of)),
        bodies{{.name = "strip",
                .first_node = 0,
                .last_node = static_cast<int>(mesh.vertices.size()),
                .first_triangle = 0,
                .last_triangle = mesh.triangles.size()}},
        masses(mesh.vertices.size(), 2),
        start(mesh.vertices),
        predicted(mesh.vertices),
        threads(with_threads) {}

  void step() {
    if (!stage) {
      const EffectEntry* entry = find_effect("self_contact");
      const std::map<std::string, ParameterValue> given = {{"thickness_m", thickness_m}, {"steps", std::int64_t{30}}};
      stage = entry->make_stage({.bones = {},
                                 .nodes = mesh.vertices.size(),
                                 .triangles = mesh.triangles,
                                 .inverse_masses = masses,
                                 .threads = threads,
                                 .mesh = &mesh,
                                 .bodies = bodies},
                                Parameters(entry->parameters, given, "test"));
    }
    (void)stage->before_bones({start, predicted, {}, {}, {}, {}});
  }

  /// Moves the upper half by `by_m` a step; what a step ends with is where the next one starts.
  void press(const Vec3& by_m, int steps) {
    for (int i = 0; i < steps; ++i) {
      predicted = start;
      for (std::size_t node = mesh.vertices.size() / 2 + 3; node < mesh.vertices.size(); ++node)
        predicted[node] += by_m;
      step();
      start = predicted;
    }
  }

  /// Smallest distance of an upper node from the lower layer, positive above it.
  [[nodiscard]] double least_gap_m() const {
    double least_m = 1;
    const std::size_t lower = mesh.triangles.size() / 2 - 2 * (rows - 1);
    for (std::size_t node = mesh.vertices.size() / 2 + 3; node < mesh.vertices.size(); ++node) {
      for (std::size_t t = 0; t < lower; ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const ClosestOnTriangle found =
            closest_on_triangle(predicted[node], predicted[static_cast<std::size_t>(a)],
                                predicted[static_cast<std::size_t>(b)], predicted[static_cast<std::size_t>(c)]);
        const double distance_m = std::sqrt(found.squared_distance_m2);
        least_m = std::min(least_m, predicted[node].z() > found.point.z() ? distance_m : -distance_m);
      }
    }
    return least_m;
  }

  [[nodiscard]] Vec3 momentum(const std::vector<Vec3>& before) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < before.size(); ++i) sum += (predicted[i] - before[i]) / masses[i];
    return sum;
  }

  TriangleMesh mesh;
  std::vector<Body> bodies;
  std::vector<double> masses;
  std::vector<Vec3> start;
  std::vector<Vec3> predicted;
  int threads;
  std::unique_ptr<ContactStage> stage;
};

TEST(SelfContact, LayersOfAFoldedSheetStayAThicknessApart) {
  Folding fold(folded_sheet(0.01));
  fold.press(Vec3(0, 0, -0.0002), 60);  // past the other layer, did that not give way
  EXPECT_GT(fold.least_gap_m(), 0.9 * thickness_m);
  EXPECT_LT(fold.least_gap_m(), 1.5 * thickness_m) << "it was pressed against the other layer";
  EXPECT_GT(fold.stage->contact_count(), 0);
  EXPECT_EQ(fold.stage->name(), "self_contact");
}

TEST(SelfContact, WithoutItTheLayersPassThroughEachOther) {
  Folding fold(folded_sheet(0.01));
  for (std::size_t node = fold.mesh.vertices.size() / 2 + 3; node < fold.mesh.vertices.size(); ++node) {
    fold.predicted[node].z() -= 60 * 0.0002;
  }
  EXPECT_LT(fold.least_gap_m(), 0);
}

TEST(SelfContact, BothSidesGiveWayByTheirMasses) {
  Folding fold(folded_sheet(0.01));
  for (std::size_t i = 0; i < fold.masses.size(); ++i) fold.masses[i] = i % 3 == 0 ? 1 : 5;
  fold.press(Vec3(0, 0, -0.0002), 46);
  fold.predicted = fold.start;
  for (std::size_t node = fold.mesh.vertices.size() / 2 + 3; node < fold.mesh.vertices.size(); ++node) {
    fold.predicted[node].z() -= 0.0002;
  }
  const std::vector<Vec3> before = fold.predicted;
  fold.step();
  EXPECT_GT((fold.predicted[2] - before[2]).norm() + (fold.predicted[17] - before[17]).norm(), 1e-6);
  EXPECT_LT(fold.momentum(before).norm(), 1e-16);
}

TEST(SelfContact, WhatIsFarApartIsLeftToTheBit) {
  Folding fold(folded_sheet(0.01));
  for (int i = 0; i < 10; ++i) fold.step();
  EXPECT_EQ(fold.predicted, fold.mesh.vertices);
  EXPECT_EQ(fold.stage->contact_count(), 0);
}

TEST(SelfContact, LayersThatAreNearAtRestAreNoConcern) {
  Folding fold(folded_sheet(1.5 * thickness_m));
  fold.press(Vec3(0, 0, -0.0001), 10);
  const double gap_m = 0.5 * thickness_m;
  EXPECT_NEAR(fold.least_gap_m(), gap_m, 1e-6);
}

/// Of the triangles that are near at rest more than a dozen come still nearer.
TEST(SelfContact, LayersThatSlideOverEachOtherAsNearAsAtRestAreNoConcern) {
  Folding fold(folded_sheet(1.5 * thickness_m));
  fold.press(Vec3(-0.00035, 0, -0.0001), 10);
  EXPECT_NEAR(fold.least_gap_m(), 0.5 * thickness_m, 1e-6);
  EXPECT_EQ(fold.stage->contact_count(), 0);
}

TEST(SelfContact, DepthAtTheStartGivesNoVelocity) {
  Folding fold(folded_sheet(0.01));
  fold.step();
  for (std::size_t node = fold.mesh.vertices.size() / 2 + 3; node < fold.mesh.vertices.size(); ++node) {
    fold.start[node].z() -= 0.0095;  // half a thickness is left
  }
  fold.predicted = fold.start;
  const std::vector<Vec3> before = fold.predicted;
  fold.step();
  double moved_m = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_LT((fold.predicted[i] - fold.start[i]).norm(), 1e-15) << i;
    moved_m = std::max(moved_m, (fold.predicted[i] - before[i]).norm());
  }
  EXPECT_GT(moved_m, 1e-5);
}

TEST(SelfContact, NoBitDependsOnTheThreads) {
  Folding one(folded_sheet(0.01));
  Folding three(folded_sheet(0.01), 3);
  one.press(Vec3(0.0001, 0, -0.0002), 60);
  three.press(Vec3(0.0001, 0, -0.0002), 60);
  EXPECT_EQ(one.predicted, three.predicted);
}

}  // namespace
}  // namespace musclebench

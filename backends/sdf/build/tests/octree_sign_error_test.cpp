#include "backends/sdf/build/octree_sign_error.hpp"

#include <memory>

#include <gtest/gtest.h>

#include "backends/sdf/build/octree_cells.hpp"
#include "backends/sdf/build/octree_fit.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// A leaf of half edge 1 with exact distances at `known` samples.
OctreeCell sampled_cell(const SignedSurface& surface, const Vec3& centre_m, std::size_t known = cell_samples) {
  OctreeCell cell;
  cell.centre_m = centre_m;
  cell.half_edge_m = 1;
  cell.distance_m = surface.locate(centre_m).signed_distance_m();
  cell.leaf = std::make_unique<OctreeCell::Leaf>();
  for (std::size_t s = 0; s < known; ++s) {
    const SignedPoint located = surface.locate(centre_m + sample_position(s));
    cell.leaf->samples[s] = {located.signed_distance_m(), {0, 0, 1}, located.closest.triangle};
  }
  return cell;
}

TEST(OctreeSignError, IsWhereThePolynomialIsNegativeOutside) {
  // Everything below z = -0.4 is inside; the polynomial takes everything below z = 0.1 for it.
  const RepairedMesh box{make_box({10, 10, 9.6}, 1), true, {}};
  const SignedSurface surface(box);
  OctreeCell cell = sampled_cell(surface, Vec3(0, 0, 10));
  PolynomialFit& fit = cell.leaf->quadratic;
  fit.coefficients[0] = -0.1F;
  fit.coefficients[3] = 1;
  for (const double least_m : {0.01, 0.1, 0.4}) {
    const double reach_m = sign_error_distance_m(surface, cell, fit, quadratic_terms, least_m);
    EXPECT_GE(reach_m, 0.5);
    EXPECT_LE(reach_m, 0.5 + least_m);
  }
  EXPECT_EQ(sign_error_distance_m(surface, cell, fit, quadratic_terms, 0.8), 0.8);
  fit.coefficients[0] = 1.1F;
  EXPECT_EQ(sign_error_distance_m(surface, cell, fit, quadratic_terms, 0.01), 0.01);
  // Flat and positive in the middle.
  for (const std::size_t falling : {std::size_t{4}, quadratic_terms}) {
    fit = {};
    fit.coefficients[0] = 0.5F;
    fit.coefficients[falling] = -1;
    EXPECT_NEAR(sign_error_distance_m(surface, cell, fit, cubic_terms, 0.1), 1.4, 0.1);
  }
}

/// Where it is negative deep inside only, nothing is to be proven, whatever triangles the samples name.
TEST(OctreeSignError, IsTheLeastWhereThePolynomialIsTheDistance) {
  const RepairedMesh box{make_box({10, 10, 9.6}, 4), true, {}};
  const SignedSurface surface(box);
  for (const double above_m : {-1.4, -0.5, 0.2}) {
    for (const std::size_t known : {lattice_samples, cell_samples}) {
      OctreeCell cell = sampled_cell(surface, Vec3(0.3, 0.2, 9.6 + above_m), known);
      PolynomialFit& fit = cell.leaf->quadratic;
      fit.coefficients[0] = static_cast<float>(above_m);
      fit.coefficients[3] = 1;
      for (const double least_m : {0.02, 0.3}) {
        EXPECT_EQ(sign_error_distance_m(surface, cell, fit, quadratic_terms, least_m), least_m);
      }
      for (std::size_t s = 0; s < known; ++s) {
        cell.leaf->samples[s].triangle = 0;
      }
      EXPECT_EQ(sign_error_distance_m(surface, cell, fit, quadratic_terms, 0.02), 0.02);
    }
  }
}

}  // namespace
}  // namespace musclebench

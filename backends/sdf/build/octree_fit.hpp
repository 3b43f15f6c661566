#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "backends/sdf/octree/octree_polynomial.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// The exact signed distance at one point, and its gradient.
struct DistanceSample {
  double value_m = 0;             ///< negative inside
  std::array<float, 3> gradient;  ///< of the distance: unit
  int triangle = -1;              ///< the closest one
};

/// A cell is sampled at 27 lattice points (corners, edge and face midpoints, centre; x changing slowest); then, where
/// it may matter, at the centres of its eight octants, x changing fastest. A child's centre is the centre of its
/// parent's octant, and 8 of its lattice points are its parent's.
inline constexpr std::size_t lattice_samples = 27;
inline constexpr std::size_t cell_samples = 35;
using CellSamples = std::array<DistanceSample, cell_samples>;
/// The octant centres are all known or none is.
inline std::size_t known_samples(const CellSamples& samples) {
  return samples[lattice_samples].triangle >= 0 ? cell_samples : lattice_samples;
}

/// Sample positions in [-1, 1]^3. A table avoids a store-forwarding stall: positions computed on the spot are stored in
/// parts and read whole.
inline constexpr std::array<std::array<double, 3>, cell_samples> sample_positions = [] {
  std::array<std::array<double, 3>, cell_samples> positions{};
  for (std::size_t s = 0; s < lattice_samples; ++s) {
    const std::array<std::size_t, 3> index{s / 9, s / 3 % 3, s % 3};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      positions[s][axis] = static_cast<double>(index[axis]) - 1;
    }
  }
  for (std::size_t octant = 0; octant < 8; ++octant) {
    const auto middle = [&](std::size_t bit) { return (octant >> bit & 1U) != 0 ? 0.5 : -0.5; };
    positions[lattice_samples + octant] = {middle(0), middle(1), middle(2)};
  }
  return positions;
}();
inline Vec3 sample_position(std::size_t sample) { return Eigen::Map<const Vec3>(sample_positions[sample].data()); }

/// A cell's polynomial: the best one of its degree by least squares in values and (with less weight) gradients.
struct PolynomialFit {
  std::array<float, cubic_terms> coefficients{};
  double bound_m = 0;  ///< of the error, anywhere in the cell (reports/performance/field_bounds.md)
  /// At the cell's samples where the polynomial is positive it is above the exact distance by no more than this.
  double excess_m = 0;

  [[nodiscard]] double value(const Vec3& at, std::size_t terms) const;
  /// Nowhere in the cell is the polynomial larger, or smaller.
  [[nodiscard]] double largest() const { return coefficients[0] + spread(); }
  [[nodiscard]] double smallest() const { return coefficients[0] - spread(); }
  /// Lipschitz bound of the polynomial, per metre.
  [[nodiscard]] double lipschitz_bound(double half_edge_m) const;

 private:
  [[nodiscard]] double spread() const;
};

/// At the samples of a cell, 0 where they are not known; whole vectors, whatever their width.
inline constexpr std::size_t padded_samples = (cell_samples + 7) / 8 * 8;
using CellErrors = std::array<float, padded_samples>;

/// Fits polynomials of `terms` coefficients; made once, for all cells. In single precision, as the coefficients are,
/// relative to the value in the middle: the differences are no more than the cell's diagonal.
template <std::size_t terms>
class PolynomialFitter {
 public:
  PolynomialFitter();

  /// The coefficients, by all samples that are known.
  [[nodiscard]] PolynomialFit fit(const CellSamples& samples, double half_edge_m) const;
  /// Sets the bound and the excess.
  [[nodiscard]] CellErrors measure(const CellSamples& samples, double half_edge_m, PolynomialFit& fit) const;

 private:
  static constexpr std::size_t padded_terms = (terms + 7) / 8 * 8;
  using Row = std::array<float, padded_terms>;

  /// Of a sample's value and derivatives in each term.
  using Shares = std::array<Row, 4>;

  /// For the first `known` samples.
  static std::vector<Shares> shares(std::size_t known);

  std::vector<Shares> m_of_lattice = shares(lattice_samples);
  std::vector<Shares> m_of_all = shares(cell_samples);
  std::array<std::array<float, padded_samples>, terms> m_powers{};  ///< each term at each sample
};

}  // namespace musclebench

#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// One cubic serendipity cell of 32 node values: its 8 corners, and on each of its 12 edges two nodes at the thirds.
///
/// Over the unit cell the field is the trilinear polynomial of the corners plus, for each edge, a cubic bubble along
/// the edge that vanishes at its ends, blended bilinearly across. That is the basis of Koschier et al. 2017
/// (Hierarchical hp-adaptive signed distance fields) with its common factors pulled out: with N the trilinear function
/// of a corner, N (9 (xi^2 + eta^2 + zeta^2) - 19) / 8 is N minus the contributions of the three edges that start
/// there. It reproduces every polynomial of degree 3 and is continuous across faces.
struct CubicCell {
  /// The four edges along one axis, side by side: index 2 p + q for the edge at p, q of {0, 1} along the two other
  /// axes, taken in ascending order.
  using Edges = Eigen::Array4d;

  struct Along {
    Edges low;     ///< corners at 0
    Edges first;   ///< nodes at 1/3
    Edges second;  ///< nodes at 2/3
    Edges high;    ///< corners at 1
  };
  std::array<Along, 3> axis;  ///< each corner is stored in all three

  /// Values of a run: a grid vertex's record and the part of the next that a cell reads (see GridShape).
  static constexpr std::size_t run_size = 12;

  /// The cell whose edge along x at (y, z) starts at record[2 y + z], where a record is a grid vertex's seven values:
  /// corner, two nodes along y, two along z, two along x; the next record of the row follows it.
  static CubicCell gather(const std::array<const float*, 4>& record) {
    const auto edges = [](float a, float b, float c, float d) { return Edges(a, b, c, d); };
    const auto& [r00, r01, r10, r11] = record;
    CubicCell cell;
    cell.axis[0] = {edges(r00[0], r01[0], r10[0], r11[0]), edges(r00[5], r01[5], r10[5], r11[5]),
                    edges(r00[6], r01[6], r10[6], r11[6]), edges(r00[7], r01[7], r10[7], r11[7])};
    cell.axis[1] = {edges(r00[0], r01[0], r00[7], r01[7]), edges(r00[1], r01[1], r00[8], r01[8]),
                    edges(r00[2], r01[2], r00[9], r01[9]), edges(r10[0], r11[0], r10[7], r11[7])};
    cell.axis[2] = {edges(r00[0], r10[0], r00[7], r10[7]), edges(r00[3], r10[3], r00[10], r10[10]),
                    edges(r00[4], r10[4], r00[11], r10[11]), edges(r01[0], r11[0], r01[7], r11[7])};
    return cell;
  }

  /// The field at `at`, in [0, 1]^3.
  [[nodiscard]] double value(const Vec3& at) const;

  /// The field and its derivatives along the unit cell's axes.
  [[nodiscard]] double value_and_gradient(const Vec3& at, Vec3& gradient) const;

  /// The polynomial's 64 Bernstein coefficients, at [16 x + 4 y + z]: by the convex hull property the field lies
  /// between the smallest and the largest, and on a face between those of the face.
  using Bernstein = std::array<double, 64>;
  [[nodiscard]] Bernstein bernstein() const;

  [[nodiscard]] double lower_bound() const;

  /// Lipschitz bound of the polynomial with these coefficients in a cell with these edges: the longest of the
  /// gradient's own Bernstein coefficients.
  [[nodiscard]] static double lipschitz_bound(const Bernstein& coefficients, const Vec3& cell_size_m);
};

}  // namespace musclebench

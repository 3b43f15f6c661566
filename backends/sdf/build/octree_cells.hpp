#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "backends/sdf/build/octree_fit.hpp"
#include "core/bvh/batch/batched_closest_point.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// The error that the leaves of an octree are judged by. Lengths in metres.
struct ErrorTarget {
  double wanted_m = 0;
  double near_m = 0;
  double finest_edge_m = 0;  ///< smaller cells are not made

  /// The allowed error at a point of this exact distance.
  [[nodiscard]] double allowed_m(double distance_m) const;
};

/// A cell of an octree that is being built.
struct OctreeCell {
  /// Samples and fits of a leaf that needs a polynomial.
  struct Leaf {
    CellSamples samples;
    PolynomialFit quadratic;
    PolynomialFit cubic;
  };

  Vec3 centre_m = Vec3::Zero();
  double half_edge_m = 0;
  double distance_m = 0;        ///< at the centre, exact
  std::size_t first_child = 0;  ///< 0: none
  std::unique_ptr<Leaf> leaf;   ///< none: split, or outside and far
  // Error indicators of a leaf: its volume, weighted by the error over the allowed error. Equal without a cubic.
  double quadratic_indicator_m3 = 0;
  double cubic_indicator_m3 = 0;
  bool has_cubic = false;

  [[nodiscard]] double reach_m() const;  ///< from the centre to a corner
  [[nodiscard]] bool split() const { return first_child != 0; }
  /// Whether all of the cell is on this side of the surface.
  [[nodiscard]] bool inside() const { return distance_m <= -reach_m(); }
  [[nodiscard]] bool outside() const { return distance_m >= reach_m(); }
  /// The error indicator with the better polynomial.
  [[nodiscard]] double indicator_m3() const;
  /// Whether the leaf has no cubic polynomial yet but might take one.
  [[nodiscard]] bool lacks_cubic(double threshold_m3) const;
  [[nodiscard]] bool takes_cubic(double threshold_m3) const;
  [[nodiscard]] const PolynomialFit& chosen(double threshold_m3) const;
  [[nodiscard]] std::size_t chosen_terms(double threshold_m3) const {
    return takes_cubic(threshold_m3) ? cubic_terms : quadratic_terms;
  }
};

/// A point whose closest triangle is known.
struct KnownPoint {
  Vec3 point = Vec3::Zero();
  double distance_m = 0;  ///< negative inside
  int triangle = -1;      ///< the closest one
};

/// Sample points of a cell that are queried in one traversal of the BVH; fastest where successive ones are neighbours.
/// Each comes with a known point: a sample that is farther from the surface than from its known point is on the same
/// side. One thread at a time; reused for the next samples.
class SampleBlock {
 public:
  explicit SampleBlock(const SignedSurface& surface) : m_surface(surface), m_search(surface.tree()) {}

  /// All points lie in this cell, whose centre is known, until the next call.
  void begin(const OctreeCell& cell);
  void add(const Vec3& point, const KnownPoint& known, DistanceSample& answer);
  void query();

 private:
  /// Of the 125 samples that siblings share at least 9 are known: the centres of their parent and of its octants.
  static constexpr std::size_t most_batches = 15;

  struct Query {
    KnownPoint known;
    DistanceSample* answer = nullptr;
  };

  const SignedSurface& m_surface;
  BatchedClosestPoint m_search;
  std::size_t m_count = 0;  ///< of batches; all but the last one are full
  std::array<PointBatch, most_batches> m_batches;
  std::array<std::array<Query, PointBatch::capacity>, most_batches> m_queries;
};

/// Of the cells of the same size beyond the six faces of a cell, -x, +x, -y and so on, the first of the eight children;
/// none where there is no such cell or it is not split.
using NeighbourChildren = std::array<const OctreeCell*, 6>;

/// Prefetches what splitting a cell reads.
void fetch(const OctreeCell& parent, const NeighbourChildren& neighbours);

/// Makes cells: samples the surface, fits, computes error indicators. Const and safe from several threads, each with a
/// SampleBlock of its own.
class OctreeCellMaker {
 public:
  OctreeCellMaker(const SignedSurface& surface, const ErrorTarget& target) : m_surface(surface), m_target(target) {}

  [[nodiscard]] OctreeCell root(const Vec3& centre_m, double half_edge_m, SampleBlock& block) const;

  /// Makes the eight children of a leaf, x changing fastest. Samples of the leaf are taken over, and those of its
  /// neighbours' children that are still leaves. None lacks a cubic polynomial for this threshold.
  void split(OctreeCell& parent, const NeighbourChildren& neighbours, double threshold_m3,
             std::span<OctreeCell, 8> children, SampleBlock& block) const;

  void fit_cubic(OctreeCell& cell) const;

 private:
  [[nodiscard]] bool outside(const OctreeCell& cell) const;
  [[nodiscard]] bool is_large(const OctreeCell& cell) const;
  void fit(std::span<OctreeCell> cells, SampleBlock& block) const;
  /// From the samples of the cell that are known; returns the errors over the allowed errors.
  [[nodiscard]] CellErrors fit_quadratic(OctreeCell& cell) const;
  void divide_by_allowed(const CellSamples& samples, CellErrors& errors) const;
  [[nodiscard]] bool is_sure(const OctreeCell& cell, const CellErrors& quadratic) const;

  const SignedSurface& m_surface;
  ErrorTarget m_target;
  PolynomialFitter<quadratic_terms> m_quadratic;
  PolynomialFitter<cubic_terms> m_cubic;
};

}  // namespace musclebench

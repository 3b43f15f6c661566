#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "backends/sdf/build/octree_fit.hpp"
#include "core/bvh/batch/packet_search.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// What the leaves of an octree are judged by. Lengths in metres.
struct OctreeDemand {
  double wanted_m = 0;
  double near_m = 0;
  double finest_edge_m = 0;  ///< smaller cells are not made

  /// How far off a place at this exact distance may be.
  [[nodiscard]] double allowed_m(double distance_m) const;
};

/// A cell of an octree that is being built.
struct OctreeCell {
  /// What is known of a leaf that needs a polynomial.
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
  // Of a leaf: volume of the places that are off by more than allowed. Without a cubic polynomial both are the same.
  double wrong_quadratic_m3 = 0;
  double wrong_cubic_m3 = 0;
  bool has_cubic = false;

  [[nodiscard]] double reach_m() const;  ///< from the centre to a corner
  [[nodiscard]] bool split() const { return first_child != 0; }
  /// Whether all of the cell is on this side of the surface.
  [[nodiscard]] bool inside() const { return distance_m <= -reach_m(); }
  [[nodiscard]] bool outside() const { return distance_m >= reach_m(); }
  /// The volume of wrong places that is left with the better polynomial.
  [[nodiscard]] double wrong_m3() const;
  /// Whether a cubic polynomial, which the leaf has not got yet, might be taken.
  [[nodiscard]] bool lacks_cubic(double threshold_m3) const;
  [[nodiscard]] bool takes_cubic(double threshold_m3) const;
  [[nodiscard]] const PolynomialFit& chosen(double threshold_m3) const;
  [[nodiscard]] std::size_t chosen_terms(double threshold_m3) const {
    return takes_cubic(threshold_m3) ? cubic_terms : quadratic_terms;
  }
};

/// A place that is known.
struct KnownPlace {
  Vec3 point = Vec3::Zero();
  double distance_m = 0;  ///< negative inside
  int triangle = -1;      ///< the closest one
};

/// Places of a cell, for all of which the tree is walked through once; best where those that are added one after the
/// other are neighbours. Each is next to a known place, which tells its side where it is farther from the surface than
/// from that. One thread at a time; kept for the next places.
class SampleBlock {
 public:
  explicit SampleBlock(const SignedSurface& surface) : m_surface(surface), m_search(surface.tree()) {}

  /// All places lie in this cell, whose middle is known, until the next call.
  void enter(const OctreeCell& cell);
  void add(const Vec3& point, const KnownPlace& known, DistanceSample& answer);
  void ask();

 private:
  /// Of the 125 samples that sisters share 9 at least are known, the middles of their parent and of its octants.
  static constexpr std::size_t most_packets = 15;

  struct Asked {
    KnownPlace known;
    DistanceSample* answer = nullptr;
  };

  const SignedSurface& m_surface;
  PacketSearch m_search;
  std::size_t m_count = 0;  ///< of packets; all but the last one are full
  std::array<PointPacket, most_packets> m_packets;
  std::array<std::array<Asked, PointPacket::capacity>, most_packets> m_asked;
};

/// Of the cells of the same size beyond the six faces of a cell, -x, +x, -y and so on, the first of the eight children;
/// none where there is no such cell or it is not split.
using NeighbourChildren = std::array<const OctreeCell*, 6>;

/// What splitting a cell reads begins to come from memory.
void fetch(const OctreeCell& parent, const NeighbourChildren& neighbours);

/// Makes cells: asks the surface, fits, judges. Const and safe from several threads, each with a SampleBlock of its
/// own.
class OctreeCellMaker {
 public:
  OctreeCellMaker(const SignedSurface& surface, const OctreeDemand& demand) : m_surface(surface), m_demand(demand) {}

  [[nodiscard]] OctreeCell root(const Vec3& centre_m, double half_edge_m, SampleBlock& block) const;

  /// Makes the eight children of a leaf, x changing fastest. What the leaf was asked is not asked again, nor what
  /// children of its neighbours know, as far as they are still leaves. None lacks a cubic polynomial for this
  /// threshold.
  void split(OctreeCell& parent, const NeighbourChildren& neighbours, double threshold_m3,
             std::span<OctreeCell, 8> children, SampleBlock& block) const;

  void fit_cubic(OctreeCell& cell) const;

 private:
  [[nodiscard]] bool outside(const OctreeCell& cell) const;
  [[nodiscard]] bool is_large(const OctreeCell& cell) const;
  void fit(std::span<OctreeCell> cells, SampleBlock& block) const;
  /// By what is known of the cell; the errors over what is allowed.
  [[nodiscard]] CellErrors fit_quadratic(OctreeCell& cell) const;
  void divide_by_allowed(const CellSamples& samples, CellErrors& errors) const;
  [[nodiscard]] bool is_sure(const OctreeCell& cell, const CellErrors& quadratic) const;

  const SignedSurface& m_surface;
  OctreeDemand m_demand;
  PolynomialFitter<quadratic_terms> m_quadratic;
  PolynomialFitter<cubic_terms> m_cubic;
};

}  // namespace musclebench

#pragma once

#include <span>
#include <vector>

#include "core/base/grid_index.hpp"
#include "core/fibres/fibre_segments.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// Where fibres begin and end: triangles of a muscle's surface, by index.
struct FibreAreas {
  std::vector<int> origin;
  std::vector<int> insertion;
};

/// The triangles of the attachment areas, given bound nodes of each: those with all corners in the area, or with as
/// many as any has.
FibreAreas fibre_areas(const TriangleMesh& muscle, const std::vector<int>& origin_nodes,
                       const std::vector<int>& insertion_nodes);

/// The potential of a flow through the muscle, evenly in at the origin and evenly out at the insertion, through nothing
/// else of its surface: fascicles follow it (Choi and Blemker 2013, who solve the same Laplace equation). So every part
/// of an area has its fibres; with a fixed potential on the areas nearly all would crowd at the rims that look at each
/// other. Solved with trilinear finite elements on a regular grid; a cell that the surface cuts counts by the share of
/// it that is inside (the finite cell method, Parvizian, Duester and Rank 2007).
///
/// Measured fibres guide it: on them the flow is turned to their direction, and between them by as much, by inverse
/// squared distance (Shepard 1968), less the farther the nearest is (by 1 / e at a tenth of the muscle's diagonal), and
/// never by more than 60 degrees.
class VolumePotential {
 public:
  /// `cells`: inside the muscle, about. `surface` is that of `muscle` and need not outlive the potential.
  VolumePotential(const TriangleMesh& muscle, const SignedSurface& surface, const FibreAreas& areas,
                  const std::vector<FibreSegment>& guides, int cells = 60'000);

  struct Value {
    double potential = 0;      ///< mean 0 at the origin, mean 1 at the insertion
    Vec3 flow = Vec3::Zero();  ///< towards the insertion; zero where there is no potential
  };
  [[nodiscard]] Value at(const Vec3& point) const;

  [[nodiscard]] double cell_size_m() const { return m_cell_m; }

  /// Whether anything flows: not where no way leads through the muscle from one area to the other.
  [[nodiscard]] bool flows() const { return !m_flow.empty(); }

 private:
  void place_grid(const TriangleMesh& muscle, int cells);
  void find_inner_cells(const SignedSurface& surface);
  [[nodiscard]] std::vector<double> shares_of(const TriangleMesh& muscle, const std::vector<int>& triangles) const;
  [[nodiscard]] bool keep_what_joins(const std::vector<double>& inflow, const std::vector<double>& outflow);
  void find_turns(const std::vector<FibreSegment>& guides);
  void solve(const std::vector<double>& inflow, const std::vector<double>& outflow);
  void find_flow();

  /// What a measured fibre adds to the flow's unit direction.
  struct Turn {
    FibreSegment guide;
    double length_m = 0;
    Vec3 change = Vec3::Zero();
  };
  [[nodiscard]] Value unguided(const Vec3& point) const;
  [[nodiscard]] Vec3 turned(const Vec3& flow, const Vec3& point) const;
  [[nodiscard]] std::array<std::size_t, 8> nodes_of(std::size_t cell) const;
  [[nodiscard]] Vec3 centre_of(std::size_t cell) const;

  Vec3 m_corner = Vec3::Zero();
  double m_cell_m = 0;
  GridIndex m_cells;
  GridIndex m_nodes;
  std::vector<std::size_t> m_inner;  // cells, ascending
  std::vector<double> m_share;       // inside the muscle, of each of them
  std::vector<double> m_potential;   // by node; NaN: not of an inner cell
  std::vector<Vec3> m_flow;          // by node
  std::vector<Turn> m_turns;
  double m_reach_m = 0;  // of measured fibres
};

}  // namespace musclebench

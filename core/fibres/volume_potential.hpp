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

/// The function that is 0 on the origin, 1 on the insertion and harmonic in between, inside the muscle, whose
/// remaining surface nothing flows through: fascicles follow its gradient (Choi and Blemker 2013). Solved with
/// trilinear finite elements on a regular grid; a cell that the surface cuts counts by the share of it that is inside
/// (the finite cell method, Parvizian, Duester and Rank 2007). Exact to about a cell at the areas.
///
/// Measured fibres guide it: along them (their direction between them by inverse squared distance) a muscle conducts
/// better than across, so that the flow keeps to their direction.
class VolumePotential {
 public:
  /// `cells`: inside the muscle, about. `surface` is that of `muscle` and need not outlive the potential.
  VolumePotential(const TriangleMesh& muscle, const SignedSurface& surface, const FibreAreas& areas,
                  const std::vector<FibreSegment>& guides, int cells = 60'000);

  struct Value {
    double potential = 0;
    Vec3 flow = Vec3::Zero();  ///< towards the insertion; zero where there is no potential
  };
  [[nodiscard]] Value at(const Vec3& point) const;

  [[nodiscard]] double cell_size_m() const { return m_cell_m; }

  /// Points at which the potential is about a half, each of them standing for the same share of the flow; fewer or none
  /// where there is no flow.
  [[nodiscard]] std::vector<Vec3> seeds(int count) const;

 private:
  void place_grid(const TriangleMesh& muscle, int cells);
  void find_inner_cells(const SignedSurface& surface);
  void set_boundary_values(const SignedSurface& surface, const FibreAreas& areas);
  void find_conductivities(const std::vector<FibreSegment>& guides);
  void solve();
  void find_flow();

  [[nodiscard]] std::array<std::size_t, 8> nodes_of(std::size_t cell) const;
  [[nodiscard]] Vec3 centre_of(std::size_t cell) const;
  [[nodiscard]] Vec3 node_at(std::size_t node) const;

  Vec3 m_corner = Vec3::Zero();
  double m_cell_m = 0;
  GridIndex m_cells;
  GridIndex m_nodes;
  std::vector<std::size_t> m_inner;  // cells, ascending
  std::vector<double> m_share;       // inside the muscle, of each of them
  std::vector<Mat3> m_conductivity;  // of each of them; empty: 1
  std::vector<double> m_potential;   // by node; NaN: not of an inner cell
  std::vector<char> m_is_given;      // by node
  std::vector<Vec3> m_flow;          // by node
};

}  // namespace musclebench

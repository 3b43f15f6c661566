#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/constraints/constraint_lanes.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

struct VolumeSettings {
  double pressure = 1;          ///< target volume over rest volume
  double projection_scale = 1;  ///< part of the full projection that one pass does
};

/// The triangles of a closed surface may be divided into regions 0, 1, ... along the muscle. Between region r and r + 1
/// the surface is cut along the edges that separate the triangles of regions 0 to r from all others, and the cut is
/// closed by a fan of triangles about the mean of its nodes. The fan belongs to both regions, with opposite
/// orientation, so that the volumes of all regions add up to that of the body.
///
/// One constraint a region (a body without regions is one) on the volume inside its closed surface (Mueller et al.
/// 2007, section 4.4): C = V - pressure * V_rest, with V = 1/6 sum p0 . (p1 x p2). Positions are relative to a point of
/// the surface, so that no digits are lost far from the origin. All regions are corrected from the same positions; a
/// node that k regions share counts k times in the sum that divides a correction, so that the sum of corrections never
/// goes too far. A step that is linear in the displacement inflates by more than it is asked to (a ball that is to gain
/// n times its volume, (1 + n / 3)^3 - 1 times), so that no step asks for more than the volume there is and that of
/// rest. Sums are made in an order that depends on neither threads nor vectors.
class VolumeConstraints {
 public:
  /// `regions`: by triangle, its region in its body, from 0 on without a gap; empty: bodies are whole. An open body is
  /// always whole.
  VolumeConstraints(const TriangleMesh& mesh, std::span<const Body> bodies, const NodeOrder& order,
                    const VolumeSettings& settings, std::span<const int> regions = {});

  // Every thread of the team makes these calls, and waits for the others between them.
  void begin_substep(const Team& /*team*/) {}
  void project(NodeRows& rows, double time_step_s, const Team& team);

  static constexpr int most_regions = 64;  ///< of a body

  /// Consecutive triangles or entries of one region whose sums are made by one thread.
  struct Chunk {
    std::size_t first;
    std::size_t last;
    std::size_t region;
  };
  /// Indices of chunks: those of one region are consecutive.
  struct ChunkRange {
    std::size_t first = 0;
    std::size_t last = 0;
  };
  struct ClosedTriangle {
    Triangle rows;
    int region = 0;
    bool is_cone = false;  ///< of a boundary edge and the origin, which is the first corner
  };
  /// A partial sum a lane.
  using LaneSums = std::array<double, constraint_lanes>;

 private:
  struct Region {
    std::size_t body;
    double rest_m3 = 0;
    double target_m3 = 0;
    int lower_cut = -1;  ///< to the region before; -1: none
    int upper_cut = -1;
    std::size_t first_entry = 0;
    ChunkRange triangle_chunks = {};
    ChunkRange entry_chunks = {};
  };
  struct BodyRegions {
    std::size_t first_row;
    std::size_t last_row;
    std::size_t origin_row;  ///< that of its first node; where a surface is open, its volume depends on the origin
    std::size_t first_region;
    std::size_t last_region;
  };
  /// The fan that closes the regions below a cut.
  struct Cut {
    std::size_t body;
    std::vector<std::array<int, 2>> edges;  ///< of the fan's triangles, with the mean as third corner: in `rows`
    std::vector<int> rows;                  ///< ascending
    std::vector<Vec3> gradients = {};       ///< by `rows`: six times that of the volume below
    double six_volume = 0;
  };
  /// What a cut adds to the gradient of an entry.
  struct CutTerm {
    std::size_t entry;
    std::size_t cut;
    std::size_t index;  ///< in the cut's rows
    double sign;
  };

  void add_body(const TriangleMesh& mesh, const Body& body, const NodeOrder& order, std::span<const int> regions);
  void add_cuts(const TriangleMesh& mesh, const Body& body, const NodeOrder& order, std::span<const int> regions,
                int count);
  void add_region(std::span<const ClosedTriangle> triangles, std::size_t region, int padding);
  void add_entries(const Chunk& chunk, std::size_t first_entry, std::span<const std::vector<std::int32_t>> about);
  void list_entries_of_rows(std::size_t rows);
  void find_area_vectors_of(std::size_t chunk, NodeRows& rows);
  void find_cut(Cut& cut, const NodeRows& rows) const;
  void find_gradients_of(std::size_t chunk, const NodeRows& rows);
  void move_rows(const BodyRegions& body, std::size_t first, std::size_t last, NodeRows& rows) const;
  [[nodiscard]] double volume_of(const Region& region) const;
  [[nodiscard]] double multiplier_of(const Region& region) const;

  std::vector<BodyRegions> m_bodies;
  std::vector<Region> m_regions;  ///< body by body
  std::vector<Cut> m_cuts;
  std::vector<Chunk> m_triangle_chunks;
  std::vector<Chunk> m_entry_chunks;
  std::array<std::vector<std::int32_t>, 3> m_corners;  ///< by triangle: `row_offset`
  std::vector<NodeRow> m_area_vectors;                 ///< by triangle
  std::vector<LaneSums> m_six_volumes;                 ///< by chunk of triangles
  // An entry is a row in a region: region by region, by row. Where all bodies are whole its index is the row.
  std::vector<int> m_row_of_entry;
  std::vector<double> m_shares;               ///< by entry: of how many regions the row is
  std::vector<std::int32_t> m_entries;        ///< in the order in which their gradients are found
  std::vector<std::size_t> m_first_triangle;  ///< of `m_entries`, in `m_triangles_of_entries`
  std::vector<std::int32_t> m_triangles_of_entries;
  std::vector<CutTerm> m_cut_terms;               ///< by entry
  std::vector<std::size_t> m_first_entry_of_row;  ///< in `m_entries_of_rows`
  std::vector<std::size_t> m_entries_of_rows;
  std::vector<int> m_region_of_entry;  ///< in its body
  std::vector<NodeRow> m_gradients;    ///< by entry
  std::vector<LaneSums> m_weighted;    ///< by chunk of entries: inverse mass times squared gradient
  double m_projection_scale;
};

}  // namespace musclebench

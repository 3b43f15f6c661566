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

/// One constraint a body on the volume inside its closed surface (Mueller et al. 2007, section 4.4): C = V - pressure *
/// V_rest, with V = 1/6 sum p0 . (p1 x p2). Positions are relative to a point of the surface, so that no digits are
/// lost far from the origin. Sums are made in an order that depends on neither threads nor vectors.
class VolumeConstraints {
 public:
  VolumeConstraints(const TriangleMesh& mesh, std::span<const Body> bodies, const NodeOrder& order,
                    const VolumeSettings& settings);

  // Every thread of the team makes these calls, and waits for the others between them.
  void begin_substep(const Team& /*team*/) {}
  void project(NodeRows& rows, double time_step_s, const Team& team);

  /// Consecutive triangles or rows of one body whose sums are made by one thread.
  struct Chunk {
    std::size_t first;
    std::size_t last;
    std::size_t body;
  };
  /// Indices of chunks: those of one body are consecutive.
  struct ChunkRange {
    std::size_t first = 0;
    std::size_t last = 0;
  };
  struct ClosedTriangle {
    Triangle rows;
    bool is_cone = false;  ///< of a boundary edge and the origin, which is the first corner
  };
  /// A partial sum a lane.
  using LaneSums = std::array<double, constraint_lanes>;

 private:
  struct BodyVolume {
    std::size_t first_row;
    std::size_t last_row;
    std::size_t origin_row;  ///< that of its first node; where a surface is open, its volume depends on the origin
    double target_m3;
    ChunkRange triangle_chunks;
    ChunkRange row_chunks;
  };

  /// The next body's, filled up to whole blocks.
  void add_triangles(std::span<const ClosedTriangle> triangles, std::size_t body, int padding);
  void add_rows(const Chunk& chunk, std::size_t first_row, std::span<const std::vector<std::int32_t>> about);
  void find_area_vectors_of(std::size_t chunk, NodeRows& rows);
  void find_gradients_of(std::size_t chunk, const NodeRows& rows);

  std::vector<BodyVolume> m_bodies;
  std::vector<Chunk> m_triangle_chunks;
  std::vector<Chunk> m_row_chunks;
  std::array<std::vector<std::int32_t>, 3> m_corners;  ///< by triangle: `row_offset`
  std::vector<NodeRow> m_area_vectors;                 ///< by triangle
  std::vector<LaneSums> m_six_volumes;                 ///< by chunk of triangles
  std::vector<std::int32_t> m_rows;                    ///< in the order in which their gradients are found
  std::vector<std::size_t> m_first_triangle;           ///< of `m_rows`, in `m_triangles_of_rows`
  std::vector<std::int32_t> m_triangles_of_rows;
  std::vector<NodeRow> m_gradients;  ///< by row
  std::vector<LaneSums> m_weighted;  ///< by chunk of rows: inverse mass times squared gradient
  double m_projection_scale;
};

}  // namespace musclebench

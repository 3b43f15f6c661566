#include "core/constraints/volume_constraints.hpp"

#include <algorithm>
#include <numeric>

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/surface_volume.hpp"

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/constraints/volume_constraints.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "core/constraints/node_lanes-inl.hpp"

#ifndef MUSCLEBENCH_VOLUME_CONSTRAINTS_ONCE
#define MUSCLEBENCH_VOLUME_CONSTRAINTS_ONCE
namespace musclebench {

/// Triangles, a lane each, whole blocks: `row_offset` of their corners.
struct TriangleLanes {
  const std::int32_t* a;
  const std::int32_t* b;
  const std::int32_t* c;
};

/// The triangles about `rows[i]`, from `first_triangle[i]` on in `triangles`.
struct RowTriangles {
  const std::int32_t* rows;
  const std::size_t* first_triangle;
  const std::int32_t* triangles;
};

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

/// Of the triangles from `first` to `last`: twice their area vectors as rows of a fourth number 0. Adds six times the
/// volumes of their cones from `origin` to `six_volumes`.
void find_area_vectors(const TriangleLanes& triangles, std::size_t first, std::size_t last, const Vec3& origin,
                       const NodeRow* rows, NodeRow* area_vectors, VolumeConstraints::LaneSums& six_volumes) {
  const Lanes d;
  constexpr std::array<std::int32_t, 8> in_order{row_offset(0), row_offset(1), row_offset(2), row_offset(3),
                                                 row_offset(4), row_offset(5), row_offset(6), row_offset(7)};
  const VecLanes from{hn::Set(d, origin.x()), hn::Set(d, origin.y()), hn::Set(d, origin.z())};
  for (std::size_t i = first; i < last; i += lane_count) {
    const VecLanes a = load_nodes(rows, triangles.a + i).at;
    const VecLanes b = load_nodes(rows, triangles.b + i).at;
    const VecLanes c = load_nodes(rows, triangles.c + i).at;
    const VecLanes normal = cross(b - a, c - a);
    const Lane volume = dot(a - from, normal);
    store_nodes({normal, hn::Zero(d)}, area_vectors + i, in_order.data());
    double* sums = six_volumes.data() + i % constraint_lanes;
    hn::StoreU(hn::Add(hn::LoadU(d, sums), volume), d, sums);
  }
}

/// Six times dV/dp of `of.rows` from `first` to `last`: twice the area vectors of the triangles about them.
void find_gradients(const RowTriangles& of, std::size_t first, std::size_t last, const NodeRow* area_vectors,
                    NodeRow* gradients) {
  for (std::size_t i = first; i < last; ++i) {
    RowVector sum = load_row(NodeRow());
    for (std::size_t t = of.first_triangle[i]; t < of.first_triangle[i + 1]; ++t) {
      sum = sum + load_row(area_vectors[of.triangles[t]]);
    }
    store_row(sum, gradients[of.rows[i]]);
  }
}

void move_along_gradients(const NodeRow* gradients, std::size_t first, std::size_t last, double multiplier,
                          NodeRow* rows) {
  for (std::size_t row = first; row < last; ++row) {
    const RowVector step = multiplier * rows[row].inverse_mass * load_row(gradients[row]);
    store_row(load_row(rows[row]) - step, rows[row]);
  }
}

}  // namespace musclebench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace musclebench {

HWY_EXPORT(find_area_vectors);
HWY_EXPORT(find_gradients);
HWY_EXPORT(move_along_gradients);

namespace {

using Chunk = VolumeConstraints::Chunk;
using ChunkRange = VolumeConstraints::ChunkRange;
using ClosedTriangle = VolumeConstraints::ClosedTriangle;
using LaneSums = VolumeConstraints::LaneSums;

constexpr std::size_t chunk_size = 64;

/// `first` to `last` in chunks; the last one may be smaller.
ChunkRange add_chunks(std::size_t first, std::size_t last, std::size_t body, std::vector<Chunk>& chunks) {
  const std::size_t before = chunks.size();
  for (; first < last; first += chunk_size) {
    chunks.push_back({first, std::min(first + chunk_size, last), body});
  }
  return {before, chunks.size()};
}

double total(std::span<const LaneSums> chunks, const ChunkRange& range) {
  LaneSums sums{};
  for (const LaneSums& chunk : chunks.subspan(range.first, range.last - range.first)) {
    for (std::size_t lane = 0; lane < constraint_lanes; ++lane) {
      sums[lane] += chunk[lane];
    }
  }
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// The triangles of the body and, along its boundary edges, cones to the origin of its volume: then all area vectors
/// about a row add up to its gradient.
std::vector<ClosedTriangle> closed_triangles(const TriangleMesh& mesh, const Body& body, const NodeOrder& order) {
  const auto row = [&](int node) { return order.row_of(node); };
  TriangleMesh surface;
  surface.vertices = mesh.vertices;
  surface.triangles.assign(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(body.first_triangle),
                           mesh.triangles.begin() + static_cast<std::ptrdiff_t>(body.last_triangle));
  std::vector<ClosedTriangle> triangles;
  for (const auto& [a, b, c] : surface.triangles) {
    triangles.push_back({{row(a), row(b), row(c)}});
  }
  const int origin = row(body.first_node);
  const MeshEdges edges(surface);
  for (int edge = 0; edge < edges.count(); ++edge) {
    int balance = 0;
    for (const EdgeUse& use : edges.uses(edge)) {
      balance += use.forward ? 1 : -1;
    }
    const auto [low, high, corner, forward] = edges.uses(edge).front();
    for (; balance > 0; --balance) triangles.push_back({{origin, row(high), row(low)}, true});
    for (; balance < 0; ++balance) triangles.push_back({{origin, row(low), row(high)}, true});
  }
  // So that a thread has the triangles about its rows.
  std::ranges::stable_sort(triangles, {}, [](const ClosedTriangle& t) { return std::ranges::min(t.rows); });
  return triangles;
}

}  // namespace

VolumeConstraints::VolumeConstraints(const TriangleMesh& mesh, std::span<const Body> bodies, const NodeOrder& order,
                                     const VolumeSettings& settings)
    : m_projection_scale(settings.projection_scale) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    m_bodies.push_back({static_cast<std::size_t>(body.first_node),
                        static_cast<std::size_t>(body.last_node),
                        static_cast<std::size_t>(order.row_of(body.first_node)),
                        settings.pressure * body_volume_m3(mesh.vertices, mesh.triangles, body),
                        {},
                        {}});
    add_triangles(closed_triangles(mesh, body, order), b, static_cast<int>(order.size()));
  }
  m_area_vectors.resize(m_corners[0].size());
  m_six_volumes.resize(m_triangle_chunks.size());
  m_gradients.resize(order.size());
  m_weighted.resize(m_row_chunks.size());
  m_first_triangle.push_back(m_triangles_of_rows.size());
}

void VolumeConstraints::project(NodeRows& rows, double /*time_step_s*/, const Team& team) {
  const Team::Share chunks = team.share(m_triangle_chunks.size());
  for (std::size_t chunk = chunks.first; chunk < chunks.last; ++chunk) {
    find_area_vectors_of(chunk, rows);
  }
  team.wait();
  const Team::Share row_chunks = team.share(m_row_chunks.size());
  for (std::size_t chunk = row_chunks.first; chunk < row_chunks.last; ++chunk) {
    find_gradients_of(chunk, rows);
  }
  team.wait();
  const Team::Share moved = team.share(m_gradients.size());
  for (const BodyVolume& body : m_bodies) {
    const std::size_t first = std::max(moved.first, body.first_row);
    const std::size_t last = std::min(moved.last, body.last_row);
    if (first >= last) continue;
    const double weighted = total(m_weighted, body.row_chunks) / 36;
    if (!(weighted > 0)) continue;
    const double volume_m3 = total(m_six_volumes, body.triangle_chunks) / 6;
    const double multiplier = m_projection_scale * (volume_m3 - body.target_m3) / weighted / 6;
    HWY_DYNAMIC_DISPATCH(move_along_gradients)(m_gradients.data(), first, last, multiplier, rows.data());
  }
}

/// The next body's, filled up to whole blocks.
void VolumeConstraints::add_triangles(std::span<const ClosedTriangle> triangles, std::size_t body, int padding) {
  const std::size_t first = m_corners[0].size();
  BodyVolume& rows = m_bodies[body];
  std::vector<std::vector<std::int32_t>> about(rows.last_row - rows.first_row);
  for (const ClosedTriangle& triangle : triangles) {
    const auto index = static_cast<std::int32_t>(m_corners[0].size());
    for (std::size_t corner = 0; corner < 3; ++corner) {
      m_corners[corner].push_back(row_offset(triangle.rows[corner]));
      const bool is_origin = triangle.is_cone && corner == 0;
      if (!is_origin) about[static_cast<std::size_t>(triangle.rows[corner]) - rows.first_row].push_back(index);
    }
  }
  while (m_corners[0].size() % constraint_lanes != 0) {
    for (auto& corners : m_corners) {
      corners.push_back(row_offset(padding));
    }
  }
  rows.triangle_chunks = add_chunks(first, m_corners[0].size(), body, m_triangle_chunks);
  rows.row_chunks = add_chunks(rows.first_row, rows.last_row, body, m_row_chunks);
  for (std::size_t chunk = rows.row_chunks.first; chunk < rows.row_chunks.last; ++chunk) {
    add_rows(m_row_chunks[chunk], rows.first_row, about);
  }
}

void VolumeConstraints::add_rows(const Chunk& chunk, std::size_t first_row,
                                 std::span<const std::vector<std::int32_t>> about) {
  std::vector<std::int32_t> rows(chunk.last - chunk.first);
  std::iota(rows.begin(), rows.end(), static_cast<std::int32_t>(chunk.first));
  const auto triangles_about = [&](std::int32_t row) -> const std::vector<std::int32_t>& {
    return about[static_cast<std::size_t>(row) - first_row];
  };
  // By the number of triangles: a loop of a steady length is predicted.
  std::ranges::stable_sort(rows, {}, [&](std::int32_t row) { return triangles_about(row).size(); });
  for (const std::int32_t row : rows) {
    m_rows.push_back(row);
    m_first_triangle.push_back(m_triangles_of_rows.size());
    m_triangles_of_rows.insert(m_triangles_of_rows.end(), triangles_about(row).begin(), triangles_about(row).end());
  }
}

void VolumeConstraints::find_area_vectors_of(std::size_t chunk, NodeRows& rows) {
  const auto& [first, last, body] = m_triangle_chunks[chunk];
  m_six_volumes[chunk] = {};
  HWY_DYNAMIC_DISPATCH(find_area_vectors)
  ({m_corners[0].data(), m_corners[1].data(), m_corners[2].data()}, first, last,
   rows[m_bodies[body].origin_row].position(), rows.data(), m_area_vectors.data(), m_six_volumes[chunk]);
}

void VolumeConstraints::find_gradients_of(std::size_t chunk, const NodeRows& rows) {
  const auto& [first, last, body] = m_row_chunks[chunk];
  HWY_DYNAMIC_DISPATCH(find_gradients)
  ({m_rows.data(), m_first_triangle.data(), m_triangles_of_rows.data()}, first, last, m_area_vectors.data(),
   m_gradients.data());
  LaneSums weighted{};
  for (std::size_t row = first; row < last; ++row) {
    weighted[(row - first) % constraint_lanes] += rows[row].inverse_mass * m_gradients[row].position().squaredNorm();
  }
  m_weighted[chunk] = weighted;
}

}  // namespace musclebench
#endif  // HWY_ONCE

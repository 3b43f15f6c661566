#include "core/constraints/volume_constraints.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

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

/// The triangles about `entries[i]`, from `first_triangle[i]` on in `triangles`.
struct EntryTriangles {
  const std::int32_t* entries;
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

/// Six times dV/dp of `of.entries` from `first` to `last`: twice the area vectors of the triangles about them.
void find_gradients(const EntryTriangles& of, std::size_t first, std::size_t last, const NodeRow* area_vectors,
                    NodeRow* gradients) {
  for (std::size_t i = first; i < last; ++i) {
    RowVector sum = load_row(NodeRow());
    for (std::size_t t = of.first_triangle[i]; t < of.first_triangle[i + 1]; ++t) {
      sum = sum + load_row(area_vectors[of.triangles[t]]);
    }
    store_row(sum, gradients[of.entries[i]]);
  }
}

void move_along_gradients(const NodeRow* gradients, std::size_t count, double multiplier, NodeRow* rows,
                          NodeRow* impulses) {
  for (std::size_t row = 0; impulses != nullptr && row < count; ++row) {
    store_row(load_row(impulses[row]) - multiplier * load_row(gradients[row]), impulses[row]);
  }
  for (std::size_t row = 0; row < count; ++row) {
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
ChunkRange add_chunks(std::size_t first, std::size_t last, std::size_t region, std::vector<Chunk>& chunks) {
  const std::size_t before = chunks.size();
  for (; first < last; first += chunk_size) {
    chunks.push_back({first, std::min(first + chunk_size, last), region});
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

TriangleMesh surface_of(const TriangleMesh& mesh, const Body& body) {
  return {mesh.vertices,
          {mesh.triangles.begin() + static_cast<std::ptrdiff_t>(body.first_triangle),
           mesh.triangles.begin() + static_cast<std::ptrdiff_t>(body.last_triangle)}};
}

/// The triangles of the body and, along its boundary edges, cones to the origin of its volume: then all area vectors
/// about a row add up to its gradient.
std::vector<ClosedTriangle> closed_triangles(const TriangleMesh& mesh, const Body& body, const NodeOrder& order,
                                             std::span<const int> regions) {
  const auto row = [&](int node) { return order.row_of(node); };
  const TriangleMesh surface = surface_of(mesh, body);
  std::vector<ClosedTriangle> triangles;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    triangles.push_back({{row(a), row(b), row(c)}, regions.empty() ? 0 : regions[body.first_triangle + t]});
  }
  const int origin = row(body.first_node);
  const MeshEdges edges(surface);
  for (int edge = 0; edge < edges.count(); ++edge) {
    int balance = 0;
    for (const EdgeUse& use : edges.uses(edge)) {
      balance += use.forward ? 1 : -1;
    }
    const auto [low, high, corner, forward] = edges.uses(edge).front();
    for (; balance > 0; --balance) triangles.push_back({{origin, row(high), row(low)}, 0, true});
    for (; balance < 0; ++balance) triangles.push_back({{origin, row(low), row(high)}, 0, true});
  }
  // So that a thread has the triangles about its rows.
  std::ranges::stable_sort(triangles, {}, [](const ClosedTriangle& t) { return std::ranges::min(t.rows); });
  if (std::ranges::any_of(triangles, &ClosedTriangle::is_cone)) {
    for (ClosedTriangle& triangle : triangles) triangle.region = 0;
  }
  return triangles;
}

}  // namespace

VolumeConstraints::VolumeConstraints(const TriangleMesh& mesh, std::span<const Body> bodies, const NodeOrder& order,
                                     const VolumeSettings& settings, std::span<const int> regions)
    : m_projection_scale(settings.projection_scale) {
  for (const Body& body : bodies) add_body(mesh, body, order, regions);
  m_area_vectors.resize(m_corners[0].size());
  m_six_volumes.resize(m_triangle_chunks.size());
  m_gradients.resize(m_row_of_entry.size());
  m_weighted.resize(m_entry_chunks.size());
  m_first_triangle.push_back(m_triangles_of_entries.size());
  list_entries_of_rows(order.size());
  // At rest, in whole bodies by the same sum as reports use.
  NodeRows rest(order, mesh.vertices, std::vector<double>(order.size(), 0));
  for (std::size_t chunk = 0; chunk < m_triangle_chunks.size(); ++chunk) find_area_vectors_of(chunk, rest);
  for (Cut& cut : m_cuts) find_cut(cut, rest);
  for (Region& region : m_regions) {
    const BodyRegions& body = m_bodies[region.body];
    const bool is_whole = body.last_region - body.first_region == 1;
    region.rest_m3 = is_whole ? body_volume_m3(mesh.vertices, mesh.triangles, bodies[region.body]) : volume_of(region);
    region.target_m3 = settings.pressure * region.rest_m3;
  }
}

void VolumeConstraints::project(NodeRows& rows, double /*time_step_s*/, const Team& team) {
  const Team::Share chunks = team.share(m_triangle_chunks.size());
  for (std::size_t chunk = chunks.first; chunk < chunks.last; ++chunk) {
    find_area_vectors_of(chunk, rows);
  }
  const Team::Share cuts = team.share(m_cuts.size());
  for (std::size_t cut = cuts.first; cut < cuts.last; ++cut) {
    find_cut(m_cuts[cut], rows);
  }
  team.wait();
  const Team::Share entry_chunks = team.share(m_entry_chunks.size());
  for (std::size_t chunk = entry_chunks.first; chunk < entry_chunks.last; ++chunk) {
    find_gradients_of(chunk, rows);
  }
  team.wait();
  const Team::Share moved = team.share(rows.size());
  for (const BodyRegions& body : m_bodies) {
    const std::size_t first = std::max(moved.first, body.first_row);
    const std::size_t last = std::min(moved.last, body.last_row);
    if (first < last) move_rows(body, first, last, rows);
  }
}

void VolumeConstraints::move_rows(const BodyRegions& body, std::size_t first, std::size_t last, NodeRows& rows) const {
  if (body.last_region - body.first_region == 1) {
    const Region& whole = m_regions[body.first_region];
    const double multiplier = multiplier_of(whole);
    if (multiplier == 0) return;
    // A whole body has all of its rows.
    const std::size_t first_entry = whole.first_entry + (first - body.first_row);
    HWY_DYNAMIC_DISPATCH(move_along_gradients)
    (m_gradients.data() + first_entry, last - first, multiplier, rows.data() + first,
     rows.impulses() != nullptr ? rows.impulses() + first : nullptr);
    return;
  }
  std::array<double, most_regions> multipliers{};
  for (std::size_t region = body.first_region; region < body.last_region; ++region) {
    multipliers[region - body.first_region] = multiplier_of(m_regions[region]);
  }
  for (std::size_t row = first; row < last; ++row) {
    NodeRow step;
    for (std::size_t i = m_first_entry_of_row[row]; i < m_first_entry_of_row[row + 1]; ++i) {
      const std::size_t entry = m_entries_of_rows[i];
      step = step + multipliers[static_cast<std::size_t>(m_region_of_entry[entry])] * m_gradients[entry];
    }
    rows[row].set_position(rows[row].position() - rows[row].inverse_mass * step.position());
    if (NodeRow* impulses = rows.impulses()) impulses[row] = impulses[row] - step;
  }
}

double VolumeConstraints::volume_of(const Region& region) const {
  const auto six_volume = [&](int cut) { return cut < 0 ? 0.0 : m_cuts[static_cast<std::size_t>(cut)].six_volume; };
  return (total(m_six_volumes, region.triangle_chunks) + six_volume(region.upper_cut) - six_volume(region.lower_cut)) /
         6;
}

/// Of gradients that are six times too long; 0 where nothing can move.
double VolumeConstraints::multiplier_of(const Region& region) const {
  const double weighted = total(m_weighted, region.entry_chunks) / 36;
  if (!(weighted > 0)) return 0;
  const double volume_m3 = volume_of(region);
  const double most_gain_m3 = std::abs(volume_m3) + region.rest_m3;
  return m_projection_scale * std::max(volume_m3 - region.target_m3, -most_gain_m3) / weighted / 6;
}

void VolumeConstraints::add_body(const TriangleMesh& mesh, const Body& body, const NodeOrder& order,
                                 std::span<const int> regions) {
  const std::vector<ClosedTriangle> triangles = closed_triangles(mesh, body, order, regions);
  const auto first_row = static_cast<std::size_t>(body.first_node);
  const std::size_t index = m_bodies.size();
  m_bodies.push_back({first_row, static_cast<std::size_t>(body.last_node),
                      static_cast<std::size_t>(order.row_of(body.first_node)), m_regions.size(), 0});
  int count = 1;
  for (const ClosedTriangle& triangle : triangles) count = std::max(count, triangle.region + 1);
  const int first_cut = static_cast<int>(m_cuts.size());
  for (int region = 0; region < count; ++region) {
    m_regions.push_back({.body = index,
                         .lower_cut = region > 0 ? first_cut + region - 1 : -1,
                         .upper_cut = region + 1 < count ? first_cut + region : -1});
  }
  m_bodies.back().last_region = m_regions.size();
  add_cuts(mesh, body, order, regions, count);
  for (int region = 0; region < count; ++region) {
    std::vector<ClosedTriangle> own;
    std::ranges::copy_if(triangles, std::back_inserter(own), [&](const auto& t) { return t.region == region; });
    add_region(own, m_bodies.back().first_region + static_cast<std::size_t>(region), static_cast<int>(order.size()));
  }
}

void VolumeConstraints::add_cuts(const TriangleMesh& mesh, const Body& body, const NodeOrder& order,
                                 std::span<const int> regions, int count) {
  if (count == 1) return;
  std::vector<std::vector<std::array<int, 2>>> edges_of_cuts(static_cast<std::size_t>(count - 1));
  const MeshEdges edges(surface_of(mesh, body));
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    for (std::size_t cut = 0; cut < edges_of_cuts.size(); ++cut) {
      int balance = 0;
      for (const EdgeUse& use : uses) {
        const std::size_t triangle = body.first_triangle + static_cast<std::size_t>(use.corner / 3);
        if (regions[triangle] <= static_cast<int>(cut)) balance += use.forward ? 1 : -1;
      }
      const int low = order.row_of(uses.front().low);
      const int high = order.row_of(uses.front().high);
      for (; balance > 0; --balance) edges_of_cuts[cut].push_back({high, low});
      for (; balance < 0; ++balance) edges_of_cuts[cut].push_back({low, high});
    }
  }
  for (std::vector<std::array<int, 2>>& of_cut : edges_of_cuts) {
    Cut& cut = m_cuts.emplace_back(Cut{m_bodies.size() - 1, std::move(of_cut), {}});
    for (const auto& edge : cut.edges) cut.rows.insert(cut.rows.end(), edge.begin(), edge.end());
    std::ranges::sort(cut.rows);
    cut.rows.erase(std::unique(cut.rows.begin(), cut.rows.end()), cut.rows.end());
    for (auto& edge : cut.edges) {
      for (int& end : edge) end = static_cast<int>(std::ranges::lower_bound(cut.rows, end) - cut.rows.begin());
    }
    cut.gradients.resize(cut.rows.size());
  }
}

/// The triangles of the next region, filled up to whole blocks, and its entries.
void VolumeConstraints::add_region(std::span<const ClosedTriangle> triangles, std::size_t region, int padding) {
  Region& added = m_regions[region];
  const BodyRegions& body = m_bodies[added.body];
  std::vector<int> rows;
  if (body.last_region - body.first_region == 1) {
    rows.resize(body.last_row - body.first_row);
    std::iota(rows.begin(), rows.end(), static_cast<int>(body.first_row));
  } else {
    for (const ClosedTriangle& triangle : triangles)
      rows.insert(rows.end(), triangle.rows.begin(), triangle.rows.end());
    for (const int cut : {added.lower_cut, added.upper_cut}) {
      if (cut < 0) continue;
      const std::vector<int>& on_cut = m_cuts[static_cast<std::size_t>(cut)].rows;
      rows.insert(rows.end(), on_cut.begin(), on_cut.end());
    }
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  }
  const auto index_of = [&](int row) {
    return static_cast<std::size_t>(std::ranges::lower_bound(rows, row) - rows.begin());
  };
  added.first_entry = m_row_of_entry.size();
  m_row_of_entry.insert(m_row_of_entry.end(), rows.begin(), rows.end());
  m_region_of_entry.insert(m_region_of_entry.end(), rows.size(), static_cast<int>(region - body.first_region));
  for (const auto& [cut, sign] : {std::pair(added.lower_cut, -1.0), std::pair(added.upper_cut, 1.0)}) {
    if (cut < 0) continue;
    const std::vector<int>& on_cut = m_cuts[static_cast<std::size_t>(cut)].rows;
    for (std::size_t i = 0; i < on_cut.size(); ++i) {
      m_cut_terms.push_back({added.first_entry + index_of(on_cut[i]), static_cast<std::size_t>(cut), i, sign});
    }
  }

  const std::size_t first = m_corners[0].size();
  std::vector<std::vector<std::int32_t>> about(rows.size());
  for (const ClosedTriangle& triangle : triangles) {
    const auto index = static_cast<std::int32_t>(m_corners[0].size());
    for (std::size_t corner = 0; corner < 3; ++corner) {
      m_corners[corner].push_back(row_offset(triangle.rows[corner]));
      const bool is_origin = triangle.is_cone && corner == 0;
      if (!is_origin) about[index_of(triangle.rows[corner])].push_back(index);
    }
  }
  while (m_corners[0].size() % constraint_lanes != 0) {
    for (auto& corners : m_corners) {
      corners.push_back(row_offset(padding));
    }
  }
  added.triangle_chunks = add_chunks(first, m_corners[0].size(), region, m_triangle_chunks);
  added.entry_chunks = add_chunks(added.first_entry, m_row_of_entry.size(), region, m_entry_chunks);
  for (std::size_t chunk = added.entry_chunks.first; chunk < added.entry_chunks.last; ++chunk) {
    add_entries(m_entry_chunks[chunk], added.first_entry, about);
  }
}

void VolumeConstraints::add_entries(const Chunk& chunk, std::size_t first_entry,
                                    std::span<const std::vector<std::int32_t>> about) {
  std::vector<std::int32_t> entries(chunk.last - chunk.first);
  std::iota(entries.begin(), entries.end(), static_cast<std::int32_t>(chunk.first));
  const auto triangles_about = [&](std::int32_t entry) -> const std::vector<std::int32_t>& {
    return about[static_cast<std::size_t>(entry) - first_entry];
  };
  // By the number of triangles: a loop of a steady length is predicted.
  std::ranges::stable_sort(entries, {}, [&](std::int32_t entry) { return triangles_about(entry).size(); });
  for (const std::int32_t entry : entries) {
    m_entries.push_back(entry);
    m_first_triangle.push_back(m_triangles_of_entries.size());
    m_triangles_of_entries.insert(m_triangles_of_entries.end(), triangles_about(entry).begin(),
                                  triangles_about(entry).end());
  }
}

void VolumeConstraints::list_entries_of_rows(std::size_t rows) {
  m_first_entry_of_row.assign(rows + 1, 0);
  for (const int row : m_row_of_entry) ++m_first_entry_of_row[static_cast<std::size_t>(row) + 1];
  std::partial_sum(m_first_entry_of_row.begin(), m_first_entry_of_row.end(), m_first_entry_of_row.begin());
  std::vector<std::size_t> next(m_first_entry_of_row.begin(), m_first_entry_of_row.end() - 1);
  m_entries_of_rows.resize(m_row_of_entry.size());
  for (std::size_t entry = 0; entry < m_row_of_entry.size(); ++entry) {
    const auto row = static_cast<std::size_t>(m_row_of_entry[entry]);
    m_entries_of_rows[next[row]++] = entry;
    m_shares.push_back(static_cast<double>(m_first_entry_of_row[row + 1] - m_first_entry_of_row[row]));
  }
  std::ranges::stable_sort(m_cut_terms, {}, &CutTerm::entry);
}

void VolumeConstraints::find_area_vectors_of(std::size_t chunk, NodeRows& rows) {
  const auto& [first, last, region] = m_triangle_chunks[chunk];
  m_six_volumes[chunk] = {};
  HWY_DYNAMIC_DISPATCH(find_area_vectors)
  ({m_corners[0].data(), m_corners[1].data(), m_corners[2].data()}, first, last,
   rows[m_bodies[m_regions[region].body].origin_row].position(), rows.data(), m_area_vectors.data(),
   m_six_volumes[chunk]);
}

void VolumeConstraints::find_cut(Cut& cut, const NodeRows& rows) const {
  const auto at = [&](int index) {
    return rows[static_cast<std::size_t>(cut.rows[static_cast<std::size_t>(index)])].position();
  };
  const Vec3 origin = rows[m_bodies[cut.body].origin_row].position();
  Vec3 middle = Vec3::Zero();  // relative to the origin
  for (const int row : cut.rows) middle += rows[static_cast<std::size_t>(row)].position() - origin;
  middle /= static_cast<double>(std::max<std::size_t>(cut.rows.size(), 1));
  std::ranges::fill(cut.gradients, Vec3(Vec3::Zero()));
  cut.six_volume = 0;
  Vec3 of_middle = Vec3::Zero();
  for (const auto& [first, second] : cut.edges) {
    const Vec3 a = at(first) - origin;
    const Vec3 b = at(second) - origin;
    const Vec3 normal = (b - a).cross(middle - a);
    cut.six_volume += a.dot(normal);
    cut.gradients[static_cast<std::size_t>(first)] += normal;
    cut.gradients[static_cast<std::size_t>(second)] += normal;
    of_middle += normal;
  }
  of_middle /= static_cast<double>(std::max<std::size_t>(cut.rows.size(), 1));
  for (Vec3& gradient : cut.gradients) gradient += of_middle;
}

void VolumeConstraints::find_gradients_of(std::size_t chunk, const NodeRows& rows) {
  const auto& [first, last, region] = m_entry_chunks[chunk];
  HWY_DYNAMIC_DISPATCH(find_gradients)
  ({m_entries.data(), m_first_triangle.data(), m_triangles_of_entries.data()}, first, last, m_area_vectors.data(),
   m_gradients.data());
  for (auto term = std::ranges::lower_bound(m_cut_terms, first, {}, &CutTerm::entry);
       term != m_cut_terms.end() && term->entry < last; ++term) {
    NodeRow& gradient = m_gradients[term->entry];
    gradient.set_position(gradient.position() + term->sign * m_cuts[term->cut].gradients[term->index]);
  }
  LaneSums weighted{};
  for (std::size_t entry = first; entry < last; ++entry) {
    weighted[(entry - first) % constraint_lanes] += m_shares[entry] *
                                                    rows[static_cast<std::size_t>(m_row_of_entry[entry])].inverse_mass *
                                                    m_gradients[entry].position().squaredNorm();
  }
  m_weighted[chunk] = weighted;
}

}  // namespace musclebench
#endif  // HWY_ONCE

#include "core/effects/volume.hpp"

#include <algorithm>
#include <numeric>

#include "core/effects/constraint_lanes.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/surface_volume.hpp"

// Highway compiles this file once for every SIMD target; highway.h has to be included after foreach_target.h.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/effects/volume.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#include "core/effects/node_lanes-inl.hpp"

#ifndef MUSCLEBENCH_VOLUME_ONCE
#define MUSCLEBENCH_VOLUME_ONCE
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

/// A sum of many numbers whose order depends on neither threads nor vectors: a partial sum a lane.
using LaneSums = std::array<double, constraint_lanes>;

}  // namespace musclebench
#endif

HWY_BEFORE_NAMESPACE();
namespace musclebench::HWY_NAMESPACE {

/// Of the triangles from `first` to `last`: twice their area vectors as rows of a fourth number 0. Adds six times the
/// volumes of their cones from `origin` to `six_volumes`.
void find_area_vectors(const TriangleLanes& triangles, std::size_t first, std::size_t last, const Vec3& origin,
                       const NodeRow* rows, NodeRow* area_vectors, LaneSums& six_volumes) {
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

/// Triangles or rows whose sums are made by one thread. A multiple of the lanes.
constexpr std::size_t chunk_size = 64;

std::size_t chunks_of(std::size_t count) { return (count + chunk_size - 1) / chunk_size; }

double total(std::span<const LaneSums> chunks) {
  LaneSums sums{};
  for (const LaneSums& chunk : chunks) {
    for (std::size_t lane = 0; lane < constraint_lanes; ++lane) {
      sums[lane] += chunk[lane];
    }
  }
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// As rows: the triangles of the mesh and, where its boundary edges are, cones from the padding row, which `project`
/// puts at the origin of the volume: then all area vectors about a row add up to its gradient.
std::vector<Triangle> closed_triangles(const TriangleMesh& mesh, const NodeOrder& order) {
  std::vector<Triangle> triangles;
  for (const auto& [a, b, c] : mesh.triangles) {
    triangles.push_back({order.row_of(a), order.row_of(b), order.row_of(c)});
  }
  const int origin = static_cast<int>(order.size());
  const MeshEdges edges(mesh);
  for (int edge = 0; edge < edges.count(); ++edge) {
    int balance = 0;
    for (const EdgeUse& use : edges.uses(edge)) {
      balance += use.forward ? 1 : -1;
    }
    const auto [low, high, corner, forward] = edges.uses(edge).front();
    for (; balance > 0; --balance) triangles.push_back({origin, order.row_of(high), order.row_of(low)});
    for (; balance < 0; ++balance) triangles.push_back({origin, order.row_of(low), order.row_of(high)});
  }
  // So that a thread has the triangles about its rows.
  std::ranges::stable_sort(triangles, {}, [](const Triangle& triangle) { return std::ranges::min(triangle); });
  return triangles;
}

class Volume final : public Effect {
 public:
  Volume(const TriangleMesh& mesh, const NodeOrder& order, double target_m3, double projection_scale)
      : m_origin_row(static_cast<std::size_t>(order.row_of(0))),
        m_target_m3(target_m3),
        m_projection_scale(projection_scale) {
    const std::vector<Triangle> triangles = closed_triangles(mesh, order);
    const int padding = static_cast<int>(order.size());
    const std::size_t padded = (triangles.size() + constraint_lanes - 1) / constraint_lanes * constraint_lanes;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      m_corners[corner].assign(padded, row_offset(padding));
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        m_corners[corner][t] = row_offset(triangles[t][corner]);
      }
    }
    m_area_vectors.resize(padded);
    m_six_volumes.resize(chunks_of(padded));
    find_triangles_of_rows(triangles, order.size());
    m_gradients.resize(order.size());
    m_weighted.resize(chunks_of(order.size()));
  }

  [[nodiscard]] std::string_view name() const override { return "volume"; }

  void project(NodeRows& rows, const SubstepInput& /*input*/, const Team& team) override {
    const Vec3 origin = rows[m_origin_row].position();
    if (team.is_first()) rows.padding().set_position(origin);
    team.wait();
    const Team::Share chunks = team.share(m_six_volumes.size());
    for (std::size_t chunk = chunks.first; chunk < chunks.last; ++chunk) {
      find_area_vectors_of(chunk, origin, rows);
    }
    team.wait();
    const Team::Share row_chunks = team.share(m_weighted.size());
    for (std::size_t chunk = row_chunks.first; chunk < row_chunks.last; ++chunk) {
      find_gradients_of(chunk, rows);
    }
    team.wait();
    const double weighted = total(m_weighted) / 36;
    if (!(weighted > 0)) return;
    const double multiplier = m_projection_scale * (total(m_six_volumes) / 6 - m_target_m3) / weighted / 6;
    const Team::Share moved = team.share(m_gradients.size());
    HWY_DYNAMIC_DISPATCH(move_along_gradients)
    (m_gradients.data(), moved.first, moved.last, multiplier, rows.data());
  }

 private:
  void find_triangles_of_rows(std::span<const Triangle> triangles, std::size_t row_count) {
    std::vector<std::vector<std::int32_t>> about(row_count + 1);  // the last: the padding row
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (const int row : triangles[t]) {
        about[static_cast<std::size_t>(row)].push_back(static_cast<std::int32_t>(t));
      }
    }
    m_rows.resize(row_count);
    std::iota(m_rows.begin(), m_rows.end(), 0);
    // Rows of a chunk by the number of triangles: a loop of a steady length is predicted.
    for (std::size_t first = 0; first < row_count; first += chunk_size) {
      const auto chunk = std::span(m_rows).subspan(first, std::min(chunk_size, row_count - first));
      std::ranges::stable_sort(chunk, {},
                               [&](std::int32_t row) { return about[static_cast<std::size_t>(row)].size(); });
    }
    for (const std::int32_t row : m_rows) {
      m_first_triangle.push_back(m_triangles_of_rows.size());
      const std::vector<std::int32_t>& of_row = about[static_cast<std::size_t>(row)];
      m_triangles_of_rows.insert(m_triangles_of_rows.end(), of_row.begin(), of_row.end());
    }
    m_first_triangle.push_back(m_triangles_of_rows.size());
  }

  void find_area_vectors_of(std::size_t chunk, const Vec3& origin, NodeRows& rows) {
    m_six_volumes[chunk] = {};
    const std::size_t last = std::min((chunk + 1) * chunk_size, m_area_vectors.size());
    HWY_DYNAMIC_DISPATCH(find_area_vectors)
    ({m_corners[0].data(), m_corners[1].data(), m_corners[2].data()}, chunk * chunk_size, last, origin, rows.data(),
     m_area_vectors.data(), m_six_volumes[chunk]);
  }

  void find_gradients_of(std::size_t chunk, const NodeRows& rows) {
    const std::size_t first = chunk * chunk_size;
    const std::size_t last = std::min(first + chunk_size, m_gradients.size());
    HWY_DYNAMIC_DISPATCH(find_gradients)
    ({m_rows.data(), m_first_triangle.data(), m_triangles_of_rows.data()}, first, last, m_area_vectors.data(),
     m_gradients.data());
    LaneSums weighted{};
    for (std::size_t i = first; i < last; ++i) {
      weighted[i % constraint_lanes] += rows[i].inverse_mass * m_gradients[i].position().squaredNorm();
    }
    m_weighted[chunk] = weighted;
  }

  std::array<std::vector<std::int32_t>, 3> m_corners;  ///< by triangle: `row_offset`
  std::vector<NodeRow> m_area_vectors;                 ///< by triangle
  std::vector<LaneSums> m_six_volumes;                 ///< by chunk of triangles
  std::vector<std::int32_t> m_rows;                    ///< in the order in which their gradients are found
  std::vector<std::size_t> m_first_triangle;           ///< of `m_rows`, in `m_triangles_of_rows`
  std::vector<std::int32_t> m_triangles_of_rows;
  std::vector<NodeRow> m_gradients;  ///< by row
  std::vector<LaneSums> m_weighted;  ///< by chunk of rows: inverse mass times squared gradient
  std::size_t m_origin_row;          ///< that of node 0; where a surface is open, its volume depends on the origin
  double m_target_m3;
  double m_projection_scale;
};

}  // namespace

std::unique_ptr<Effect> make_volume(const EffectInput& input, const Parameters& parameters) {
  const double volume_m3 = surface_volume_m3(input.muscle.vertices, input.muscle.triangles);
  return std::make_unique<Volume>(input.muscle, input.order, parameters.number("pressure") * volume_m3,
                                  parameters.number("projection_scale"));
}

std::vector<ParameterSpec> volume_parameters() {
  return {parameter::number({.name = "pressure",
                             .default_value = 1,
                             .minimum = 0.01,
                             .maximum = 100,
                             .help = "target volume over rest volume (useful: 0.5 to 2)"}),
          parameter::number({.name = "projection_scale",
                             .default_value = 1,
                             .minimum = 0,
                             .maximum = 1,
                             .help = "part of the full projection that one pass does (the paper's public code: 1/6)"})};
}

}  // namespace musclebench
#endif  // HWY_ONCE

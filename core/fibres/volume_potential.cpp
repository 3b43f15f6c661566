#include "core/fibres/volume_potential.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include "core/mesh/mesh_size.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {

namespace {

/// Of a cell inside the muscle: with less it is left out, because its nodes would hang on next to nothing.
constexpr double least_share = 0.1;
/// Of the largest angle by which measured fibres turn the flow.
constexpr double least_cosine = 0.5;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

using CellMatrix = Eigen::Matrix<double, 8, 8>;

/// Corner `n` of a cell lies at (n & 1, n >> 1 & 1, n >> 2).
double coordinate(std::size_t corner, int axis) { return static_cast<double>(corner >> axis & 1U); }

/// Of a unit cell: the integrals of products of the gradients of its corners' trilinear functions.
CellMatrix cell_matrix() {
  CellMatrix matrix = CellMatrix::Zero();
  for (std::size_t a = 0; a < 8; ++a) {
    for (std::size_t b = 0; b < 8; ++b) {
      for (int slope_axis = 0; slope_axis < 3; ++slope_axis) {
        double product = 1;
        for (int axis = 0; axis < 3; ++axis) {
          const bool same = coordinate(a, axis) == coordinate(b, axis);
          product *= axis == slope_axis ? (same ? 1.0 : -1.0) : (same ? 1.0 / 3 : 1.0 / 6);
        }
        matrix(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) += product;
      }
    }
  }
  return matrix;
}

/// Of the trilinear function with these values at the corners, at `local` in the unit cell.
Vec3 gradient(const std::array<double, 8>& values, const Vec3& local) {
  Vec3 result = Vec3::Zero();
  for (std::size_t corner = 0; corner < 8; ++corner) {
    Vec3 parts;
    for (int axis = 0; axis < 3; ++axis) {
      parts[axis] = coordinate(corner, axis) > 0 ? local[axis] : 1 - local[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
      const double slope = coordinate(corner, axis) > 0 ? 1 : -1;
      result[axis] += values[corner] * slope * parts[(axis + 1) % 3] * parts[(axis + 2) % 3];
    }
  }
  return result;
}

std::vector<int> triangles_of(const TriangleMesh& muscle, const std::vector<int>& nodes) {
  std::vector<char> is_in_area(muscle.vertices.size(), 0);
  for (const int node : nodes) is_in_area[static_cast<std::size_t>(node)] = 1;
  std::vector<int> triangles;
  int most = 1;
  for (std::size_t t = 0; t < muscle.triangles.size(); ++t) {
    int corners = 0;
    for (const int node : muscle.triangles[t]) corners += is_in_area[static_cast<std::size_t>(node)];
    if (corners > most) triangles.clear();
    most = std::max(most, corners);
    if (corners == most) triangles.push_back(static_cast<int>(t));
  }
  return triangles;
}

}  // namespace

FibreAreas fibre_areas(const TriangleMesh& muscle, const std::vector<int>& origin_nodes,
                       const std::vector<int>& insertion_nodes) {
  return {triangles_of(muscle, origin_nodes), triangles_of(muscle, insertion_nodes)};
}

VolumePotential::VolumePotential(const TriangleMesh& muscle, const SignedSurface& surface, const FibreAreas& areas,
                                 const std::vector<FibreSegment>& guides, int cells) {
  place_grid(muscle, cells);
  find_inner_cells(surface);
  const std::vector<double> inflow = shares_of(muscle, areas.origin);
  const std::vector<double> outflow = shares_of(muscle, areas.insertion);
  if (!keep_what_joins(inflow, outflow)) return;
  solve(inflow, outflow);
  find_flow();
  find_turns(guides);
}

void VolumePotential::place_grid(const TriangleMesh& muscle, int cells) {
  const Eigen::AlignedBox3d box = bounding_box(muscle.vertices);
  constexpr double reach = 0.1;
  m_reach_m = reach * box.diagonal().norm();
  const double volume_m3 = std::abs(surface_volume_m3(muscle.vertices, muscle.triangles, muscle.vertices.front()));
  // A thin sheet across its box has few cells inside, for many that are not.
  constexpr double most_cells = 1e7;
  const double box_volume_m3 = box.sizes().prod();
  m_cell_m = std::cbrt(std::max(volume_m3 / cells, box_volume_m3 / most_cells));
  if (!(m_cell_m > 0)) m_cell_m = box.diagonal().norm() / cells;
  m_corner = box.min() - Vec3::Constant(0.5 * m_cell_m);
  for (int axis = 0; axis < 3; ++axis) {
    m_cells.count[axis] = static_cast<std::size_t>(box.sizes()[axis] / m_cell_m) + 2;
    m_nodes.count[axis] = m_cells.count[axis] + 1;
  }
}

Vec3 VolumePotential::centre_of(std::size_t cell) const {
  const auto [i, j, k] = m_cells.coordinates(cell);
  return m_corner +
         m_cell_m * Vec3(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5, static_cast<double>(k) + 0.5);
}

std::array<std::size_t, 8> VolumePotential::nodes_of(std::size_t cell) const {
  const auto [i, j, k] = m_cells.coordinates(cell);
  std::array<std::size_t, 8> nodes{};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    nodes[corner] = m_nodes.index(i + (corner & 1U), j + (corner >> 1U & 1U), k + (corner >> 2U));
  }
  return nodes;
}

void VolumePotential::find_inner_cells(const SignedSurface& surface) {
  int nearby = 0;
  for (std::size_t cell = 0; cell < m_cells.size();) {
    const SignedPoint located = surface.locate_from(centre_of(cell), nearby);
    nearby = located.closest.triangle;
    // The surface is that far away, so that the next cells of the row are on the same side.
    const double distance = located.signed_distance_m() / m_cell_m;
    const std::size_t left_of_row = m_cells.count[0] - cell % m_cells.count[0];
    const auto alike =
        static_cast<std::size_t>(std::clamp(std::abs(distance) - 1, 1.0, static_cast<double>(left_of_row)));
    const double share = std::clamp(0.5 - distance, 0.0, 1.0);
    for (std::size_t i = 0; i < alike && share >= least_share; ++i) {
      m_inner.push_back(cell + i);
      m_share.push_back(share);
    }
    cell += alike;
  }
}

/// By node: the share of these triangles' area that lies at it. Nothing where no inner cell is near.
std::vector<double> VolumePotential::shares_of(const TriangleMesh& muscle, const std::vector<int>& triangles) const {
  std::vector<char> is_inner(m_cells.size(), 0);
  for (const std::size_t cell : m_inner) is_inner[cell] = 1;
  std::vector<double> shares(m_nodes.size(), 0.0);
  double total = 0;
  const auto add = [&](const Vec3& point, double area_m2) {
    const Vec3 scaled = (point - m_corner) / m_cell_m;
    if (!(scaled.minCoeff() >= 0)) return;
    GridIndex::Coordinates at{};
    for (int axis = 0; axis < 3; ++axis) at[axis] = static_cast<std::size_t>(scaled[axis]);
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] >= m_cells.count[axis]) return;
    }
    const std::size_t cell = m_cells.index(at);
    if (is_inner[cell] == 0) return;
    total += area_m2;
    const auto nodes = nodes_of(cell);
    for (std::size_t corner = 0; corner < 8; ++corner) {
      double weight = area_m2;
      for (int axis = 0; axis < 3; ++axis) {
        const double local = scaled[axis] - static_cast<double>(at[axis]);
        weight *= coordinate(corner, axis) > 0 ? local : 1 - local;
      }
      shares[nodes[corner]] += weight;
    }
  };
  for (const int t : triangles) {
    const auto& [a, b, c] = muscle.triangles[static_cast<std::size_t>(t)];
    const Vec3 corner = muscle.vertices[static_cast<std::size_t>(a)];
    const Vec3 to_b = muscle.vertices[static_cast<std::size_t>(b)] - corner;
    const Vec3 to_c = muscle.vertices[static_cast<std::size_t>(c)] - corner;
    const Vec3 normal = to_b.cross(to_c);
    const double area_m2 = 0.5 * normal.norm();
    if (!(area_m2 > 0)) continue;
    // Half a cell inside, where cells are inner ones, from points nearer to each other than a cell.
    const Vec3 inwards = -0.5 * m_cell_m / (2 * area_m2) * normal;
    const double longest = std::max({to_b.norm(), to_c.norm(), (to_c - to_b).norm()});
    const int parts = static_cast<int>(std::ceil(2 * longest / m_cell_m)) + 1;
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; j < 2 * (parts - i) - 1; ++j) {
        // Middles of the small triangles: of a row every second one stands on its head.
        const double row = j % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
        const double along_b = (i + row) / parts;
        const double along_c = (j / 2 + (j % 2 == 0 ? 1.0 / 3 : 2.0 / 3)) / parts;
        add(corner + along_b * to_b + along_c * to_c + inwards, area_m2 / parts / parts);
      }
    }
  }
  for (double& share : shares) share = total > 0 ? share / total : 0;
  return shares;
}

/// Of several pieces that cells make, only one that both areas touch carries a flow: the one with the largest inflow.
bool VolumePotential::keep_what_joins(const std::vector<double>& inflow, const std::vector<double>& outflow) {
  std::vector<std::size_t> leader(m_nodes.size());
  std::iota(leader.begin(), leader.end(), std::size_t{0});
  const auto find = [&](std::size_t node) {
    while (leader[node] != node) node = leader[node] = leader[leader[node]];
    return node;
  };
  for (const std::size_t cell : m_inner) {
    const auto nodes = nodes_of(cell);
    for (const std::size_t node : nodes) leader[find(node)] = find(nodes[0]);
  }
  std::map<std::size_t, std::pair<double, double>> through;  // by leader: in and out
  for (std::size_t node = 0; node < inflow.size(); ++node) {
    if (inflow[node] > 0) through[find(node)].first += inflow[node];
    if (outflow[node] > 0) through[find(node)].second += outflow[node];
  }
  std::optional<std::size_t> best;
  for (const auto& [piece, flows] : through) {
    const bool joins = flows.first > 0 && flows.second > 0;
    if (joins && (!best || flows.first > through[*best].first)) best = piece;
  }
  if (!best) return false;
  std::vector<std::size_t> kept;
  std::vector<double> shares;
  for (std::size_t i = 0; i < m_inner.size(); ++i) {
    if (find(nodes_of(m_inner[i])[0]) != *best) continue;
    kept.push_back(m_inner[i]);
    shares.push_back(m_share[i]);
  }
  m_inner = std::move(kept);
  m_share = std::move(shares);
  return true;
}

void VolumePotential::find_turns(const std::vector<FibreSegment>& guides) {
  for (const FibreSegment& guide : guides) {
    const Vec3 along = guide.end - guide.start;
    const Vec3 flow = unguided(0.5 * (guide.start + guide.end)).flow;
    if (!(along.squaredNorm() > 0) || !(flow.squaredNorm() > 0)) continue;  // a part that lies outside
    const Vec3 direction = along.normalized() * (along.dot(flow) < 0 ? -1 : 1);
    m_turns.push_back({guide, along.norm(), direction - flow.normalized()});
  }
}

Vec3 VolumePotential::turned(const Vec3& flow, const Vec3& point) const {
  const double speed = flow.norm();
  if (m_turns.empty() || !(speed > 0)) return flow;
  Vec3 change = Vec3::Zero();
  double total = 0;
  double nearest2 = std::numeric_limits<double>::infinity();
  for (const Turn& turn : m_turns) {
    const double distance2 = squared_distance(turn.guide, point);
    const double weight = turn.length_m / (distance2 + 0.01 * m_cell_m * m_cell_m);
    change += weight * turn.change;
    total += weight;
    nearest2 = std::min(nearest2, distance2);
  }
  change *= std::exp(-nearest2 / (m_reach_m * m_reach_m)) / total;
  const Vec3 plain = flow / speed;
  for (double share = 1; share > 0.1; share /= 2) {
    const Vec3 direction = (plain + share * change).normalized();
    if (direction.dot(plain) >= least_cosine) return speed * direction;
  }
  return flow;
}

void VolumePotential::solve(const std::vector<double>& inflow, const std::vector<double>& outflow) {
  m_potential.assign(m_nodes.size(), unknown);
  for (const std::size_t cell : m_inner) {
    for (const std::size_t node : nodes_of(cell)) m_potential[node] = 0;
  }
  std::vector<int> equation(m_nodes.size(), -1);
  std::vector<std::size_t> free;
  bool is_first = true;  // the flow tells the potential but for a constant: one node keeps 0
  double total_in = 0;
  double total_out = 0;
  for (std::size_t node = 0; node < m_nodes.size(); ++node) {
    if (std::isnan(m_potential[node])) continue;
    total_in += inflow[node];
    total_out += outflow[node];
    if (std::exchange(is_first, false)) continue;
    equation[node] = static_cast<int>(free.size());
    free.push_back(node);
  }
  const CellMatrix matrix_of_cell = cell_matrix();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(64 * m_inner.size());
  Eigen::VectorXd right = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size()));
  for (std::size_t i = 0; i < free.size(); ++i) {
    right[static_cast<Eigen::Index>(i)] = outflow[free[i]] / total_out - inflow[free[i]] / total_in;
  }
  for (std::size_t i = 0; i < m_inner.size(); ++i) {
    const auto nodes = nodes_of(m_inner[i]);
    for (std::size_t a = 0; a < 8; ++a) {
      const int row = equation[nodes[a]];
      if (row < 0) continue;
      for (std::size_t b = 0; b < 8; ++b) {
        const double entry = m_share[i] * matrix_of_cell(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
        const int column = equation[nodes[b]];
        if (column >= 0) entries.emplace_back(row, column, entry);
      }
    }
  }
  const auto size = static_cast<Eigen::Index>(free.size());
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(1e-8);
  solver.compute(matrix);
  const Eigen::VectorXd solution = solver.solve(right);
  for (std::size_t i = 0; i < free.size(); ++i) m_potential[free[i]] = solution[static_cast<Eigen::Index>(i)];
  double at_origin = 0;
  double at_insertion = 0;
  for (std::size_t node = 0; node < m_nodes.size(); ++node) {
    if (std::isnan(m_potential[node])) continue;
    at_origin += inflow[node] / total_in * m_potential[node];
    at_insertion += outflow[node] / total_out * m_potential[node];
  }
  for (double& potential : m_potential) potential = (potential - at_origin) / (at_insertion - at_origin);
}

void VolumePotential::find_flow() {
  m_flow.assign(m_nodes.size(), Vec3::Zero());
  std::vector<double> total(m_nodes.size(), 0.0);
  for (std::size_t i = 0; i < m_inner.size(); ++i) {
    const auto nodes = nodes_of(m_inner[i]);
    std::array<double, 8> values{};
    for (std::size_t corner = 0; corner < 8; ++corner) values[corner] = m_potential[nodes[corner]];
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const Vec3 local(coordinate(corner, 0), coordinate(corner, 1), coordinate(corner, 2));
      m_flow[nodes[corner]] += m_share[i] / m_cell_m * gradient(values, local);
      total[nodes[corner]] += m_share[i];
    }
  }
  for (std::size_t node = 0; node < m_flow.size(); ++node) {
    if (total[node] > 0) m_flow[node] /= total[node];
  }
}

VolumePotential::Value VolumePotential::at(const Vec3& point) const {
  Value value = unguided(point);
  value.flow = turned(value.flow, point);
  return value;
}

VolumePotential::Value VolumePotential::unguided(const Vec3& point) const {
  if (!flows()) return {};
  const Vec3 scaled = (point - m_corner) / m_cell_m;
  GridIndex::Coordinates cell{};
  Vec3 local;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(scaled[axis] >= 0 && scaled[axis] < static_cast<double>(m_cells.count[axis]))) return {};
    cell[axis] = static_cast<std::size_t>(scaled[axis]);
    local[axis] = scaled[axis] - static_cast<double>(cell[axis]);
  }
  const auto nodes = nodes_of(m_cells.index(cell));
  Value value;
  double total = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    if (std::isnan(m_potential[nodes[corner]])) continue;
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= coordinate(corner, axis) > 0 ? local[axis] : 1 - local[axis];
    value.potential += weight * m_potential[nodes[corner]];
    value.flow += weight * m_flow[nodes[corner]];
    total += weight;
  }
  if (!(total > 0)) return {};
  return {value.potential / total, value.flow / total};
}

}  // namespace musclebench

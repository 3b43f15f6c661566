#include "core/fibres/volume_potential.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include "core/mesh/mesh_size.hpp"
#include "core/mesh/morton_order.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {

namespace {

/// Of a cell inside the muscle: with less it is left out, because its nodes would hang on next to nothing.
constexpr double least_share = 0.1;
/// Along a measured fibre, over that across it. The flow then leaves a fibre's direction by a tenth of the angle (of
/// its tangent) at which the gradient does.
constexpr double conduction_along = 10;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

using CellMatrix = Eigen::Matrix<double, 8, 8>;

/// Corner `n` of a cell lies at (n & 1, n >> 1 & 1, n >> 2).
double coordinate(std::size_t corner, int axis) { return static_cast<double>(corner >> axis & 1U); }

/// Of the trilinear functions of a unit cell's corners: integrals of a derivative of one times a derivative of another.
std::array<std::array<CellMatrix, 3>, 3> derivative_products() {
  // In one dimension, for functions of the same end and of different ones.
  const auto values = [](bool same) { return same ? 1.0 / 3 : 1.0 / 6; };
  const auto slopes = [](bool same) { return same ? 1.0 : -1.0; };
  const auto slope_of = [](double end) { return end > 0 ? 1.0 : -1.0; };
  std::array<std::array<CellMatrix, 3>, 3> products;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b < 8; ++b) {
          double product = 1;
          for (int axis = 0; axis < 3; ++axis) {
            const bool same = coordinate(a, axis) == coordinate(b, axis);
            if (axis == i && axis == j) {
              product *= slopes(same);
            } else if (axis == i) {
              product *= 0.5 * slope_of(coordinate(a, axis));
            } else if (axis == j) {
              product *= 0.5 * slope_of(coordinate(b, axis));
            } else {
              product *= values(same);
            }
          }
          products[i][j](static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = product;
        }
      }
    }
  }
  return products;
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
  set_boundary_values(surface, areas);
  find_conductivities(guides);
  solve();
  find_flow();
}

void VolumePotential::place_grid(const TriangleMesh& muscle, int cells) {
  const Eigen::AlignedBox3d box = bounding_box(muscle.vertices);
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

Vec3 VolumePotential::node_at(std::size_t node) const {
  const auto [i, j, k] = m_nodes.coordinates(node);
  return m_corner + m_cell_m * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
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

void VolumePotential::set_boundary_values(const SignedSurface& surface, const FibreAreas& areas) {
  std::vector<double> value_of_triangle(surface.tree().triangle_count(), unknown);
  for (const int triangle : areas.origin) value_of_triangle[static_cast<std::size_t>(triangle)] = 0;
  for (const int triangle : areas.insertion) value_of_triangle[static_cast<std::size_t>(triangle)] = 1;
  m_potential.assign(m_nodes.size(), unknown);
  m_is_given.assign(m_nodes.size(), 0);
  std::vector<char> is_seen(m_nodes.size(), 0);
  int nearby = 0;
  for (std::size_t i = 0; i < m_inner.size(); ++i) {
    for (const std::size_t node : nodes_of(m_inner[i])) {
      if (m_share[i] == 1 && is_seen[node] == 0) m_potential[node] = 0;
      if (m_share[i] == 1 || is_seen[node] != 0) continue;
      is_seen[node] = 1;
      nearby = surface.tree().closest_point_from(node_at(node), nearby).triangle;
      const double value = value_of_triangle[static_cast<std::size_t>(nearby)];
      m_is_given[node] = std::isnan(value) ? 0 : 1;
      m_potential[node] = std::isnan(value) ? 0 : value;
    }
  }
}

void VolumePotential::find_conductivities(const std::vector<FibreSegment>& guides) {
  if (guides.empty()) return;
  for (const std::size_t cell : m_inner) {
    const Vec3 centre = centre_of(cell);
    Mat3 directions = Mat3::Zero();
    double total = 0;
    for (const FibreSegment& guide : guides) {
      const Vec3 along = guide.end - guide.start;
      const double length = along.norm();
      if (!(length > 0)) continue;
      const double distance = std::sqrt(squared_distance(guide, centre)) + 0.5 * m_cell_m;
      const double weight = length / (distance * distance);
      directions += weight / (length * length) * along * along.transpose();
      total += weight;
    }
    m_conductivity.push_back(Mat3::Identity() + (total > 0 ? (conduction_along - 1) / total : 0.0) * directions);
  }
}

void VolumePotential::solve() {
  std::vector<int> equation(m_nodes.size(), -1);
  std::vector<std::size_t> free;
  for (std::size_t node = 0; node < m_nodes.size(); ++node) {
    if (std::isnan(m_potential[node]) || m_is_given[node] != 0) continue;
    equation[node] = static_cast<int>(free.size());
    free.push_back(node);
  }
  if (free.empty()) return;
  const auto products = derivative_products();
  const CellMatrix plain = products[0][0] + products[1][1] + products[2][2];
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(64 * m_inner.size());
  Eigen::VectorXd right = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size()));
  for (std::size_t i = 0; i < m_inner.size(); ++i) {
    CellMatrix matrix = plain;
    if (!m_conductivity.empty()) {
      matrix.setZero();
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) matrix += m_conductivity[i](a, b) * products[a][b];
      }
    }
    const auto nodes = nodes_of(m_inner[i]);
    for (std::size_t a = 0; a < 8; ++a) {
      const int row = equation[nodes[a]];
      if (row < 0) continue;
      for (std::size_t b = 0; b < 8; ++b) {
        const double entry = m_share[i] * matrix(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
        const int column = equation[nodes[b]];
        if (column >= 0) {
          entries.emplace_back(row, column, entry);
        } else {
          right[row] -= entry * m_potential[nodes[b]];
        }
      }
    }
  }
  const auto size = static_cast<Eigen::Index>(free.size());
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(1e-8);
  solver.compute(matrix);
  // Parts that touch neither area keep the 0 that they begin with.
  const Eigen::VectorXd solution = solver.solve(right);
  for (std::size_t i = 0; i < free.size(); ++i) m_potential[free[i]] = solution[static_cast<Eigen::Index>(i)];
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
      const Vec3 slope = gradient(values, local) / m_cell_m;
      m_flow[nodes[corner]] += m_share[i] * (m_conductivity.empty() ? slope : Vec3(m_conductivity[i] * slope));
      total[nodes[corner]] += m_share[i];
    }
  }
  for (std::size_t node = 0; node < m_flow.size(); ++node) {
    if (total[node] > 0) m_flow[node] /= total[node];
  }
}

VolumePotential::Value VolumePotential::at(const Vec3& point) const {
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

std::vector<Vec3> VolumePotential::seeds(int count) const {
  // The layer of cells that the middle level runs through: as thick, along the gradient, as largest over length of
  // their slope, in cells. So each has that much less of the level's area, and of the flow through it.
  std::vector<Vec3> centres;
  std::vector<double> flows;
  for (std::size_t i = 0; i < m_inner.size(); ++i) {
    const auto nodes = nodes_of(m_inner[i]);
    std::array<double, 8> values{};
    double middle = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      values[corner] = m_potential[nodes[corner]];
      middle += values[corner] / 8;
    }
    const Vec3 slope = gradient(values, Vec3::Constant(0.5));
    const double largest = slope.cwiseAbs().maxCoeff();
    if (!(largest > 0 && std::abs(middle - 0.5) <= 0.5 * largest)) continue;
    const Vec3 flow = m_conductivity.empty() ? slope : Vec3(m_conductivity[i] * slope);
    centres.push_back(centre_of(m_inner[i]));
    flows.push_back(m_share[i] * flow.dot(slope) / largest);
  }
  const double total = std::accumulate(flows.begin(), flows.end(), 0.0);
  if (!(total > 0)) return {};
  const std::vector<int> order = morton_order(centres);
  std::vector<Vec3> seeds;
  double passed = 0;
  for (const int cell : order) {
    const double before = passed;
    passed += flows[static_cast<std::size_t>(cell)];
    // Where several fall into a cell, they are spread along its diagonal.
    while (seeds.size() < static_cast<std::size_t>(count)) {
      const double wanted = total * (static_cast<double>(seeds.size()) + 0.5) / count;
      if (!(wanted <= passed)) break;
      const double within = (wanted - before) / (passed - before) - 0.5;
      seeds.push_back(centres[static_cast<std::size_t>(cell)] + Vec3::Constant(0.5 * m_cell_m * within));
    }
  }
  return seeds;
}

}  // namespace musclebench

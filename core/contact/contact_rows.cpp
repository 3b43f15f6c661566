#include "core/contact/contact_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace musclebench {

ContactRowSolver::ContactRowSolver(std::vector<double> inverse_masses)
    : m_inverse_masses(std::move(inverse_masses)),
      m_loads(m_inverse_masses.size(), 0),
      m_corrections(m_inverse_masses.size(), Vec3::Zero()),
      m_start_corrections(m_inverse_masses.size(), Vec3::Zero()) {}

void ContactRowSolver::collect_moved(std::span<const ContactRow> rows) {
  m_moved.clear();
  for (const ContactRow& row : rows) {
    for (std::size_t k = 0; k < row.nodes.size(); ++k) {
      if (row.weights[k] == 0) continue;
      double& load = m_loads[static_cast<std::size_t>(row.nodes[k])];
      if (load == 0) m_moved.push_back(row.nodes[k]);
      load += std::abs(row.weights[k]);
    }
  }
  std::ranges::sort(m_moved);
}

/// Of the moduli of the row of J M^-1 J^T.
double ContactRowSolver::row_sum(const ContactRow& row) const {
  double sum = 0;
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] == 0) continue;
    const auto node = static_cast<std::size_t>(row.nodes[k]);
    sum += m_inverse_masses[node] * std::abs(row.weights[k]) * m_loads[node];
  }
  return sum;
}

/// Moves the row's points by `change` times what their nodes weigh in it.
void ContactRowSolver::add_to_all(const ContactRow& row, const Vec3& change, std::vector<Vec3>& corrections) const {
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] == 0) continue;
    const auto node = static_cast<std::size_t>(row.nodes[k]);
    corrections[node] += (m_inverse_masses[node] * row.weights[k]) * change;
  }
}

void ContactRowSolver::displace(std::span<const ContactRow> rows, std::span<const Vec3> undone,
                                std::span<Vec3> predicted) {
  collect_moved(rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double sum = row_sum(rows[i]);
    if (sum > 0) add_to_all(rows[i], -undone[i] / sum, m_corrections);
  }
  for (const int node : m_moved) {
    const auto i = static_cast<std::size_t>(node);
    predicted[i] += std::exchange(m_corrections[i], Vec3::Zero());
    m_loads[i] = 0;
  }
}

bool ContactRowSolver::correct(const ContactRow& row, std::span<const Vec3> start, std::span<const Vec3> predicted) {
  Vec3 sum = Vec3::Zero();
  Vec3 start_sum = Vec3::Zero();
  double row_sum = 0;
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] == 0) continue;
    const auto node = static_cast<std::size_t>(row.nodes[k]);
    sum += row.weights[k] * predicted[node];
    start_sum += row.weights[k] * start[node];
    row_sum += m_inverse_masses[node] * std::abs(row.weights[k]) * m_loads[node];
  }
  const double gap_m = row.normal.dot(sum) - row.offset_m;
  if (!(gap_m < 0) || !(row_sum > 0)) return false;  // free, or bones hold all of it
  const double start_gap_m = row.start_normal.dot(start_sum) - row.start_offset_m;
  const double began_inside = std::clamp(start_gap_m / gap_m, 0.0, 1.0);
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] == 0) continue;
    const auto node = static_cast<std::size_t>(row.nodes[k]);
    const Vec3 correction = (-gap_m / row_sum * m_inverse_masses[node] * row.weights[k]) * row.normal;
    m_corrections[node] += correction;
    m_start_corrections[node] += began_inside * correction;
  }
  return true;
}

namespace {

double gap_to(const ContactRow& row, const Vec3& normal, double offset_m, std::span<const Vec3> positions) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] != 0) sum += row.weights[k] * positions[static_cast<std::size_t>(row.nodes[k])];
  }
  return normal.dot(sum) - offset_m;
}

}  // namespace

void ContactRowSolver::lay_out_slowly(std::span<ContactRow> rows, std::span<const Vec3> start,
                                      std::span<const Vec3> predicted, double most_m) {
  if (!std::isfinite(most_m)) return;
  if (std::exchange(m_is_first_call, false)) m_overlaps.assign(m_inverse_masses.size(), 1);
  if (m_overlaps.empty()) return;
  constexpr double least_share = 1e-6;  // of its depth; what lies flush overlaps by rounding
  m_overlap_now.assign(m_overlaps.size(), 0);
  bool are_any = false;
  for (ContactRow& row : rows) {
    const double depth_m = -gap_to(row, row.normal, row.offset_m, predicted);
    const double start_depth_m = -gap_to(row, row.start_normal, row.start_offset_m, start);
    if (!(depth_m > 0) || !(start_depth_m > least_share * depth_m)) continue;
    if (!overlapped_before(row)) continue;
    are_any = true;
    for (std::size_t k = 0; k < row.nodes.size(); ++k) {
      if (row.weights[k] != 0) m_overlap_now[static_cast<std::size_t>(row.nodes[k])] = 1;
    }
    const double excess_m = std::max(0.0, start_depth_m - most_m);
    row.offset_m -= excess_m;
    row.start_offset_m -= excess_m;
  }
  m_overlaps.swap(m_overlap_now);
  if (!are_any) m_overlaps.clear();
}

bool ContactRowSolver::overlapped_before(const ContactRow& row) const {
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] != 0 && m_overlaps[static_cast<std::size_t>(row.nodes[k])] != 0) return true;
  }
  return false;
}

void ContactRowSolver::solve(std::span<const ContactRow> rows, std::span<Vec3> start, std::span<Vec3> predicted) {
  collect_moved(rows);
  m_most_corrected = 0;
  int most_steps = 0;
  for (const ContactRow& row : rows) most_steps = std::max(most_steps, row.steps);
  for (int step = 0; step < most_steps; ++step) {
    int corrected = 0;
    for (const ContactRow& row : rows) {
      if (step < row.steps && correct(row, start, predicted)) ++corrected;
    }
    m_most_corrected = std::max(m_most_corrected, corrected);
    if (corrected == 0) break;
    for (const int node : m_moved) {
      const auto i = static_cast<std::size_t>(node);
      predicted[i] += std::exchange(m_corrections[i], Vec3::Zero());
      start[i] += std::exchange(m_start_corrections[i], Vec3::Zero());
    }
  }
  for (const int node : m_moved) m_loads[static_cast<std::size_t>(node)] = 0;
}

}  // namespace musclebench

#include "core/contact/contact_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/contact/contact_impulses.hpp"
#include "core/contact/contact_properties.hpp"

namespace musclebench {

namespace {

/// A step moves a node by no more than so many gaps of a row: more only throws the free corners of a face whose other
/// corners a bone holds.
constexpr double most_gaps = 2;
/// Of friction. A row that shares no node with another one that bears something is right after the first.
constexpr int friction_steps = 5;

/// Of a row's nodes, by its weights: between muscles how far its two points are apart.
Vec3 sum_over(const ContactRow& row, std::span<const Vec3> positions) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] != 0) sum += row.weights[k] * positions[static_cast<std::size_t>(row.nodes[k])];
  }
  return sum;
}

}  // namespace

ContactRowSolver::ContactRowSolver(std::vector<double> inverse_masses, double friction_coefficient)
    : m_inverse_masses(std::move(inverse_masses)),
      m_friction_coefficient(friction_coefficient),
      m_loads(m_inverse_masses.size()),
      m_corrections(m_inverse_masses.size(), Vec3::Zero()),
      m_start_corrections(m_inverse_masses.size(), Vec3::Zero()) {}

void ContactRowSolver::collect_moved(std::span<const ContactRow> rows) {
  m_moved.clear();
  for (const ContactRow& row : rows) {
    for (std::size_t k = 0; k < row.nodes.size(); ++k) {
      if (row.weights[k] == 0) continue;
      if (m_loads[static_cast<std::size_t>(row.nodes[k])].rows == 0) m_moved.push_back(row.nodes[k]);
    }
    add_load(row);
  }
  std::ranges::sort(m_moved);
}

void ContactRowSolver::add_load(const ContactRow& row) {
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] == 0) continue;
    Load& load = m_loads[static_cast<std::size_t>(row.nodes[k])];
    load.weights += std::abs(row.weights[k]);
    ++load.rows;
  }
}

void ContactRowSolver::clear_loads() {
  for (const int node : m_moved) m_loads[static_cast<std::size_t>(node)] = {};
}

/// Of the moduli of the row of J M^-1 J^T, or more where a node would move by too much.
double ContactRowSolver::row_sum(const ContactRow& row) const {
  double sum = 0;
  double largest = 0;
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] == 0) continue;
    const auto node = static_cast<std::size_t>(row.nodes[k]);
    const double share = m_inverse_masses[node] * std::abs(row.weights[k]);
    sum += share * m_loads[node].weights;
    largest = std::max(largest, share * m_loads[node].rows);
  }
  return std::max(sum, largest / most_gaps);
}

/// Moves the row's points by `change` times what their nodes weigh in it.
void ContactRowSolver::add_to_all(const ContactRow& row, const Vec3& change, std::vector<Vec3>& corrections) const {
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] == 0) continue;
    const auto node = static_cast<std::size_t>(row.nodes[k]);
    corrections[node] += (m_inverse_masses[node] * row.weights[k]) * change;
  }
}

bool ContactRowSolver::correct(const ContactRow& row, std::span<const Vec3> start, std::span<const Vec3> predicted,
                               double& multiplier) {
  const double gap_m = row.normal.dot(sum_over(row, predicted)) - row.offset_m;
  if (!(gap_m < 0)) return false;
  const double sum = row_sum(row);
  if (!(sum > 0)) return false;  // bones hold all of it
  const double start_gap_m = row.start_normal.dot(sum_over(row, start)) - row.start_offset_m;
  const double began_inside = std::clamp(start_gap_m / gap_m, 0.0, 1.0);
  multiplier -= (1 - began_inside) * gap_m / sum;
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    if (row.weights[k] == 0) continue;
    const auto node = static_cast<std::size_t>(row.nodes[k]);
    const Vec3 correction = (-gap_m / sum * m_inverse_masses[node] * row.weights[k]) * row.normal;
    m_corrections[node] += correction;
    m_start_corrections[node] += began_inside * correction;
  }
  return true;
}

void ContactRowSolver::lay_out_slowly(std::span<ContactRow> rows, std::span<const Vec3> start,
                                      std::span<const Vec3> predicted, double most_m) {
  if (!std::isfinite(most_m)) return;
  if (std::exchange(m_is_first_call, false)) m_overlaps.assign(m_inverse_masses.size(), 1);
  if (m_overlaps.empty()) return;
  constexpr double least_share = 1e-6;  // of its depth; what lies flush overlaps by rounding
  m_overlap_now.assign(m_overlaps.size(), 0);
  bool are_any = false;
  for (ContactRow& row : rows) {
    const double depth_m = row.offset_m - row.normal.dot(sum_over(row, predicted));
    const double start_depth_m = row.start_offset_m - row.start_normal.dot(sum_over(row, start));
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

void ContactRowSolver::solve(std::span<const ContactRow> rows, std::span<Vec3> start, std::span<Vec3> predicted,
                             ContactImpulses* impulses) {
  collect_moved(rows);
  m_multipliers.assign(rows.size(), 0);
  m_undone_m.assign(rows.size(), Vec3::Zero());
  correct_all(rows, start, predicted);
  if (m_friction_coefficient > 0) rub(rows, start, predicted);
  if (impulses != nullptr) tell(rows, *impulses);
  clear_loads();
}

void ContactRowSolver::tell(std::span<const ContactRow> rows, ContactImpulses& impulses) const {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!(m_multipliers[i] > 0)) continue;
    const ContactRow& row = rows[i];
    const Vec3 pushed = m_multipliers[i] * row.normal;
    const Vec3 moved = pushed - m_undone_m[i] / row_sum(row);
    for (std::size_t k = 0; k < row.nodes.size(); ++k) {
      if (row.weights[k] == 0) continue;
      impulses.add(row.nodes[k], impulses.other_side(row.bone, row.nodes, row.weights, k), row.weights[k] * moved,
                   row.weights[k] * pushed);
    }
  }
}

void ContactRowSolver::correct_all(std::span<const ContactRow> rows, std::span<Vec3> start, std::span<Vec3> predicted) {
  m_most_corrected = 0;
  int most_steps = 0;
  for (const ContactRow& row : rows) most_steps = std::max(most_steps, row.steps);
  for (int step = 0; step < most_steps; ++step) {
    int corrected = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (step < rows[i].steps && correct(rows[i], start, predicted, m_multipliers[i])) ++corrected;
    }
    m_most_corrected = std::max(m_most_corrected, corrected);
    if (corrected == 0) break;
    for (const int node : m_moved) {
      const auto i = static_cast<std::size_t>(node);
      predicted[i] += std::exchange(m_corrections[i], Vec3::Zero());
      start[i] += std::exchange(m_start_corrections[i], Vec3::Zero());
    }
  }
}

/// Projected Jacobi steps, as for the gaps: what all steps together undo of a row's slide stays within Coulomb's limit,
/// which is of impulses: a row's are its multiplier and what it undoes over its row sum. Rows that bear nothing do not
/// rub, and are no longer counted in the loads.
void ContactRowSolver::rub(std::span<const ContactRow> rows, std::span<const Vec3> start, std::span<Vec3> predicted) {
  clear_loads();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (m_multipliers[i] > 0) add_load(rows[i]);
  }
  for (int step = 0; step < friction_steps; ++step) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!(m_multipliers[i] > 0)) continue;
      const ContactRow& row = rows[i];
      const double sum = row_sum(row);
      const Vec3 moved = sum_over(row, predicted) - sum_over(row, start) - row.carried_m;
      const Vec3 wanted = m_undone_m[i] + moved - row.normal.dot(moved) * row.normal;
      const Vec3 undone =
          share_undone_by_friction(wanted.norm(), m_multipliers[i] * sum, m_friction_coefficient) * wanted;
      add_to_all(row, (m_undone_m[i] - undone) / sum, m_corrections);
      m_undone_m[i] = undone;
    }
    for (const int node : m_moved) {
      const auto i = static_cast<std::size_t>(node);
      predicted[i] += std::exchange(m_corrections[i], Vec3::Zero());
    }
  }
}

}  // namespace musclebench

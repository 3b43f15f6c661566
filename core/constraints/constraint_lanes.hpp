#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/pbd/node_order.hpp"
#include "core/pbd/node_rows.hpp"
#include "core/pbd/team.hpp"

namespace musclebench {

/// Constraints that are projected side by side. Fixed, so that data are laid out the same for every width of vectors.
constexpr std::size_t constraint_lanes = 8;

/// Offset of a row of `NodeRows`, in doubles.
constexpr std::int32_t row_offset(int row) { return static_cast<std::int32_t>(sizeof(NodeRow) / sizeof(double)) * row; }

/// The order in which constraints on `Nodes` nodes each are projected: in blocks of `constraint_lanes` constraints that
/// share no node; constraints that do share one keep the order that they were given in. So the result is that of
/// sequential Gauss-Seidel, to the bit, whatever the width of the vectors and the number of threads. Constraints
/// ordered by graph colour (`surface_edges`) make few and long runs without a shared node; a run is sorted by row, so
/// that a thread has the same rows in every run.
template <std::size_t Nodes>
class ConstraintOrder {
 public:
  ConstraintOrder(std::span<const std::array<int, Nodes>> constraints, const NodeOrder& order)
      : m_padding(static_cast<int>(order.size())) {
    std::vector<std::size_t> seen(order.size(), 0);  // by node: the last run that has it
    std::size_t run = 1;
    std::size_t start = 0;
    for (std::size_t i = 0; i < constraints.size(); ++i) {
      for (const int node : constraints[i]) {
        if (seen[static_cast<std::size_t>(node)] != run) continue;
        add_run(constraints, start, i, order);
        start = i;
        ++run;
        break;
      }
      for (const int node : constraints[i]) {
        seen[static_cast<std::size_t>(node)] = run;
      }
    }
    add_run(constraints, start, constraints.size(), order);
  }

  /// Number of slots, in whole blocks; a slot holds a constraint or padding.
  [[nodiscard]] std::size_t size() const { return m_slots.size(); }
  /// By slot: the index of its constraint; -1 in a padding lane.
  [[nodiscard]] std::span<const int> slots() const { return m_slots; }
  /// By slot: `row_offset` of the nodes at one end of the constraints.
  [[nodiscard]] const std::int32_t* row_offsets(std::size_t end) const { return m_row_offsets[end].data(); }

  /// Calls `project(first, last)` for all slots in an order that keeps the result; `team` shares long runs. No two
  /// slots of one call share a node.
  template <typename Project>
  void for_each(const Team& team, const Project& project) const {
    for (std::size_t i = 0; i < m_runs.size(); ++i) {
      const Run& run = m_runs[i];
      if (run.is_shared) {
        const std::size_t first_block = run.first / constraint_lanes;
        const Team::Share blocks =
            team.share_by_row(run.last / constraint_lanes - first_block, static_cast<std::size_t>(m_padding),
                              [&](std::size_t block) { return m_lowest_rows[first_block + block]; });
        project(run.first + blocks.first * constraint_lanes, run.first + blocks.last * constraint_lanes);
      } else if (team.is_first()) {
        project(run.first, run.last);
      }
      const bool goes_on_alone = !run.is_shared && i + 1 < m_runs.size() && !m_runs[i + 1].is_shared;
      if (!goes_on_alone) team.wait();
    }
  }

 private:
  /// Slots that share no node. Short runs are projected by one thread.
  struct Run {
    std::size_t first;
    std::size_t last;
    bool is_shared;
  };
  /// A run of fewer blocks is not worth a synchronisation.
  static constexpr std::size_t least_shared_blocks = 8;

  void add_run(std::span<const std::array<int, Nodes>> constraints, std::size_t start, std::size_t end,
               const NodeOrder& order) {
    if (start == end) return;
    const std::size_t first = m_slots.size();
    for (std::size_t i = start; i < end; ++i) {
      m_slots.push_back(static_cast<int>(i));
    }
    const auto lowest_row = [&](int constraint) {
      int lowest = m_padding;
      for (const int node : constraints[static_cast<std::size_t>(constraint)]) {
        lowest = std::min(lowest, order.row_of(node));
      }
      return lowest;
    };
    std::ranges::sort(std::span(m_slots).subspan(first), {}, lowest_row);
    for (std::size_t slot = first; slot < m_slots.size(); ++slot) {
      for (std::size_t n = 0; n < Nodes; ++n) {
        m_row_offsets[n].push_back(row_offset(order.row_of(constraints[static_cast<std::size_t>(m_slots[slot])][n])));
      }
      if (slot % constraint_lanes == 0) m_lowest_rows.push_back(lowest_row(m_slots[slot]));
    }
    while (m_slots.size() % constraint_lanes != 0) {
      m_slots.push_back(-1);
      for (auto& offsets : m_row_offsets) {
        offsets.push_back(row_offset(m_padding));
      }
    }
    m_runs.push_back({first, m_slots.size(), m_slots.size() - first >= least_shared_blocks * constraint_lanes});
  }

  int m_padding;
  std::vector<int> m_slots;
  std::array<std::vector<std::int32_t>, Nodes> m_row_offsets;
  std::vector<int> m_lowest_rows;  ///< by block
  std::vector<Run> m_runs;
};

/// The nodes of each of `constraints`.
template <std::size_t Nodes, typename Constraint>
std::vector<std::array<int, Nodes>> nodes_of(std::span<const Constraint> constraints) {
  std::vector<std::array<int, Nodes>> nodes;
  nodes.reserve(constraints.size());
  for (const Constraint& constraint : constraints) {
    nodes.push_back(constraint.nodes);
  }
  return nodes;
}

/// One number a slot: that of its constraint, or `padding`.
template <std::size_t Nodes, typename Value>
std::vector<double> by_slot(const ConstraintOrder<Nodes>& order, double padding, const Value& value) {
  std::vector<double> values;
  values.reserve(order.size());
  for (const int constraint : order.slots()) {
    values.push_back(constraint < 0 ? padding : value(static_cast<std::size_t>(constraint)));
  }
  return values;
}

}  // namespace musclebench

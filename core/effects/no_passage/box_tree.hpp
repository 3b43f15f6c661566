#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/morton_order.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A tree of axis-aligned boxes over items that move: eight children a node, without pointers. Items that are close
/// together when the tree is made are close together in it. Queries are const and safe from several threads.
class BoxTree {
 public:
  BoxTree() = default;
  /// `middles` of the items, m. The boxes are empty until `refit`.
  explicit BoxTree(std::span<const Vec3> middles) : m_items(morton_order(middles)) {
    for (std::size_t count = m_items.size(); count > 0; count = count > 1 ? (count + width - 1) / width : 0) {
      m_levels.emplace_back(count);
    }
  }

  /// Takes the box of each item from `box_of(item)`, an Eigen::AlignedBox3d in m.
  template <typename BoxOf>
  void refit(const BoxOf& box_of) {
    if (m_levels.empty()) return;
    for (std::size_t i = 0; i < m_items.size(); ++i) m_levels[0][i] = box_of(static_cast<std::size_t>(m_items[i]));
    for (std::size_t level = 1; level < m_levels.size(); ++level) {
      const auto& below = m_levels[level - 1];
      for (std::size_t i = 0; i < m_levels[level].size(); ++i) {
        Eigen::AlignedBox3d box;
        const std::size_t last = std::min((i + 1) * width, below.size());
        for (std::size_t child = i * width; child < last; ++child) box.extend(below[child]);
        m_levels[level][i] = box;
      }
    }
  }

  /// Of all items; empty without any.
  [[nodiscard]] Eigen::AlignedBox3d box() const {
    return m_levels.empty() ? Eigen::AlignedBox3d() : m_levels.back()[0];
  }

  /// Calls `visit(item, place)` with each item whose box meets `box`, in the ascending order of their places, which
  /// never change.
  template <typename Visit>
  void for_each_in(const Eigen::AlignedBox3d& box, const Visit& visit) const {
    if (!m_levels.empty()) visit_below(m_levels.size() - 1, 0, box, visit);
  }

 private:
  static constexpr std::size_t width = 8;

  template <typename Visit>
  void visit_below(std::size_t level, std::size_t index, const Eigen::AlignedBox3d& box, const Visit& visit) const {
    if (!m_levels[level][index].intersects(box)) return;
    if (level == 0) {
      visit(static_cast<std::size_t>(m_items[index]), index);
      return;
    }
    const std::size_t last = std::min((index + 1) * width, m_levels[level - 1].size());
    for (std::size_t child = index * width; child < last; ++child) visit_below(level - 1, child, box, visit);
  }

  std::vector<int> m_items;
  std::vector<std::vector<Eigen::AlignedBox3d>> m_levels;  ///< items first, the root last
};

}  // namespace musclebench

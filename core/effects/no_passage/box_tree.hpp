#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/bvh/bvh_lanes.hpp"
#include "core/bvh/moving_surface_boxes.hpp"
#include "core/mesh/morton_order.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A tree of axis-aligned boxes over items that move: eight children a node, without pointers. Items that are close
/// together when the tree is made are close together in it. Boxes are in single precision and a little larger than
/// asked for. Queries are const and safe from several threads.
class BoxTree {
 public:
  BoxTree() = default;
  /// `middles` of the items, m. The boxes are empty until `refit`.
  explicit BoxTree(std::span<const Vec3> middles) : m_items(morton_order(middles)), m_places(middles.size()) {
    for (std::size_t place = 0; place < m_items.size(); ++place) {
      m_places[static_cast<std::size_t>(m_items[place])] = place;
    }
    std::size_t count = m_items.size();
    while (count > 0) {
      count = (count + bvh_width - 1) / bvh_width;
      m_levels.emplace_back(count, none());
      if (count == 1) break;
    }
  }

  /// Of an item in the order of the tree, which never changes.
  [[nodiscard]] std::size_t place_of(std::size_t item) const { return m_places[item]; }

  /// Takes the box of each item from `box_of(item)`, an Eigen::AlignedBox3d in m.
  template <typename BoxOf>
  void refit(const BoxOf& box_of) {
    if (m_levels.empty()) return;
    m_origin = box_of(static_cast<std::size_t>(m_items[0])).center();
    double farthest_m = 0;
    for (std::size_t place = 0; place < m_items.size(); ++place) {
      const Eigen::AlignedBox3d box = box_of(static_cast<std::size_t>(m_items[place]));
      const Vec3 lower = box.min() - m_origin;
      const Vec3 upper = box.max() - m_origin;
      farthest_m = std::max({farthest_m, -lower.minCoeff(), upper.maxCoeff()});
      set(m_levels[0][place / bvh_width], place % bvh_width, {to_floats(lower), to_floats(upper)});
    }
    m_padding_m = rounding * farthest_m;
    for (std::size_t level = 1; level < m_levels.size(); ++level) {
      for (std::size_t i = 0; i < m_levels[level - 1].size(); ++i) {
        set(m_levels[level][i / bvh_width], i % bvh_width, bounds_of(m_levels[level - 1][i]));
      }
    }
  }

  /// Calls `visit(item, place)` with each item whose box meets `box` and whose place is at least `first_place`, in the
  /// ascending order of places.
  template <typename Visit>
  void for_each_in(const Eigen::AlignedBox3d& box, std::size_t first_place, const Visit& visit) const {
    if (m_levels.empty()) return;
    const Vec3 lower = box.min() - m_origin;
    const Vec3 upper = box.max() - m_origin;
    const double padding_m =
        m_padding_m + rounding * std::max(lower.cwiseAbs().maxCoeff(), upper.cwiseAbs().maxCoeff());
    const Vec3 padding = Vec3::Constant(padding_m);
    visit_below(m_levels.size() - 1, 0, {to_floats(lower - padding), to_floats(upper + padding)}, first_place, visit);
  }

 private:
  /// Several times that of a single-precision number, relative.
  static constexpr double rounding = 1e-6;

  static MovingBoxes none() {
    MovingBoxes boxes;
    for (auto& axis : boxes.lower) axis.fill(bvh_far_away);
    for (auto& axis : boxes.upper) axis.fill(-bvh_far_away);
    return boxes;
  }
  static std::array<float, 3> to_floats(const Vec3& point) {
    return {static_cast<float>(point.x()), static_cast<float>(point.y()), static_cast<float>(point.z())};
  }
  static void set(MovingBoxes& boxes, std::size_t lane, const BvhBox& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      boxes.lower[axis][lane] = box.lower[axis];
      boxes.upper[axis][lane] = box.upper[axis];
    }
  }
  static BvhBox bounds_of(const MovingBoxes& boxes) {
    BvhBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lower[axis] = *std::ranges::min_element(boxes.lower[axis]);
      box.upper[axis] = *std::ranges::max_element(boxes.upper[axis]);
    }
    return box;
  }

  template <typename Visit>
  void visit_below(std::size_t level, std::size_t index, const BvhBox& box, std::size_t first_place,
                   const Visit& visit) const {
    for_each_lane(find_boxes_in(m_levels[level][index], box), [&](std::size_t lane) {
      const std::size_t child = index * bvh_width + lane;
      if (level == 0) {
        if (child >= first_place) visit(static_cast<std::size_t>(m_items[child]), child);
      } else if ((child + 1) << (3 * level) > first_place) {
        visit_below(level - 1, child, box, first_place, visit);
      }
    });
  }

  std::vector<int> m_items;                        ///< by place
  std::vector<std::size_t> m_places;               ///< by item
  std::vector<std::vector<MovingBoxes>> m_levels;  ///< those of items first, the root last
  Vec3 m_origin = Vec3::Zero();
  double m_padding_m = 0;
};

}  // namespace musclebench

#include "core/referee/referee_tree_builder.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <numeric>
#include <tuple>

namespace musclebench {
namespace {

constexpr int leaf_size = 4;
constexpr int bin_count = 16;
/// Below this ratio of height to the square of the longest edge (2^-7 of it), barycentric weights lose too many digits.
constexpr double sliver_ratio = 0x1p-7;

double half_area(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return 0;
  const Vec3 size = box.sizes();
  return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

bool is_sliver(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return (b - a).cross(c - a).norm() <= sliver_ratio * longest;
}

/// One number a vertex, the same for vertices at the same position.
std::vector<std::uint64_t> position_ids(const std::vector<Vec3>& vertices) {
  std::vector<int> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto at = [&](int i) -> const Vec3& { return vertices[static_cast<std::size_t>(i)]; };
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    return std::lexicographical_compare(at(i).data(), at(i).data() + 3, at(j).data(), at(j).data() + 3);
  });
  std::vector<std::uint64_t> numbers(vertices.size(), 0);
  std::uint64_t number = 0;
  for (std::size_t k = 1; k < order.size(); ++k) {
    if (at(order[k]) != at(order[k - 1])) ++number;
    numbers[static_cast<std::size_t>(order[k])] = number;
  }
  return numbers;
}

}  // namespace

void RefereeTreeBuilder::build() {
  assert(!m_mesh.triangles.empty());
  centre();
  find_boundary();
  const int count = static_cast<int>(m_mesh.triangles.size());
  m_items.reserve(m_mesh.triangles.size());
  for (int index = 0; index < count; ++index) {
    Item item{Box(), Vec3::Zero(), index};
    for (const int vertex : m_mesh.triangles[static_cast<std::size_t>(index)]) {
      item.box.extend(m_vertices[static_cast<std::size_t>(vertex)]);
    }
    item.middle = item.box.center();
    m_items.push_back(item);
  }
  m_tree.m_nodes.reserve(m_items.size() / 4);
  [[maybe_unused]] const int root = add(range(0, count), 1);
  assert(root == 0);
  m_tree.m_nodes.shrink_to_fit();
  copy_triangles();
}

void RefereeTreeBuilder::centre() {
  Box box;
  for (const Triangle& triangle : m_mesh.triangles) {
    for (const int vertex : triangle) box.extend(m_mesh.vertices[static_cast<std::size_t>(vertex)]);
  }
  m_tree.m_centre = box.center();
  m_vertices.reserve(m_mesh.vertices.size());
  for (const Vec3& vertex : m_mesh.vertices) m_vertices.emplace_back(vertex - m_tree.m_centre);
  for (const Triangle& triangle : m_mesh.triangles) {
    for (const int vertex : triangle) {
      m_tree.m_half_extents = m_tree.m_half_extents.cwiseMax(m_vertices[static_cast<std::size_t>(vertex)].cwiseAbs());
    }
  }
}

/// Boundary edges are those whose uses in the two directions do not cancel; vertices at equal positions count as one.
void RefereeTreeBuilder::find_boundary() {
  const std::vector<std::uint64_t> ids = position_ids(m_vertices);
  struct Side {
    std::uint64_t edge;  // the undirected edge in the upper bits, its direction in the lowest one
    int from, to;        // vertices
  };
  const auto for_each_side = [&](const auto& visit) {
    for (const Triangle& triangle : m_mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const int from = triangle[k];
        const int to = triangle[(k + 1) % 3];
        const std::uint64_t start = ids[static_cast<std::size_t>(from)];
        const std::uint64_t end = ids[static_cast<std::size_t>(to)];
        const std::uint64_t edge = std::min(start, end) << 32U | std::max(start, end) << 1U | (start < end ? 1U : 0U);
        if (start != end) visit(static_cast<std::size_t>(std::min(start, end)), Side{edge, from, to});
      }
    }
  };
  // Sorted by their lower vertex in two passes, and then those of a vertex, which are few.
  std::vector<std::size_t> end_of(ids.size() + 1, 0);
  for_each_side([&](std::size_t lower, const Side& /*side*/) { ++end_of[lower + 1]; });
  std::partial_sum(end_of.begin(), end_of.end(), end_of.begin());
  std::vector<Side> sides(end_of.back());
  for_each_side([&](std::size_t lower, const Side& side) { sides[end_of[lower]++] = side; });
  for (std::size_t lower = 0, begin = 0; lower < ids.size(); begin = end_of[lower++]) {
    std::sort(sides.begin() + static_cast<std::ptrdiff_t>(begin),
              sides.begin() + static_cast<std::ptrdiff_t>(end_of[lower]), [](const Side& one, const Side& other) {
                return std::tie(one.edge, one.from, one.to) < std::tie(other.edge, other.from, other.to);
              });
  }
  std::size_t k = 0;
  while (k < sides.size()) {
    const std::uint64_t edge = sides[k].edge >> 1U;
    const Side first = sides[k];  // of one direction, and the last of the other if there are both
    int balance = 0;
    for (; k < sides.size() && sides[k].edge >> 1U == edge; ++k) balance += (sides[k].edge & 1U) != 0 ? 1 : -1;
    const bool first_runs_up = (first.edge & 1U) != 0;
    const Side& side = (balance > 0) == first_runs_up ? first : sides[k - 1];
    if (balance != 0) {
      m_tree.m_boundary.push_back({m_vertices[static_cast<std::size_t>(side.from)],
                                   m_vertices[static_cast<std::size_t>(side.to)], side.from, side.to,
                                   static_cast<double>(std::abs(balance))});
    }
  }
  m_tree.m_boundary.shrink_to_fit();
}

RefereeTreeBuilder::Range RefereeTreeBuilder::range(int first, int last) const {
  Range result{first, last, Box()};
  for (int i = first; i < last; ++i) result.box.extend(m_items[static_cast<std::size_t>(i)].box);
  return result;
}

int RefereeTreeBuilder::split_by_area(const Range& whole) {
  const auto begin = m_items.begin() + whole.first;
  const auto end = m_items.begin() + whole.last;
  Box middles;
  for (auto item = begin; item != end; ++item) middles.extend(item->middle);
  // Of the widest axis only: the best of three took a tenth of a run's set-up and saves its queries nothing to speak
  // of.
  int axis = 0;
  const double width = middles.sizes().maxCoeff(&axis);
  if (!(width > 0)) return whole.first;
  const auto bin_of = [&](const Item& item) {
    return std::min(bin_count - 1, static_cast<int>((item.middle[axis] - middles.min()[axis]) / width * bin_count));
  };
  std::array<Box, bin_count> boxes;
  std::array<int, bin_count> counts{};
  for (auto item = begin; item != end; ++item) {
    const auto bin = static_cast<std::size_t>(bin_of(*item));
    boxes[bin].extend(item->box);
    ++counts[bin];
  }
  std::array<double, bin_count> right_costs{};
  Box box;
  int count = 0;
  for (std::size_t bin = bin_count - 1; bin > 0; --bin) {
    box.extend(boxes[bin]);
    count += counts[bin];
    right_costs[bin] = half_area(box) * count;
  }
  box.setEmpty();
  count = 0;
  double best_cost = std::numeric_limits<double>::infinity();
  int best_bin = 0;
  for (std::size_t bin = 1; bin < bin_count; ++bin) {
    box.extend(boxes[bin - 1]);
    count += counts[bin - 1];
    const double cost = half_area(box) * count + right_costs[bin];
    if (count > 0 && count < whole.count() && cost < best_cost) {
      best_cost = cost;
      best_bin = static_cast<int>(bin);
    }
  }
  if (best_bin == 0) return whole.first;
  const auto middle = std::stable_partition(begin, end, [&](const Item& item) { return bin_of(item) < best_bin; });
  return static_cast<int>(middle - m_items.begin());
}

std::pair<RefereeTreeBuilder::Range, RefereeTreeBuilder::Range> RefereeTreeBuilder::split(const Range& whole,
                                                                                          int depth) {
  int middle = depth < depth_limit / 2 ? split_by_area(whole) : whole.first;
  if (middle == whole.first) {  // too deep, or all middles at one point
    middle = whole.first + whole.count() / 2;
    int axis = 0;
    whole.box.sizes().maxCoeff(&axis);
    std::nth_element(m_items.begin() + whole.first, m_items.begin() + middle, m_items.begin() + whole.last,
                     [axis](const Item& left, const Item& right) {
                       return std::pair(left.middle[axis], left.index) < std::pair(right.middle[axis], right.index);
                     });
  }
  return {range(whole.first, middle), range(middle, whole.last)};
}

int RefereeTreeBuilder::add(const Range& whole, int depth) {
  std::array<Range, 4> children;
  std::size_t count = 1;
  children[0] = whole;
  while (count < children.size()) {
    const auto cost = [](const Range& child) { return child.count() > leaf_size ? half_area(child.box) : -1.0; };
    const auto widest = std::max_element(children.begin(), children.begin() + static_cast<std::ptrdiff_t>(count),
                                         [&](const Range& a, const Range& b) { return cost(a) < cost(b); });
    if (widest->count() <= leaf_size) break;
    std::tie(*widest, children[count]) = split(*widest, depth);
    ++count;
  }

  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto index = m_tree.m_nodes.size();
  m_tree.m_nodes.emplace_back();
  for (std::size_t k = 0; k < 4; ++k) {
    const auto lane = static_cast<Eigen::Index>(k);
    for (int axis = 0; axis < 3; ++axis) {
      RefereeTree::Node& node = m_tree.m_nodes[index];
      node.low[axis][lane] = k < count ? round_down(children[k].box.min()[axis]) : infinity;
      node.high[axis][lane] = k < count ? round_up(children[k].box.max()[axis]) : -infinity;
    }
    int child = 0;
    if (k < count) {
      child = children[k].count() > leaf_size ? add(children[k], depth + 1)
                                              : ~(8 * children[k].first + children[k].count());
    }
    m_tree.m_nodes[index].child[k] = child;
  }
  return static_cast<int>(index);
}

void RefereeTreeBuilder::copy_triangles() {
  m_tree.m_triangles.reserve(m_items.size());
  for (const Item& item : m_items) {
    const Triangle& corners = m_mesh.triangles[static_cast<std::size_t>(item.index)];
    const Vec3& a = m_vertices[static_cast<std::size_t>(corners[0])];
    const Vec3& b = m_vertices[static_cast<std::size_t>(corners[1])];
    const Vec3& c = m_vertices[static_cast<std::size_t>(corners[2])];
    m_tree.m_triangles.push_back({a, b, c, item.index, is_sliver(a, b, c)});
  }
}

void RefereeTreeBuilder::refit(std::span<const Triangle> triangles, std::span<const Vec3> vertices, RefereeTree& tree) {
  tree.m_half_extents.setZero();
  for (RefereeTree::Corners& corners : tree.m_triangles) {
    const Triangle& triangle = triangles[static_cast<std::size_t>(corners.index)];
    corners.a = vertices[static_cast<std::size_t>(triangle[0])] - tree.m_centre;
    corners.b = vertices[static_cast<std::size_t>(triangle[1])] - tree.m_centre;
    corners.c = vertices[static_cast<std::size_t>(triangle[2])] - tree.m_centre;
    corners.sliver = is_sliver(corners.a, corners.b, corners.c);
    const Vec3 reach = corners.a.cwiseAbs().cwiseMax(corners.b.cwiseAbs()).cwiseMax(corners.c.cwiseAbs());
    tree.m_half_extents = tree.m_half_extents.cwiseMax(reach);
  }
  for (RefereeTree::BoundaryEdge& edge : tree.m_boundary) {
    edge.from = vertices[static_cast<std::size_t>(edge.from_vertex)] - tree.m_centre;
    edge.to = vertices[static_cast<std::size_t>(edge.to_vertex)] - tree.m_centre;
  }
  // A node stands before its children.
  for (auto node = tree.m_nodes.rbegin(); node != tree.m_nodes.rend(); ++node) {
    for (Eigen::Index lane = 0; lane < 4; ++lane) {
      if (!(node->low[0][lane] <= node->high[0][lane])) continue;  // absent
      const int child = node->child[lane];
      if (child >= 0) {
        const RefereeTree::Node& below = tree.m_nodes[static_cast<std::size_t>(child)];
        for (int axis = 0; axis < 3; ++axis) {
          node->low[axis][lane] = below.low[axis].minCoeff();
          node->high[axis][lane] = below.high[axis].maxCoeff();
        }
        continue;
      }
      Box box;
      for (int slot = ~child / 8; slot < ~child / 8 + ~child % 8; ++slot) {
        const RefereeTree::Corners& corners = tree.m_triangles[static_cast<std::size_t>(slot)];
        box.extend(corners.a).extend(corners.b).extend(corners.c);
      }
      for (int axis = 0; axis < 3; ++axis) {
        node->low[axis][lane] = round_down(box.min()[axis]);
        node->high[axis][lane] = round_up(box.max()[axis]);
      }
    }
  }
}

}  // namespace musclebench

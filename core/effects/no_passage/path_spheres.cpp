#include "core/effects/no_passage/path_spheres.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

namespace musclebench {

namespace {

constexpr double rounding = lane_rounding;

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

Vec3 to_vector(const Four& numbers) { return numbers.head<3>().cast<double>().matrix(); }

/// Four vectors, one a column, as their x, y and z, one a column.
using FourVectors = Eigen::Matrix4f;

/// Of the lengths of four vectors, squared.
Four squared_lengths(const FourVectors& axes) {
  return axes.col(0).array().square() + axes.col(1).array().square() + axes.col(2).array().square();
}

/// How many nodes there are on each level, from triangles to the root.
std::vector<std::size_t> level_sizes(std::size_t triangles, int levels) {
  std::vector<std::size_t> sizes{triangles};
  while (sizes.back() > 1 || std::ssize(sizes) <= levels) sizes.push_back((sizes.back() + bvh_width - 1) / bvh_width);
  return sizes;
}

/// Orders items so that each eighth, eighth of an eighth and so on is close together: halves along the longest axis,
/// each cut where a subtree of eights is full.
void order_by_halves(std::span<int> items, std::span<const Vec3> middles) {
  if (items.size() <= bvh_width) return;
  Eigen::AlignedBox3d box;
  for (const int item : items) box.extend(middles[at_index(item)]);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  std::size_t full = bvh_width;  // of the largest subtrees that fit more than once
  while (full * bvh_width < items.size()) full *= bvh_width;
  const std::size_t half = std::max<std::size_t>((items.size() / 2 + full / 2) / full, 1) * full;
  const auto cut = items.begin() + static_cast<std::ptrdiff_t>(half);
  std::nth_element(items.begin(), cut, items.end(), [&](int one, int other) {
    return std::pair(middles[at_index(one)][axis], one) < std::pair(middles[at_index(other)][axis], other);
  });
  order_by_halves(items.first(half), middles);
  order_by_halves(items.subspan(half), middles);
}

}  // namespace

TriangleTree::TriangleTree(std::span<const Triangle> triangles, std::span<const Vec3> at, std::size_t first,
                           std::size_t last, int levels)
    : m_triangles(last - first), m_sizes(level_sizes(last - first, levels)) {
  std::vector<Vec3> middles;
  for (const Triangle& t : triangles)
    middles.push_back((at[at_index(t[0])] + at[at_index(t[1])] + at[at_index(t[2])]) / 3);
  std::iota(m_triangles.begin(), m_triangles.end(), static_cast<int>(first));
  order_by_halves(m_triangles, middles);
  std::vector<std::size_t> seen(at.size(), 0);  // by vertex: the node that it was last put in, from 1 on
  std::size_t below = 1;
  std::size_t number = 0;
  for (int level = 1; level <= 2; ++level) {
    below *= bvh_width;
    Lists& by_node = m_vertices[at_index(level) - 1];
    for (std::size_t node = 0; node < size(level); ++node) {
      ++number;
      by_node.first.push_back(by_node.numbers.size());
      for (std::size_t place = node * below; place < std::min((node + 1) * below, size(0)); ++place) {
        for (const int vertex : triangles[triangle(place)]) {
          if (std::exchange(seen[at_index(vertex)], number) != number) by_node.numbers.push_back(vertex);
        }
      }
      while ((by_node.numbers.size() - by_node.first.back()) % 4 != 0) {
        by_node.numbers.push_back(by_node.numbers.back());
      }
    }
    by_node.first.push_back(by_node.numbers.size());
  }
  std::vector<std::pair<int, int>> leaves_of;  // vertex and leaf
  for (std::size_t leaf = 0; leaf < size(1); ++leaf) {
    for (const int vertex : vertices(1, leaf)) leaves_of.emplace_back(vertex, static_cast<int>(leaf));
  }
  std::ranges::sort(leaves_of);
  leaves_of.erase(std::unique(leaves_of.begin(), leaves_of.end()), leaves_of.end());
  if (!leaves_of.empty()) m_first_vertex = at_index(leaves_of.front().first);
  m_leaves.first.assign(leaves_of.empty() ? 1 : at_index(leaves_of.back().first) - m_first_vertex + 2, 0);
  for (const auto& [vertex, leaf] : leaves_of) {
    ++m_leaves.first[at_index(vertex) - m_first_vertex + 1];
    m_leaves.numbers.push_back(leaf);
  }
  std::partial_sum(m_leaves.first.begin(), m_leaves.first.end(), m_leaves.first.begin());
}

VertexPath::VertexPath(const Vec3& start, const Vec3& end, const Vec3& origin) {
  from.head<3>() = (start - origin).cast<float>();
  move.head<3>() = (end - start).cast<float>();
}

PathSphere PathSphere::around(std::span<const int> vertices, std::span<const VertexPath> paths, const Vec3& origin) {
  Four from = Four::Zero();
  Four move = Four::Zero();
  for (const int vertex : vertices) {
    from += paths[at_index(vertex)].from;
    move += paths[at_index(vertex)].move;
  }
  from /= static_cast<float>(vertices.size());
  move /= static_cast<float>(vertices.size());
  Four radius = Four::Zero();
  Four spread = Four::Zero();
  for (std::size_t i = 0; i < vertices.size(); i += 4) {
    FourVectors from_centre;
    FourVectors beside_it;
    for (std::size_t k = 0; k < 4; ++k) {
      const VertexPath& path = paths[at_index(vertices[i + k])];
      from_centre.col(static_cast<Eigen::Index>(k)) = path.from - from;
      beside_it.col(static_cast<Eigen::Index>(k)) = path.move - move;
    }
    radius = radius.max(squared_lengths(from_centre.transpose()));
    spread = spread.max(squared_lengths(beside_it.transpose()));
  }
  const Vec3 centre = origin + to_vector(from);
  // What single precision loses here grows with the distance from this origin, not from that of another frame.
  const double radius_m = std::sqrt(radius.maxCoeff());
  const double spread_m = std::sqrt(spread.maxCoeff());
  return {centre, centre + to_vector(move), radius_m + rounding * (radius_m + from.abs().maxCoeff()),
          spread_m + rounding * (spread_m + move.abs().maxCoeff())};
}

PathSphere PathSphere::around(std::span<const PathSphere> parts) {
  PathSphere sphere;
  for (const PathSphere& part : parts) {
    sphere.from += part.from;
    sphere.to += part.to;
  }
  const auto count = static_cast<double>(parts.size());
  sphere.from /= count;
  sphere.to /= count;
  const Vec3 move = sphere.to - sphere.from;
  for (const PathSphere& part : parts) {
    sphere.radius_m = std::max(sphere.radius_m, (part.from - sphere.from).norm() + part.radius_m);
    sphere.spread_m = std::max(sphere.spread_m, (part.to - part.from - move).norm() + part.spread_m);
  }
  return sphere;
}

PathSpheres::PathSpheres(const TriangleTree& tree, const Vec3& origin) : m_tree(tree), m_origin(origin) {
  for (int level = 1; level <= tree.top(); ++level) {
    m_levels.emplace_back(tree.size(level));
  }
}

void PathSpheres::change(std::span<const int> vertices) {
  m_is_all_changed = false;
  ++m_changes;
  for (const int vertex : vertices) {
    forget_vertex(vertex);
    for (const int leaf : m_tree.leaves(vertex)) {
      auto node = at_index(leaf);
      for (int level = 1; level <= m_tree.top(); ++level, node /= bvh_width) {
        Level& of = m_levels[at_index(level) - 1];
        if (of.changed[node] == m_changes) break;
        of.changed[node] = m_changes;
        of.made[node].store(0, std::memory_order_relaxed);
        forget_sphere(level, node);
      }
    }
  }
}

void PathSpheres::make(int level, std::size_t node) {
  Level& of = m_levels[at_index(level) - 1];
  const std::scoped_lock lock(m_making);
  if (of.made[node].load(std::memory_order_relaxed) == m_paths) return;
  SphereLanes& lanes = of.below[node];
  fill(level, node, lanes);
  for (std::size_t lane = 0; lane < bvh_width; ++lane) {
    of.motions[node * bvh_width + lane] =
        Four(lanes.move[0][lane], lanes.move[1][lane], lanes.move[2][lane], lanes.spread_m[lane]);
  }
  of.made[node].store(m_paths, std::memory_order_release);
}

void PathSpheres::set(SphereLanes& lanes, std::size_t lane, const PathSphere& sphere) const {
  const Vec3 centre = sphere.from - m_origin;
  const Vec3 move = sphere.to - sphere.from;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lanes.from[axis][lane] = static_cast<float>(centre[static_cast<Eigen::Index>(axis)]);
    lanes.move[axis][lane] = static_cast<float>(move[static_cast<Eigen::Index>(axis)]);
  }
  lanes.radius_m[lane] =
      static_cast<float>(sphere.radius_m + rounding * (sphere.radius_m + centre.cwiseAbs().maxCoeff()));
  lanes.spread_m[lane] =
      static_cast<float>(sphere.spread_m + rounding * (sphere.spread_m + move.cwiseAbs().maxCoeff()));
}

void PathSpheres::clear(SphereLanes& lanes, std::size_t lane) {
  for (std::size_t axis = 0; axis < 3; ++axis) lanes.from[axis][lane] = lanes.move[axis][lane] = 0;
  lanes.radius_m[lane] = -nowhere_m;
  lanes.spread_m[lane] = 0;
}

void PathSpheres::set_triangles(SphereLanes& lanes, std::size_t count,
                                const std::array<TrianglePath, bvh_width>& paths) {
  static_assert(bvh_width == 8);
  for (std::size_t first = 0; first < count; first += 4) {
    std::array<FourVectors, 3> from;
    std::array<FourVectors, 3> move;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t lane = 0; lane < 4; ++lane) {
        const VertexPath& path = *paths[std::min(first + lane, count - 1)][k];
        from[k].col(static_cast<Eigen::Index>(lane)) = path.from;
        move[k].col(static_cast<Eigen::Index>(lane)) = path.move;
      }
      from[k].transposeInPlace();
      move[k].transposeInPlace();
    }
    const FourVectors centre = (from[0] + from[1] + from[2]) / 3;
    const FourVectors mean = (move[0] + move[1] + move[2]) / 3;
    Four radius = Four::Zero();
    Four spread = Four::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      radius = radius.max(squared_lengths(from[k] - centre));
      spread = spread.max(squared_lengths(move[k] - mean));
    }
    const auto store = [&](BvhLanes& lanes_of, const Four& numbers) {
      Eigen::Map<Four>(lanes_of.data() + first) = numbers;
    };
    const auto largest = [](const FourVectors& of) {
      return of.col(0).array().abs().max(of.col(1).array().abs()).max(of.col(2).array().abs()).eval();
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      store(lanes.from[axis], centre.col(static_cast<Eigen::Index>(axis)));
      store(lanes.move[axis], mean.col(static_cast<Eigen::Index>(axis)));
    }
    store(lanes.radius_m, (1 + lane_rounding) * radius.sqrt() + lane_rounding * largest(centre));
    store(lanes.spread_m, (1 + lane_rounding) * spread.sqrt() + lane_rounding * largest(mean));
  }
  for (std::size_t lane = count; lane < bvh_width; ++lane) clear(lanes, lane);
}

GivenPaths::GivenPaths(const TriangleTree& tree, std::span<const Triangle> triangles)
    : PathSpheres(tree, Vec3::Zero()), m_triangles(triangles) {
  for (int level = 1; level <= tree.top(); ++level) m_spheres.emplace_back(tree.size(level));
}

void GivenPaths::set(std::span<const VertexPath> paths, const Vec3& origin) {
  m_vertices = paths;
  m_origin = origin;
  forget();
}

TrianglePath GivenPaths::triangle(std::size_t triangle) const {
  const auto& [a, b, c] = m_triangles[triangle];
  return {&m_vertices[at_index(a)], &m_vertices[at_index(b)], &m_vertices[at_index(c)]};
}

PathSphere GivenPaths::sphere(int level, std::size_t node) {
  const std::scoped_lock lock(making());
  return make_sphere(level, node);
}

const PathSphere& GivenPaths::make_sphere(int level, std::size_t node) {
  Made& made = m_spheres[at_index(level) - 1][node];
  if (made.paths == m_paths) return made.sphere;
  made.paths = m_paths;
  if (level <= 2) return made.sphere = PathSphere::around(m_tree.vertices(level, node), m_vertices, m_origin);
  std::array<PathSphere, bvh_width> parts;
  std::size_t count = 0;
  for (std::size_t child = node * bvh_width; child < m_tree.size(level - 1) && count < bvh_width; ++child) {
    parts[count++] = make_sphere(level - 1, child);
  }
  return made.sphere = PathSphere::around(std::span(parts).first(count));
}

void GivenPaths::fill(int level, std::size_t node, SphereLanes& lanes) {
  const std::size_t first = node * bvh_width;
  const std::size_t count = std::min(bvh_width, m_tree.size(level - 1) - first);
  if (level > 1) {
    for (std::size_t lane = 0; lane < count; ++lane)
      PathSpheres::set(lanes, lane, make_sphere(level - 1, first + lane));
    for (std::size_t lane = count; lane < bvh_width; ++lane) clear(lanes, lane);
    return;
  }
  std::array<TrianglePath, bvh_width> paths;
  for (std::size_t lane = 0; lane < count; ++lane) paths[lane] = triangle(m_tree.triangle(first + lane));
  set_triangles(lanes, count, paths);
}

PathsInBone::PathsInBone(GivenPaths& given, std::span<const Triangle> triangles, std::span<const char> is_carried,
                         std::size_t first_vertex, std::size_t last_vertex, const Vec3& origin)
    : PathSpheres(given.tree(), origin),
      m_given(given),
      m_triangles(triangles),
      m_first_vertex(first_vertex),
      m_placed(last_vertex - first_vertex) {
  for (int level = 0; level <= m_tree.top(); ++level) {
    std::vector<char> is_out(m_tree.size(level), 1);
    if (level == 0) {
      for (std::size_t place = 0; place < is_out.size(); ++place) {
        for (const int vertex : triangles[m_tree.triangle(place)]) is_out[place] &= is_carried[at_index(vertex)];
      }
    } else {
      const std::vector<char>& of_children = m_is_out.back();
      for (std::size_t child = 0; child < of_children.size(); ++child) is_out[child / bvh_width] &= of_children[child];
    }
    m_is_out.push_back(std::move(is_out));
  }
}

void PathsInBone::set(std::span<const Vec3> start, std::span<const Vec3> end, const RigidMotion& from,
                      const RigidMotion& to) {
  m_world_start = start;
  m_world_end = end;
  m_from = from;
  m_to = to;
  m_from_world = from.rotation.transpose();
  // The modulus of a difference of rotations is at most its Frobenius norm over the root of 2.
  m_turn = (to.rotation - from.rotation).norm() / std::sqrt(2.0);
  forget();
}

TrianglePath PathsInBone::triangle(std::size_t triangle) const {
  const auto path = [&](std::size_t k) { return &m_placed[at_index(m_triangles[triangle][k]) - m_first_vertex].path; };
  return {path(0), path(1), path(2)};
}

void PathsInBone::fill(int level, std::size_t node, SphereLanes& lanes) {
  const std::size_t first = node * bvh_width;
  const std::size_t count = std::min(bvh_width, m_tree.size(level - 1) - first);
  const std::vector<char>& is_out = m_is_out[at_index(level) - 1];
  if (level > 1) {
    for (std::size_t lane = 0; lane < count; ++lane) {
      PathSphere sphere = m_given.sphere(level - 1, first + lane);
      sphere.spread_m += m_turn * sphere.radius_m;
      sphere.from = m_from.apply_inverse(sphere.from);
      sphere.to = m_to.apply_inverse(sphere.to);
      PathSpheres::set(lanes, lane, sphere);
    }
  } else {
    std::array<TrianglePath, bvh_width> paths;
    for (std::size_t lane = 0; lane < count; ++lane) {
      const std::size_t t = m_tree.triangle(first + lane);
      for (const int vertex : m_triangles[t]) {
        Placed& placed = m_placed[at_index(vertex) - m_first_vertex];
        if (placed.paths != m_paths) placed = {VertexPath(start(vertex), end(vertex), m_origin), m_paths};
      }
      paths[lane] = triangle(t);
    }
    set_triangles(lanes, count, paths);
  }
  for (std::size_t lane = 0; lane < bvh_width; ++lane) {
    if (lane >= count || is_out[first + lane] != 0) clear(lanes, lane);
  }
}

}  // namespace musclebench

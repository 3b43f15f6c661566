#include "core/bvh/batch/batched_closest_point.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace musclebench {

namespace {

constexpr std::size_t most_points = BatchedClosestPoint::bundle * PointBatch::capacity;

Eigen::AlignedBox3d box_about(std::span<const PointBatch> batches) {
  Eigen::AlignedBox3d box;
  for (const PointBatch& batch : batches) {
    for (std::size_t n = 0; n < batch.count; ++n) {
      box.extend(batch.point[n]);
    }
  }
  return box;
}

/// The lane of the first triangle that is no sliver; negative where there is none.
std::int32_t first_sound_triangle(const BvhLeaf& leaf) {
  const auto sound = ~leaf.slivers & ((1U << static_cast<unsigned>(leaf.count)) - 1);
  return sound == 0 ? -1 : std::countr_zero(sound);
}

}  // namespace

BatchedClosestPoint::BatchedClosestPoint(const TriangleBvh& bvh) : m_bvh(&bvh) {
  for (std::size_t leaf = 0; leaf < bvh.m_leaves.size() && m_any_triangle < 0; ++leaf) {
    const std::int32_t lane = first_sound_triangle(bvh.m_leaves[leaf]);
    m_any_triangle = lane < 0 ? -1 : static_cast<std::int32_t>(leaf * bvh_width) + lane;
  }
}

std::array<float, 3> BatchedClosestPoint::to_tree_frame(const Vec3& point) const {
  const Vec3 own = m_bvh->m_scale * (point - m_bvh->m_centre_m);
  return {static_cast<float>(own.x()), static_cast<float>(own.y()), static_cast<float>(own.z())};
}

QueryBox BatchedClosestPoint::query_box(const Eigen::AlignedBox3d& box) const {
  QueryBox own;
  own.middle = to_tree_frame(box.center());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = box.sizes()[static_cast<Eigen::Index>(axis)];
    own.half[axis] = static_cast<float>(0.5 * m_bvh->m_scale * size) * 1.000001F + m_view.slack;
  }
  return own;
}

BvhView BatchedClosestPoint::view_from(const Eigen::AlignedBox3d& box) const {
  const Vec3& middle = m_bvh->m_centre_m;
  const double reach =
      m_bvh->m_scale * (box.max() - middle).cwiseAbs().cwiseMax((box.min() - middle).cwiseAbs()).maxCoeff();
  const double coordinate = m_bvh->m_scale * box.max().cwiseAbs().cwiseMax(box.min().cwiseAbs()).maxCoeff();
  return {m_bvh->m_nodes.data(),
          m_bvh->m_leaves.data(),
          static_cast<float>(m_bvh->m_longest_side),
          m_bvh->slack_for(reach, coordinate),
          m_bvh->near_slack_for(reach, coordinate),
          TriangleBvh::slack_growth};
}

std::int32_t BatchedClosestPoint::bounding_triangle(int triangle) const {
  const std::int32_t index = m_bvh->m_leaf_of[static_cast<std::size_t>(triangle)];
  const BvhLeaf& leaf = m_bvh->m_leaves[static_cast<std::size_t>(index)];
  const std::size_t own = leaf.lane_of(triangle);
  const bool is_sliver = (leaf.slivers >> own & 1U) != 0;
  const std::int32_t lane = is_sliver ? first_sound_triangle(leaf) : static_cast<std::int32_t>(own);
  return lane < 0 ? m_any_triangle : index * static_cast<std::int32_t>(bvh_width) + lane;
}

void BatchedClosestPoint::begin(const Eigen::AlignedBox3d& box, int triangle) {
  m_bounds = box;
  m_view = view_from(box);
  m_box = query_box(box);
  if (const std::int32_t index = bounding_triangle(triangle); index >= 0) {
    bound_by_triangle(m_view, index, m_box);
  }
  list_nodes(m_view, m_box, m_nodes);
}

void BatchedClosestPoint::closest_points(std::span<PointBatch> batches) {
  for (std::size_t first = 0; first < batches.size(); first += bundle) {
    search_bundle(batches.subspan(first, std::min(bundle, batches.size() - first)));
  }
}

void BatchedClosestPoint::search_bundle(std::span<PointBatch> batches) {
  const Eigen::AlignedBox3d about = box_about(batches);
  if (about.isEmpty()) {
    return;
  }
  assert(m_bounds.contains(about));
  QueryBox box = query_box(about);
  list_leaves(m_view, m_nodes, m_box, box, m_near, m_leaves);
  m_candidates.count = 0;
  m_batch.count = 0;
  for (std::size_t p = 0; p < batches.size(); ++p) {
    if (m_batch.count + batches[p].count > QueryBatch::capacity) {
      search_points(box);
    }
    add_points(batches[p], p);
  }
  search_points(box);
  decide(batches);
}

void BatchedClosestPoint::add_points(const PointBatch& added, std::size_t number) {
  const double scale = m_bvh->m_scale;
  const Vec3 centre = m_bvh->m_centre_m;
  if (m_batch.count == 0) {
    m_batch.first_count = added.count;
  }
  for (std::size_t n = 0; n < added.count; ++n) {
    const std::size_t index = m_batch.count++;
    m_batch.number[index] = static_cast<std::int32_t>(number * PointBatch::capacity + n);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      m_batch.at[axis][index] = static_cast<float>(scale * (added.point[n][a] - centre[a]));
    }
  }
}

void BatchedClosestPoint::search_points(const QueryBox& box) {
  for (QueryBatch::PointLanes& at : m_batch.at) {
    std::fill(at.begin() + static_cast<std::ptrdiff_t>(m_batch.count), at.end(), at[0]);
  }
  list_candidate_triangles(m_view, m_leaves, box, m_batch, m_candidates);
  m_batch.count = 0;
}

void BatchedClosestPoint::decide(std::span<PointBatch> batches) {
  constexpr std::size_t width = ClosestOnTriangles::width;
  assert(m_candidates.count > 0);
  std::array<Vec3, most_points> points;
  for (std::size_t p = 0; p < batches.size(); ++p) {
    std::copy_n(batches[p].point.begin(), batches[p].count,
                points.begin() + static_cast<std::ptrdiff_t>(p * PointBatch::capacity));
  }
  const std::size_t rounded_up = (m_candidates.count + width - 1) / width * width;
  m_candidates.make_room(rounded_up - m_candidates.count);
  for (std::size_t pair = m_candidates.count; pair < rounded_up; ++pair) {
    m_candidates.point[pair] = m_candidates.point[0];
    m_candidates.triangle[pair] = m_candidates.triangle[0];
  }
  m_found.resize(std::max(m_found.size(), rounded_up / width));
  closest_on_triangles(points.data(), m_bvh->m_corners.data(), {m_candidates.point.data(), rounded_up},
                       {m_candidates.triangle.data(), rounded_up}, m_found);
  // Most pairs are ties, so that no branch could be foreseen: first the least distance, then the first triangle there.
  const auto squared_of = [&](std::size_t pair) { return m_found[pair / width].squared_distance_m2[pair % width]; };
  std::array<double, most_points> least;
  least.fill(std::numeric_limits<double>::infinity());
  for (std::size_t pair = 0; pair < m_candidates.count; ++pair) {
    double& of_point = least[static_cast<std::size_t>(m_candidates.point[pair])];
    of_point = std::min(of_point, squared_of(pair));
  }
  constexpr auto none = std::numeric_limits<std::uint64_t>::max();
  std::array<std::uint64_t, most_points> first;  // triangle, and its pair in the lower half
  first.fill(none);
  for (std::size_t pair = 0; pair < m_candidates.count; ++pair) {
    const auto point = static_cast<std::size_t>(m_candidates.point[pair]);
    const std::uint64_t not_least = 0 - static_cast<std::uint64_t>(squared_of(pair) > least[point]);
    first[point] =
        std::min(first[point], static_cast<std::uint64_t>(m_candidates.triangle[pair]) << 32U | pair | not_least);
  }
  for (std::size_t p = 0; p < batches.size(); ++p) {
    for (std::size_t n = 0; n < batches[p].count; ++n) {
      assert(first[p * PointBatch::capacity + n] != none);
      const auto pair = static_cast<std::uint32_t>(first[p * PointBatch::capacity + n]);
      const ClosestOnTriangles& eight = m_found[pair / width];
      const std::size_t lane = pair % width;
      ClosestPoint& closest = batches[p].closest[n];
      closest.point = {eight.x[lane], eight.y[lane], eight.z[lane]};
      closest.distance_m = std::sqrt(eight.squared_distance_m2[lane]);
      closest.triangle = m_candidates.triangle[pair];
      closest.feature = static_cast<Feature>(eight.feature[lane]);
    }
  }
}

}  // namespace musclebench

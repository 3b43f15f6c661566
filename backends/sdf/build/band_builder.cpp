#include "backends/sdf/build/band_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace musclebench {

namespace {

/// Covers the rounding of centres and distances.
constexpr double rounding_slack = 1e-9;

struct CellRange {
  GridIndex::Coordinates from, to;
};

struct Sphere {
  Vec3 centre;
  double radius_m;
};

Sphere sphere_around(const GridShape& shape, const CellRange& range) {
  const auto corner = [&](const std::array<std::size_t, 3>& index) {
    return shape.vertex(static_cast<int>(index[0]), static_cast<int>(index[1]), static_cast<int>(index[2]));
  };
  const Vec3 lower = corner(range.from);
  const Vec3 upper = corner(range.to);
  return {0.5 * (lower + upper), 0.5 * (upper - lower).norm() * (1 + rounding_slack)};
}

/// Whether all of the sphere is outside and farther from the surface than the band's width; `bound_m` is then a lower
/// bound of its distance.
bool is_far(const SignedSurface& surface, const Sphere& sphere, double width_m, double& bound_m) {
  const std::optional<ClosestPoint> near = surface.tree().closest_point(sphere.centre, width_m + sphere.radius_m);
  if (near) {
    return false;
  }
  const ClosestPoint closest = *surface.tree().closest_point(sphere.centre);
  bound_m = closest.distance_m * (1 - rounding_slack) - sphere.radius_m;
  return bound_m > width_m && !surface.is_inside(sphere.centre, closest);
}

/// The same for one cell. An elongated one fills little of its circumscribed sphere, so it is tested in pieces.
bool is_far_cell(const SignedSurface& surface, const GridShape& shape, const CellRange& cell, double width_m) {
  constexpr int most_pieces = 8;
  Eigen::Index axis = 0;
  const double longest = shape.cell_size_m.maxCoeff(&axis);
  const int pieces = std::clamp(static_cast<int>(std::round(longest / shape.cell_size_m.minCoeff())), 1, most_pieces);
  Vec3 half = 0.5 * shape.cell_size_m;
  half[axis] /= pieces;
  const Vec3 lower =
      shape.vertex(static_cast<int>(cell.from[0]), static_cast<int>(cell.from[1]), static_cast<int>(cell.from[2]));
  for (int piece = 0; piece < pieces; ++piece) {
    double bound_m = 0;
    const Vec3 centre = lower + half + 2 * piece * half[axis] * Vec3::Unit(axis);
    if (!is_far(surface, {centre, half.norm() * (1 + rounding_slack)}, width_m, bound_m)) {
      return false;
    }
  }
  return true;
}

/// What one block keeps: a bit a cell, in the order of `for_each_in`.
struct Choice {
  std::uint64_t kept = 0;
  double far_m = 0;
};

Choice choose(const SignedSurface& surface, const GridShape& shape, const CellRange& block, double width_m) {
  Choice choice;
  if (is_far(surface, sphere_around(shape, block), width_m, choice.far_m)) {
    return choice;
  }
  choice.far_m = width_m;
  const Sphere sphere = sphere_around(shape, block);
  const bool near = surface.tree().closest_point(sphere.centre, std::max(0.0, width_m - sphere.radius_m)).has_value();
  unsigned bit = 0;
  for_each_in(block.from, block.to, [&](std::size_t i, std::size_t j, std::size_t k) {
    const bool far = !near && is_far_cell(surface, shape, {{i, j, k}, {i + 1, j + 1, k + 1}}, width_m);
    choice.kept |= std::uint64_t{!far} << bit++;
  });
  return choice;
}

}  // namespace

NarrowBand narrow_band(const SignedSurface& surface, const GridShape& shape, double width_m,
                       [[maybe_unused]] int threads) {
  constexpr std::size_t edge = NarrowBand::block_edge;
  static_assert(edge * edge * edge <= 64, "a block's cells fit into one word");
  NarrowBand band(shape, width_m);
  const GridIndex::Coordinates cells = shape.cell_grid().count;
  std::vector<CellRange> blocks;
  for_each_in({0, 0, 0}, band.blocks().count, [&](std::size_t i, std::size_t j, std::size_t k) {
    CellRange& block = blocks.emplace_back(CellRange{{edge * i, edge * j, edge * k}, {}});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.to[axis] = std::min(block.from[axis] + edge, cells[axis]);
    }
  });
  std::vector<Choice> choices(blocks.size());
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads)
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    choices[b] = choose(surface, shape, blocks[b], width_m);
  }
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    unsigned bit = 0;
    for_each_in(blocks[b].from, blocks[b].to, [&](std::size_t i, std::size_t j, std::size_t k) {
      if (((choices[b].kept >> bit++) & 1U) != 0) {
        band.keep(shape.cell(i, j, k));
      }
    });
    band.set_far_m(blocks[b].from[0], blocks[b].from[1], blocks[b].from[2], choices[b].far_m);
  }
  band.index_records(shape);
  return band;
}

}  // namespace musclebench

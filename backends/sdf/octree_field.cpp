#include "backends/sdf/octree_field.hpp"

#include <algorithm>
#include <utility>

namespace musclebench {

OctreeField::OctreeField(const OctreeShape& shape, const OctreeQuality& quality, std::vector<std::uint32_t> entries,
                         std::vector<float> coefficients)
    : m_shape(shape),
      m_quality(quality),
      m_roots(shape.roots[0], shape.roots[1], shape.roots[2]),
      m_roots_per_m(1 / shape.root_edge_m),
      m_entries(std::move(entries)),
      m_coefficients(std::move(coefficients)) {
  m_leaves = static_cast<std::size_t>(std::count_if(m_entries.begin(), m_entries.end(), [](std::uint32_t entry) {
    return kind_of(entry) == Kind::quadratic || kind_of(entry) == Kind::cubic;
  }));
}

std::optional<OctreeField::Leaf> OctreeField::find(const Vec3& point) const {
  Vec3 at = (point - m_shape.lower_m) * m_roots_per_m;
  std::array<std::size_t, 3> root{};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (!(at[axis] >= 0 && at[axis] <= m_roots[axis])) {
      return std::nullopt;
    }
    const double first = std::min(static_cast<double>(static_cast<std::int32_t>(at[axis])), m_roots[axis] - 1);
    root[static_cast<std::size_t>(axis)] = static_cast<std::size_t>(first);
    at[axis] -= first;
  }
  std::uint32_t found = m_entries[m_shape.root(root[0], root[1], root[2])];
  double half_edge_m = 0.5 * m_shape.root_edge_m;
  while (kind_of(found) == Kind::split) {
    std::size_t child = 0;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      at[axis] *= 2;
      const bool upper = at[axis] >= 1;
      child |= static_cast<std::size_t>(upper) << axis;
      at[axis] -= static_cast<double>(upper);
    }
    half_edge_m *= 0.5;
    found = m_entries[place_of(found) + child];
  }
  return Leaf{kind_of(found), m_coefficients.data() + place_of(found), 2 * at - Vec3::Ones(), half_edge_m};
}

OctreeField::Sample OctreeField::sample(const Leaf& leaf) {
  Sample result;
  if (leaf.kind == Kind::outside) {
    // The distance changes by no more than the way from the centre.
    const double way = leaf.at.norm();
    result.value_m = *leaf.coefficients - leaf.half_edge_m * way;
    result.gradient = way > 0 ? Vec3(-leaf.at / way) : Vec3::Zero();
    return result;
  }
  result.value_m = leaf.kind == Kind::cubic ? evaluate_polynomial<true>(leaf.coefficients, leaf.at, result.gradient)
                                            : evaluate_polynomial<false>(leaf.coefficients, leaf.at, result.gradient);
  result.gradient /= leaf.half_edge_m;
  return result;
}

std::optional<double> OctreeField::value(const Vec3& point) const {
  const std::optional<Leaf> leaf = find(point);
  return leaf ? std::optional<double>(sample(*leaf).value_m) : std::nullopt;
}

std::optional<OctreeField::Sample> OctreeField::sample(const Vec3& point) const {
  const std::optional<Leaf> leaf = find(point);
  return leaf ? std::optional<Sample>(sample(*leaf)) : std::nullopt;
}

std::optional<OctreeField::Sample> OctreeField::sample_inside(const Vec3& point) const {
  const std::optional<Leaf> leaf = find(point);
  if (!leaf || leaf->kind == Kind::outside) {
    return std::nullopt;
  }
  const Sample result = sample(*leaf);
  return result.value_m < 0 ? std::optional<Sample>(result) : std::nullopt;
}

double OctreeField::clearance_m(const Vec3& point) const {
  const std::optional<Leaf> leaf = find(point);
  if (!leaf) {
    const Vec3 nearest = point.cwiseMax(m_shape.lower_m).cwiseMin(m_shape.upper_m());
    const double away = (point - nearest).norm();
    return away > 0 ? away * (1 - 1e-9) : 0;
  }
  return std::max(0.0, (distance_at_least_m(point, *leaf) - m_quality.negative_reach_m) * (1 - 1e-9));
}

double OctreeField::distance_at_least_m(const Vec3& point, const Leaf& leaf) const {
  const Sample here = sample(leaf);
  if (leaf.kind == Kind::outside) {
    return here.value_m;
  }
  // Between samples little is proven. But the distance of a sample farther out, along the gradient, less the way there
  // is nearly the distance here.
  const double steepness = here.gradient.norm();
  const Vec3 farther = point + (2 * leaf.half_edge_m / steepness) * here.gradient;
  const Vec3 beyond = farther.cwiseMax(m_shape.lower_m).cwiseMin(m_shape.upper_m());
  std::optional<Leaf> there = find(beyond);
  if (!there) {
    return 0;
  }
  const Vec3 sampled = there->kind == Kind::outside ? Vec3::Zero() : Vec3(there->at.array().round());
  const double way_m = (beyond + there->half_edge_m * (sampled - there->at) - point).norm();
  there->at = sampled;
  return sample(*there).value_m - way_m - (there->kind == Kind::outside ? 0 : m_quality.excess_m);
}

}  // namespace musclebench

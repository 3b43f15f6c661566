#include "backends/sdf/octree_cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace musclebench {

namespace {

/// Beyond the near places the allowed error grows by this share of the way: a response to such a depth only has to
/// lead out.
constexpr double relaxation = 0.1;

/// A cell that holds the surface is no larger than this, over what counts as near: a feature could hide between its
/// samples.
constexpr double coarsest_near = 4;

/// Where the quadratic polynomial is off by no more than this share of what is allowed, octants need not be looked at.
constexpr double sure_share = 0.35;

/// What a place counts that is off by `error` times what is allowed. Smooth, so that leaves whose samples are all just
/// right, and whose other places may not be, come before those that are right by far; and no more than about five
/// places that are just right, because where the distance has a kink the last error can't be had.
double wrongness(double error) {
  const double square = std::min(error * error, 2.25);
  return square * square;
}

const double half_diagonal = std::sqrt(3.0) * (1 + 1e-9);

/// Along one axis of the grid that the lattices of eight children share.
constexpr std::size_t fine = 5;
constexpr std::size_t fine_place(std::size_t i, std::size_t j, std::size_t k) { return (i * fine + j) * fine + k; }

bool bit(std::size_t number, std::size_t place) { return (number >> place & 1U) != 0; }

Vec3 octant_centre(const OctreeCell& cell, std::size_t octant) {
  return cell.centre_m + cell.half_edge_m * sample_place(lattice_samples + octant);
}

/// Goes from place to place. The closest triangle of one starts the next search, and a place that is farther from the
/// surface than from a signed place lies on the same side.
class DistanceWalk {
 public:
  explicit DistanceWalk(const SignedSurface& surface) : m_surface(surface) {}

  void stand_at(const Vec3& point, const DistanceSample& known) {
    m_point = point;
    m_last = known;
  }

  const DistanceSample& go_to(const Vec3& point) {
    const bool first = m_last.triangle < 0;
    SignedPoint place;
    place.closest = first ? m_surface.tree().closest_point(point).value()
                          : m_surface.tree().closest_point_from(point, m_last.triangle);
    const double step = (point - m_point).norm() * (1 + 1e-9);
    const bool unsure = first || std::max(place.closest.distance_m, std::abs(m_last.value_m)) <= step;
    place.inside = unsure ? m_surface.is_inside(point, place.closest) : m_last.value_m < 0;
    const Vec3 gradient = m_surface.outward(point, place);
    stand_at(point,
             {place.signed_distance_m(),
              {static_cast<float>(gradient[0]), static_cast<float>(gradient[1]), static_cast<float>(gradient[2])},
              place.closest.triangle});
    return m_last;
  }

 private:
  const SignedSurface& m_surface;
  Vec3 m_point = Vec3::Zero();
  DistanceSample m_last;
};

/// The samples of eight sisters: on a grid that their lattices share, some of them known from the parent.
class SisterSamples {
 public:
  SisterSamples(const OctreeCell& parent, const SignedSurface& surface) : m_parent(parent), m_walk(surface) {
    const CellSamples& known = parent.leaf->samples;
    for (std::size_t s = 0; s < lattice_samples; ++s) {
      m_grid[fine_place(2 * (s / 9), 2 * (s / 3 % 3), 2 * (s % 3))] = known[s];
    }
    m_walk.stand_at(parent.centre_m, known[lattice_samples / 2]);
    for (std::size_t octant = 0; octant < 8; ++octant) {
      const DistanceSample& centre = known[lattice_samples + octant];
      m_grid[centre_in_grid(octant)] = centre.triangle >= 0 ? centre : m_walk.go_to(octant_centre(parent, octant));
    }
  }

  [[nodiscard]] double distance_at_centre_m(std::size_t octant) const { return m_grid[centre_in_grid(octant)].value_m; }

  /// Asks what the children that are marked lack of the grid: there and back along its rows.
  void ask(const std::array<bool, 8>& wanted) {
    for (std::size_t row = 0; row < fine * fine; ++row) {
      const std::size_t i = row / fine;
      const std::size_t j = i % 2 == 0 ? row % fine : fine - 1 - row % fine;
      for (std::size_t step = 0; step < fine; ++step) {
        visit(i, j, row % 2 == 0 ? step : fine - 1 - step, wanted);
      }
    }
  }

  void collect_lattice(std::size_t octant, CellSamples& samples) const {
    const std::array<std::size_t, 3> first{bit(octant, 0) ? std::size_t{2} : 0, bit(octant, 1) ? std::size_t{2} : 0,
                                           bit(octant, 2) ? std::size_t{2} : 0};
    for (std::size_t s = 0; s < lattice_samples; ++s) {
      samples[s] = m_grid[fine_place(first[0] + s / 9, first[1] + s / 3 % 3, first[2] + s % 3)];
    }
  }

 private:
  static std::size_t centre_in_grid(std::size_t octant) {
    const auto odd = [&](std::size_t axis) { return bit(octant, axis) ? std::size_t{3} : std::size_t{1}; };
    return fine_place(odd(0), odd(1), odd(2));
  }

  static bool touches(std::size_t octant, std::size_t axis, std::size_t index) {
    return bit(octant, axis) ? index >= 2 : index <= 2;
  }

  void visit(std::size_t i, std::size_t j, std::size_t k, const std::array<bool, 8>& wanted) {
    DistanceSample& sample = m_grid[fine_place(i, j, k)];
    const Vec3 at(static_cast<double>(i) / 2 - 1, static_cast<double>(j) / 2 - 1, static_cast<double>(k) / 2 - 1);
    const Vec3 point = m_parent.centre_m + m_parent.half_edge_m * at;
    if (sample.triangle >= 0) {
      m_walk.stand_at(point, sample);
      return;
    }
    for (std::size_t octant = 0; octant < 8; ++octant) {
      if (wanted[octant] && touches(octant, 0, i) && touches(octant, 1, j) && touches(octant, 2, k)) {
        sample = m_walk.go_to(point);
        return;
      }
    }
  }

  const OctreeCell& m_parent;
  DistanceWalk m_walk;
  std::array<DistanceSample, fine * fine * fine> m_grid;
};

}  // namespace

double OctreeDemand::allowed_m(double distance_m) const {
  return wanted_m + relaxation * std::max(0.0, std::abs(distance_m) - near_m);
}

double OctreeCell::reach_m() const { return half_diagonal * half_edge_m; }

double OctreeCell::wrong_m3() const {
  return leaf == nullptr ? 0 : std::min(leaf->wrong_quadratic_m3, leaf->wrong_cubic_m3);
}

bool OctreeCell::takes_cubic(double threshold_m3) const {
  return leaf->wrong_quadratic_m3 - leaf->wrong_cubic_m3 > 0.5 * threshold_m3;
}

const PolynomialFit& OctreeCell::chosen(double threshold_m3) const {
  return takes_cubic(threshold_m3) ? leaf->cubic : leaf->quadratic;
}

bool OctreeCellMaker::outside(const OctreeCell& cell) const {
  return cell.distance_m - cell.reach_m() >= m_demand.near_m;
}

void OctreeCellMaker::measure(OctreeCell& cell) const {
  m_quadratic.measure(cell.leaf->samples, cell.half_edge_m, cell.leaf->quadratic);
  m_cubic.measure(cell.leaf->samples, cell.half_edge_m, cell.leaf->cubic);
}

void OctreeCellMaker::judge(OctreeCell& cell) const {
  OctreeCell::Leaf& leaf = *cell.leaf;
  leaf.quadratic = m_quadratic.fit(leaf.samples, cell.half_edge_m);
  leaf.cubic = m_cubic.fit(leaf.samples, cell.half_edge_m);
  measure(cell);
  if (hides_features(cell)) {
    leaf.wrong_quadratic_m3 = leaf.wrong_cubic_m3 = std::numeric_limits<double>::infinity();
    return;
  }
  const auto allowed_m = [&](std::size_t s) { return m_demand.allowed_m(leaf.samples[s].value_m); };
  bool sure = true;
  for (std::size_t s = 0; s < lattice_samples; ++s) {
    sure = sure && leaf.quadratic.error_m[s] <= sure_share * allowed_m(s);
  }
  if (!sure) {
    DistanceWalk walk(m_surface);
    walk.stand_at(cell.centre_m, leaf.samples[lattice_samples / 2]);
    for (std::size_t s = lattice_samples; s < cell_samples; ++s) {
      leaf.samples[s] = walk.go_to(cell.centre_m + cell.half_edge_m * sample_place(s));
    }
    measure(cell);
  }
  const std::size_t known = known_samples(leaf.samples);
  const double edge_m = 2 * cell.half_edge_m;
  const double volume_m3 = edge_m * edge_m * edge_m / static_cast<double>(known);
  for (std::size_t s = 0; s < known; ++s) {
    leaf.wrong_quadratic_m3 += volume_m3 * wrongness(leaf.quadratic.error_m[s] / allowed_m(s));
    leaf.wrong_cubic_m3 += volume_m3 * wrongness(leaf.cubic.error_m[s] / allowed_m(s));
  }
}

bool OctreeCellMaker::hides_features(const OctreeCell& cell) const {
  return std::abs(cell.distance_m) <= cell.reach_m() && 2 * cell.half_edge_m > coarsest_near * m_demand.near_m;
}

OctreeCell OctreeCellMaker::root(const Vec3& centre_m, double half_edge_m) const {
  OctreeCell cell;
  cell.centre_m = centre_m;
  cell.half_edge_m = half_edge_m;
  DistanceWalk walk(m_surface);
  const DistanceSample centre = walk.go_to(centre_m);
  cell.distance_m = centre.value_m;
  if (!outside(cell)) {
    cell.leaf = std::make_unique<OctreeCell::Leaf>();
    for (std::size_t s = 0; s < lattice_samples; ++s) {
      cell.leaf->samples[s] = walk.go_to(centre_m + half_edge_m * sample_place(s));
    }
    judge(cell);
  }
  return cell;
}

std::array<OctreeCell, 8> OctreeCellMaker::split(const OctreeCell& parent) const {
  std::array<OctreeCell, 8> children;
  std::array<bool, 8> wanted{};
  SisterSamples samples(parent, m_surface);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    OctreeCell& child = children[octant];
    child.centre_m = octant_centre(parent, octant);
    child.half_edge_m = 0.5 * parent.half_edge_m;
    child.distance_m = samples.distance_at_centre_m(octant);
    wanted[octant] = !outside(child);
  }
  samples.ask(wanted);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    if (wanted[octant]) {
      children[octant].leaf = std::make_unique<OctreeCell::Leaf>();
      samples.collect_lattice(octant, children[octant].leaf->samples);
      judge(children[octant]);
    }
  }
  return children;
}

}  // namespace musclebench

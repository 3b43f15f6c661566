#include "backends/sdf/octree_cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "backends/sdf/packet_search.hpp"

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

/// A place that is known.
struct KnownPlace {
  Vec3 point = Vec3::Zero();
  DistanceSample sample;
};

/// Places that lie close together, asked in one walk through the tree. A known place near them starts the search, and
/// tells the side of all that are farther from the surface than from it.
class Packet {
 public:
  Packet(const SignedSurface& surface, const KnownPlace& known) : m_surface(surface), m_known(known) {}

  /// Not more than PacketSearch::most_points.
  void add(const Vec3& point, DistanceSample& answer) {
    m_points[m_count] = point;
    m_answers[m_count++] = &answer;
  }
  [[nodiscard]] bool full() const { return m_count == PacketSearch::most_points; }

  void ask() {
    if (m_count == 0) {
      return;
    }
    std::array<ClosestPoint, PacketSearch::most_points> closest;
    PacketSearch(m_surface.tree()).closest_points({m_points.data(), m_count}, m_known.sample.triangle, closest);
    for (std::size_t n = 0; n < m_count; ++n) {
      const double step = (m_points[n] - m_known.point).norm() * (1 + 1e-9);
      const bool unsure = std::max(closest[n].distance_m, std::abs(m_known.sample.value_m)) <= step;
      const bool inside = unsure ? m_surface.is_inside(m_points[n], closest[n]) : m_known.sample.value_m < 0;
      *m_answers[n] = sample_of(m_surface, m_points[n], {closest[n], inside});
    }
    m_count = 0;
  }

  [[nodiscard]] static DistanceSample sample_of(const SignedSurface& surface, const Vec3& point,
                                                const SignedPoint& place) {
    const Vec3 gradient = surface.outward(point, place);
    return {place.signed_distance_m(),
            {static_cast<float>(gradient[0]), static_cast<float>(gradient[1]), static_cast<float>(gradient[2])},
            place.closest.triangle};
  }

 private:
  const SignedSurface& m_surface;
  const KnownPlace& m_known;
  std::array<Vec3, PacketSearch::most_points> m_points;
  std::array<DistanceSample*, PacketSearch::most_points> m_answers{};
  std::size_t m_count = 0;
};

/// Asks for samples of a cell whose middle is known.
void ask_samples(const SignedSurface& surface, OctreeCell& cell, std::size_t from, std::size_t to) {
  const KnownPlace middle{cell.centre_m, cell.leaf->samples[lattice_samples / 2]};
  Packet packet(surface, middle);
  for (std::size_t s = from; s < to; ++s) {
    if (cell.leaf->samples[s].triangle < 0) {
      packet.add(cell.centre_m + cell.half_edge_m * sample_place(s), cell.leaf->samples[s]);
    }
    if (packet.full()) {
      packet.ask();
    }
  }
  packet.ask();
}

/// The samples of eight sisters: on a grid that their lattices share, some of them known from the parent.
class SisterSamples {
 public:
  /// The middles of the parent's octants are known, too.
  SisterSamples(const OctreeCell& parent, const SignedSurface& surface) : m_parent(parent), m_surface(surface) {
    const CellSamples& known = parent.leaf->samples;
    for (std::size_t s = 0; s < lattice_samples; ++s) {
      m_grid[fine_place(2 * (s / 9), 2 * (s / 3 % 3), 2 * (s % 3))] = known[s];
    }
    for (std::size_t octant = 0; octant < 8; ++octant) {
      const auto odd = [&](std::size_t axis) { return bit(octant, axis) ? std::size_t{3} : std::size_t{1}; };
      m_grid[fine_place(odd(0), odd(1), odd(2))] = known[lattice_samples + octant];
    }
  }

  /// Asks what the children that are marked lack of the grid: two by two by two, from a place that is known.
  void ask(const std::array<bool, 8>& wanted) {
    for (std::size_t i = 0; i < fine; i += 2) {
      for (std::size_t j = 0; j < fine; j += 2) {
        for (std::size_t k = 0; k < fine; k += 2) {
          ask_block({i, j, k}, wanted);
        }
      }
    }
  }

  void collect(std::size_t octant, CellSamples& samples) const {
    const std::array<std::size_t, 3> first{bit(octant, 0) ? std::size_t{2} : 0, bit(octant, 1) ? std::size_t{2} : 0,
                                           bit(octant, 2) ? std::size_t{2} : 0};
    for (std::size_t s = 0; s < lattice_samples; ++s) {
      samples[s] = m_grid[fine_place(first[0] + s / 9, first[1] + s / 3 % 3, first[2] + s % 3)];
    }
  }

 private:
  using Index = std::array<std::size_t, 3>;

  static bool touches(std::size_t octant, const Index& at) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (bit(octant, axis) ? at[axis] < 2 : at[axis] > 2) {
        return false;
      }
    }
    return true;
  }
  static bool is_wanted(const Index& at, const std::array<bool, 8>& wanted) {
    for (std::size_t octant = 0; octant < 8; ++octant) {
      if (wanted[octant] && touches(octant, at)) {
        return true;
      }
    }
    return false;
  }

  [[nodiscard]] Vec3 point(const Index& at) const {
    const Vec3 index(static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2]));
    return m_parent.centre_m + m_parent.half_edge_m * (0.5 * index - Vec3::Ones());
  }

  void ask_block(const Index& first, const std::array<bool, 8>& wanted) {
    const KnownPlace known{point(first), m_grid[fine_place(first[0], first[1], first[2])]};
    Packet packet(m_surface, known);
    for (std::size_t n = 1; n < 8; ++n) {
      const Index at{first[0] + (n & 1U), first[1] + (n >> 1 & 1U), first[2] + (n >> 2)};
      if (std::max({at[0], at[1], at[2]}) < fine && is_wanted(at, wanted)) {
        DistanceSample& sample = m_grid[fine_place(at[0], at[1], at[2])];
        if (sample.triangle < 0) {
          packet.add(point(at), sample);
        }
      }
    }
    packet.ask();
  }

  const OctreeCell& m_parent;
  const SignedSurface& m_surface;
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
    ask_samples(m_surface, cell, lattice_samples, cell_samples);
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
  const SignedPoint place = m_surface.locate(centre_m);
  cell.distance_m = place.signed_distance_m();
  if (!outside(cell)) {
    cell.leaf = std::make_unique<OctreeCell::Leaf>();
    cell.leaf->samples[lattice_samples / 2] = Packet::sample_of(m_surface, centre_m, place);
    ask_samples(m_surface, cell, 0, lattice_samples);
    judge(cell);
  }
  return cell;
}

std::array<OctreeCell, 8> OctreeCellMaker::split(OctreeCell& parent) const {
  std::array<OctreeCell, 8> children;
  std::array<bool, 8> wanted{};
  ask_samples(m_surface, parent, lattice_samples, cell_samples);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    OctreeCell& child = children[octant];
    child.centre_m = octant_centre(parent, octant);
    child.half_edge_m = 0.5 * parent.half_edge_m;
    child.distance_m = parent.leaf->samples[lattice_samples + octant].value_m;
    wanted[octant] = !outside(child);
  }
  SisterSamples samples(parent, m_surface);
  samples.ask(wanted);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    if (wanted[octant]) {
      children[octant].leaf = std::make_unique<OctreeCell::Leaf>();
      samples.collect(octant, children[octant].leaf->samples);
      judge(children[octant]);
    }
  }
  return children;
}

}  // namespace musclebench

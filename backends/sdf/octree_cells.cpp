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

DistanceSample sample_of(const SignedSurface& surface, const Vec3& point, const SignedPoint& place) {
  const Vec3 gradient = surface.outward(point, place);
  return {place.signed_distance_m(),
          {static_cast<float>(gradient[0]), static_cast<float>(gradient[1]), static_cast<float>(gradient[2])},
          place.closest.triangle};
}

/// Asks for samples of a cell whose middle is known.
void ask_samples(SampleBlock& block, OctreeCell& cell, std::size_t from, std::size_t to) {
  block.start_packet({cell.centre_m, cell.leaf->samples[lattice_samples / 2]});
  for (std::size_t s = from; s < to; ++s) {
    if (cell.leaf->samples[s].triangle < 0) {
      block.add(cell.centre_m + cell.half_edge_m * sample_place(s), cell.leaf->samples[s]);
    }
  }
  block.ask();
}

/// The samples of eight sisters: on a grid that their lattices share, some of them known from the parent.
class SisterSamples {
 public:
  /// The middles of the parent's octants are known, too.
  explicit SisterSamples(const OctreeCell& parent) : m_parent(parent) {
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
  void ask(const std::array<bool, 8>& wanted, SampleBlock& block) {
    for (std::size_t i = 0; i < fine; i += 2) {
      for (std::size_t j = 0; j < fine; j += 2) {
        for (std::size_t k = 0; k < fine; k += 2) {
          add_packet({i, j, k}, wanted, block);
        }
      }
    }
    block.ask();
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

  void add_packet(const Index& first, const std::array<bool, 8>& wanted, SampleBlock& block) {
    bool started = false;
    for (std::size_t n = 1; n < 8; ++n) {
      const Index at{first[0] + (n & 1U), first[1] + (n >> 1 & 1U), first[2] + (n >> 2)};
      if (std::max({at[0], at[1], at[2]}) >= fine || !is_wanted(at, wanted)) {
        continue;
      }
      DistanceSample& sample = m_grid[fine_place(at[0], at[1], at[2])];
      if (sample.triangle < 0) {
        if (!started) {
          block.start_packet({point(first), m_grid[fine_place(first[0], first[1], first[2])]});
          started = true;
        }
        block.add(point(at), sample);
      }
    }
  }

  const OctreeCell& m_parent;
  std::array<DistanceSample, fine * fine * fine> m_grid;
};

}  // namespace

void SampleBlock::start_packet(const KnownPlace& known) {
  m_known[m_count] = known;
  m_packets[m_count++].count = 0;
}

void SampleBlock::add(const Vec3& point, DistanceSample& answer) {
  if (m_packets[m_count - 1].count == PointPacket::capacity) {
    start_packet(m_known[m_count - 1]);
  }
  PointPacket& packet = m_packets[m_count - 1];
  m_answers[m_count - 1][packet.count] = &answer;
  packet.add(point);
}

void SampleBlock::ask() {
  if (m_count == 0) {
    return;
  }
  m_search.closest_points({m_packets.data(), m_count}, m_known[0].sample.triangle);
  for (std::size_t p = 0; p < m_count; ++p) {
    const KnownPlace& known = m_known[p];
    for (std::size_t n = 0; n < m_packets[p].count; ++n) {
      const Vec3& point = m_packets[p].point[n];
      const ClosestPoint& closest = m_packets[p].closest[n];
      const double step = (point - known.point).norm() * (1 + 1e-9);
      const bool unsure = !m_surface.closed() || std::max(closest.distance_m, std::abs(known.sample.value_m)) <= step;
      const bool inside = unsure ? m_surface.is_inside(point, closest) : known.sample.value_m < 0;
      *m_answers[p][n] = sample_of(m_surface, point, {closest, inside});
    }
  }
  m_count = 0;
}

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

void OctreeCellMaker::judge(OctreeCell& cell, SampleBlock& block) const {
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
    ask_samples(block, cell, lattice_samples, cell_samples);
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

OctreeCell OctreeCellMaker::root(const Vec3& centre_m, double half_edge_m, SampleBlock& block) const {
  OctreeCell cell;
  cell.centre_m = centre_m;
  cell.half_edge_m = half_edge_m;
  const SignedPoint place = m_surface.locate(centre_m);
  cell.distance_m = place.signed_distance_m();
  if (!outside(cell)) {
    cell.leaf = std::make_unique<OctreeCell::Leaf>();
    cell.leaf->samples[lattice_samples / 2] = sample_of(m_surface, centre_m, place);
    ask_samples(block, cell, 0, lattice_samples);
    judge(cell, block);
  }
  return cell;
}

std::array<OctreeCell, 8> OctreeCellMaker::split(OctreeCell& parent, SampleBlock& block) const {
  std::array<OctreeCell, 8> children;
  std::array<bool, 8> wanted{};
  ask_samples(block, parent, lattice_samples, cell_samples);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    OctreeCell& child = children[octant];
    child.centre_m = octant_centre(parent, octant);
    child.half_edge_m = 0.5 * parent.half_edge_m;
    child.distance_m = parent.leaf->samples[lattice_samples + octant].value_m;
    wanted[octant] = !outside(child);
  }
  SisterSamples samples(parent);
  samples.ask(wanted, block);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    if (wanted[octant]) {
      children[octant].leaf = std::make_unique<OctreeCell::Leaf>();
      samples.collect(octant, children[octant].leaf->samples);
      judge(children[octant], block);
    }
  }
  return children;
}

}  // namespace musclebench

#include "backends/sdf/build/octree_cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/grid_index.hpp"
#include "core/base/prefetch.hpp"

namespace musclebench {

namespace {

/// Beyond the near points the allowed error grows by this share of the distance: a correction of such a depth only
/// needs the right direction.
constexpr double relaxation = 0.1;

/// A cell that holds the surface is no larger than this, over what counts as near: a feature could hide between its
/// samples.
constexpr double coarsest_near = 4;

/// A cubic polynomial is taken where it lowers the error indicator by this share of the splitting threshold. Its ten
/// more coefficients need no more samples; on scanned bones a smaller share builds faster, and 0.2 gives the smallest
/// fields.
constexpr double worth_a_cubic = 0.1;

/// Where the error of the quadratic polynomial is at most this share of the allowed one, octants need not be sampled.
constexpr float sure_share = 0.8F;

/// The indicator of a sample whose error is `error` times the allowed one. Smooth, so that leaves whose samples are all
/// just within it, while other points may not be, come before those that are far within; capped at about five samples
/// that are just within, because where the distance has a kink the last error can't be removed.
float sample_indicator(float error) {
  const float square = std::min(error * error, 2.25F);
  return square * square;
}

double error_indicator_m3(const OctreeCell& cell, const CellErrors& errors) {
  float wrong = 0;
  for (const float error : errors) {
    wrong += sample_indicator(error);
  }
  const double edge_m = 2 * cell.half_edge_m;
  const double volume_m3 = edge_m * edge_m * edge_m / static_cast<double>(known_samples(cell.leaf->samples));
  return volume_m3 * wrong;
}

const double half_diagonal = std::sqrt(3.0) * (1 + 1e-9);

/// Along one axis of the grid that the lattices of eight children share.
constexpr std::size_t fine = 5;
constexpr std::size_t fine_index(std::size_t i, std::size_t j, std::size_t k) { return (i * fine + j) * fine + k; }

bool bit(std::size_t number, std::size_t index) { return (number >> index & 1U) != 0; }

Vec3 octant_centre(const OctreeCell& cell, std::size_t octant) {
  return cell.centre_m + cell.half_edge_m * sample_position(lattice_samples + octant);
}

DistanceSample sample_of(const SignedSurface& surface, const Vec3& point, const SignedPoint& located) {
  const Vec3 gradient = surface.outward(point, located);
  return {located.signed_distance_m(),
          {static_cast<float>(gradient[0]), static_cast<float>(gradient[1]), static_cast<float>(gradient[2])},
          located.closest.triangle};
}

KnownPoint known_point(const Vec3& point, const DistanceSample& sample) {
  return {point, sample.value_m, sample.triangle};
}

void fetch_samples(const OctreeCell& cell) {
  if (cell.leaf != nullptr) {
    prefetch_bytes(cell.leaf.get(), sizeof(CellSamples));
  }
}

/// Adds the samples that are not known yet of a cell, whose middle is known.
void add_samples(OctreeCell& cell, std::size_t from, std::size_t to, SampleBlock& block) {
  const KnownPoint middle = known_point(cell.centre_m, cell.leaf->samples[lattice_samples / 2]);
  for (std::size_t s = from; s < to; ++s) {
    if (cell.leaf->samples[s].triangle < 0) {
      block.add(cell.centre_m + cell.half_edge_m * sample_position(s), middle, cell.leaf->samples[s]);
    }
  }
}

/// The samples of eight siblings on a grid that their lattices share, some of them known from the parent or from the
/// children of its neighbours.
class SiblingSamples {
 public:
  /// The middles of the parent's octants are known, too.
  SiblingSamples(const OctreeCell& parent, const NeighbourChildren& neighbours) : m_parent(parent) {
    const CellSamples& known = parent.leaf->samples;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < fine; ++i) {
        m_coordinates[axis][i] =
            parent.centre_m[static_cast<Eigen::Index>(axis)] + parent.half_edge_m * (0.5 * static_cast<double>(i) - 1);
      }
    }
    for (std::size_t s = 0; s < lattice_samples; ++s) {
      m_grid[fine_index(2 * (s / 9), 2 * (s / 3 % 3), 2 * (s % 3))] = known[s];
    }
    for (std::size_t octant = 0; octant < 8; ++octant) {
      const auto odd = [&](std::size_t axis) { return bit(octant, axis) ? std::size_t{3} : std::size_t{1}; };
      m_grid[fine_index(odd(0), odd(1), odd(2))] = known[lattice_samples + octant];
    }
    for (std::size_t face = 0; face < neighbours.size(); ++face) {
      if (neighbours[face] != nullptr) {
        take_face(neighbours[face], face / 2, face % 2 != 0);
      }
    }
  }

  /// Queries the grid points that the wanted children, one bit each, lack, in groups of eight neighbours.
  void query(unsigned wanted, SampleBlock& block) {
    constexpr std::size_t groups = (fine + 1) / 2;
    for (std::size_t i = 0; i < groups; ++i) {
      for (std::size_t row = 0; row < groups; ++row) {
        const std::size_t j = i % 2 == 0 ? row : groups - 1 - row;
        for (std::size_t column = 0; column < groups; ++column) {
          const std::size_t k = (i + row) % 2 == 0 ? column : groups - 1 - column;
          add_group({2 * i, 2 * j, 2 * k}, wanted, block);
        }
      }
    }
    block.query();
  }

  void collect(std::size_t octant, CellSamples& samples) const {
    const std::array<std::size_t, 3> first{bit(octant, 0) ? std::size_t{2} : 0, bit(octant, 1) ? std::size_t{2} : 0,
                                           bit(octant, 2) ? std::size_t{2} : 0};
    for (std::size_t s = 0; s < lattice_samples; ++s) {
      samples[s] = m_grid[fine_index(first[0] + s / 9, first[1] + s / 3 % 3, first[2] + s % 3)];
    }
  }

 private:
  using Index = GridIndex::Coordinates;

  /// One bit each: the children whose lattice holds this point. In the middle of an axis both halves do.
  static unsigned children_at(const Index& at) {
    constexpr std::array<unsigned, 3> lower_half{0x55, 0x33, 0x0F};
    unsigned children = 0xFF;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      children &= (at[axis] <= 2 ? lower_half[axis] : 0U) | (at[axis] >= 2 ? ~lower_half[axis] : 0U);
    }
    return children;
  }

  [[nodiscard]] Vec3 point(const Index& at) const {
    return {m_coordinates[0][at[0]], m_coordinates[1][at[1]], m_coordinates[2][at[2]]};
  }

  /// Takes over the samples on the common face.
  void take_face(const OctreeCell* neighbour_children, std::size_t axis, bool upper) {
    const std::size_t b = (axis + 1) % 3;
    const std::size_t c = (axis + 2) % 3;
    for (std::size_t index = 0; index < fine * fine; ++index) {
      Index at;
      at[axis] = upper ? fine - 1 : 0;
      at[b] = index / fine;
      at[c] = index % fine;
      DistanceSample& sample = m_grid[fine_index(at[0], at[1], at[2])];
      if (sample.triangle >= 0) {
        continue;
      }
      at[axis] = fine - 1 - at[axis];
      const std::size_t octant = (at[0] >= 2 ? 1U : 0U) + (at[1] >= 2 ? 2U : 0U) + (at[2] >= 2 ? 4U : 0U);
      if (const auto& leaf = neighbour_children[octant].leaf) {
        const auto in_child = [&](std::size_t a) { return at[a] >= 2 ? at[a] - 2 : at[a]; };
        sample = leaf->samples[9 * in_child(0) + 3 * in_child(1) + in_child(2)];
      }
    }
  }

  void add_group(const Index& first, unsigned wanted, SampleBlock& block) {
    const DistanceSample& nearest = m_grid[fine_index(first[0], first[1], first[2])];
    const KnownPoint known = nearest.triangle >= 0
                                 ? known_point(point(first), nearest)
                                 : known_point(m_parent.centre_m, m_parent.leaf->samples[lattice_samples / 2]);
    for (std::size_t n = 0; n < 8; ++n) {
      const Index at{first[0] + (n & 1U), first[1] + (n >> 1 & 1U), first[2] + (n >> 2)};
      if (std::max({at[0], at[1], at[2]}) >= fine || (children_at(at) & wanted) == 0) {
        continue;
      }
      DistanceSample& sample = m_grid[fine_index(at[0], at[1], at[2])];
      if (sample.triangle < 0) {
        block.add(point(at), known, sample);
      }
    }
  }

  const OctreeCell& m_parent;
  std::array<std::array<double, fine>, 3> m_coordinates;  ///< of the grid's planes, by axis
  std::array<DistanceSample, fine * fine * fine> m_grid;
};

}  // namespace

void SampleBlock::add(const Vec3& point, const KnownPoint& known, DistanceSample& answer) {
  if (m_count == 0 || m_batches[m_count - 1].count == PointBatch::capacity) {
    m_batches[m_count++].count = 0;
  }
  PointBatch& batch = m_batches[m_count - 1];
  m_queries[m_count - 1][batch.count] = {known, &answer};
  batch.add(point);
}

void SampleBlock::begin(const OctreeCell& cell) {
  const Vec3 half = Vec3::Constant(cell.half_edge_m);
  m_search.begin({cell.centre_m - half, cell.centre_m + half}, cell.leaf->samples[lattice_samples / 2].triangle);
}

void SampleBlock::query() {
  if (m_count == 0) {
    return;
  }
  m_search.closest_points({m_batches.data(), m_count});
  for (std::size_t p = 0; p < m_count; ++p) {
    for (std::size_t n = 0; n < m_batches[p].count; ++n) {
      const auto& [known, answer] = m_queries[p][n];
      const Vec3& point = m_batches[p].point[n];
      const ClosestPoint& closest = m_batches[p].closest[n];
      const double step = (point - known.point).norm() * (1 + 1e-9);
      const bool unsure = !m_surface.closed() || std::max(closest.distance_m, std::abs(known.distance_m)) <= step;
      const bool inside = unsure ? m_surface.is_inside(point, closest) : known.distance_m < 0;
      *answer = sample_of(m_surface, point, {closest, inside});
    }
  }
  m_count = 0;
}

double ErrorTarget::allowed_m(double distance_m) const {
  return wanted_m + relaxation * std::max(0.0, std::abs(distance_m) - near_m);
}

double OctreeCell::reach_m() const { return half_diagonal * half_edge_m; }

double OctreeCell::indicator_m3() const {
  return leaf == nullptr ? 0 : std::min(quadratic_indicator_m3, cubic_indicator_m3);
}

bool OctreeCell::lacks_cubic(double threshold_m3) const {
  return leaf != nullptr && !has_cubic && quadratic_indicator_m3 > worth_a_cubic * threshold_m3;
}

bool OctreeCell::takes_cubic(double threshold_m3) const {
  return quadratic_indicator_m3 - cubic_indicator_m3 > worth_a_cubic * threshold_m3;
}

const PolynomialFit& OctreeCell::chosen(double threshold_m3) const {
  return takes_cubic(threshold_m3) ? leaf->cubic : leaf->quadratic;
}

bool OctreeCellMaker::outside(const OctreeCell& cell) const {
  return cell.distance_m - cell.reach_m() >= m_target.near_m;
}

CellErrors OctreeCellMaker::fit_quadratic(OctreeCell& cell) const {
  const CellSamples& samples = cell.leaf->samples;
  cell.leaf->quadratic = m_quadratic.fit(samples, cell.half_edge_m);
  CellErrors errors = m_quadratic.measure(samples, cell.half_edge_m, cell.leaf->quadratic);
  divide_by_allowed(samples, errors);
  return errors;
}

void OctreeCellMaker::fit_cubic(OctreeCell& cell) const {
  const CellSamples& samples = cell.leaf->samples;
  cell.leaf->cubic = m_cubic.fit(samples, cell.half_edge_m);
  CellErrors errors = m_cubic.measure(samples, cell.half_edge_m, cell.leaf->cubic);
  divide_by_allowed(samples, errors);
  cell.cubic_indicator_m3 = error_indicator_m3(cell, errors);
  cell.has_cubic = true;
}

void OctreeCellMaker::divide_by_allowed(const CellSamples& samples, CellErrors& errors) const {
  for (std::size_t s = 0; s < cell_samples; ++s) {
    errors[s] *= static_cast<float>(1 / m_target.allowed_m(samples[s].value_m));
  }
}

bool OctreeCellMaker::is_sure(const OctreeCell& cell, const CellErrors& quadratic) const {
  // The bounds of the largest cells are those of the whole field, and these cells are few.
  return !is_large(cell) &&
         std::all_of(quadratic.begin(), quadratic.end(), [](float error) { return error <= sure_share; });
}

/// Siblings, or one root.
void OctreeCellMaker::fit(std::span<OctreeCell> cells, SampleBlock& block) const {
  std::array<CellErrors, 8> errors;
  std::array<bool, 8> has_more{};
  for (std::size_t c = 0; c < cells.size(); ++c) {
    OctreeCell& cell = cells[c];
    if (cell.leaf == nullptr) {
      continue;
    }
    errors[c] = fit_quadratic(cell);
    has_more[c] = !is_sure(cell, errors[c]);
    if (has_more[c]) {
      add_samples(cell, lattice_samples, cell_samples, block);
    }
  }
  block.query();
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (has_more[c]) {
      errors[c] = fit_quadratic(cells[c]);
    }
    if (cells[c].leaf != nullptr) {
      cells[c].quadratic_indicator_m3 = cells[c].cubic_indicator_m3 = error_indicator_m3(cells[c], errors[c]);
    }
  }
}

bool OctreeCellMaker::is_large(const OctreeCell& cell) const {
  return 2 * cell.half_edge_m > coarsest_near * m_target.near_m;
}

void fetch(const OctreeCell& parent, const NeighbourChildren& neighbours) {
  fetch_samples(parent);
  for (std::size_t face = 0; face < neighbours.size(); ++face) {
    for (std::size_t octant = 0; octant < 8; ++octant) {
      // Of the neighbour beyond a lower face, the upper children.
      if (neighbours[face] != nullptr && bit(octant, face / 2) == (face % 2 == 0)) {
        fetch_samples(neighbours[face][octant]);
      }
    }
  }
}

OctreeCell OctreeCellMaker::root(const Vec3& centre_m, double half_edge_m, SampleBlock& block) const {
  OctreeCell cell;
  cell.centre_m = centre_m;
  cell.half_edge_m = half_edge_m;
  const SignedPoint located = m_surface.locate(centre_m);
  cell.distance_m = located.signed_distance_m();
  if (!outside(cell)) {
    cell.leaf = std::make_unique<OctreeCell::Leaf>();
    cell.leaf->samples[lattice_samples / 2] = sample_of(m_surface, centre_m, located);
    const bool hides_features = is_large(cell) && std::abs(cell.distance_m) <= cell.reach_m();
    if (hides_features) {  // too large to be sampled reliably: always split, so skip the fit
      cell.quadratic_indicator_m3 = cell.cubic_indicator_m3 = std::numeric_limits<double>::infinity();
      cell.has_cubic = true;
      return cell;
    }
    block.begin(cell);
    add_samples(cell, 0, lattice_samples, block);
    block.query();
    fit({&cell, 1}, block);
  }
  return cell;
}

void OctreeCellMaker::split(OctreeCell& parent, const NeighbourChildren& neighbours, double threshold_m3,
                            std::span<OctreeCell, 8> children, SampleBlock& block) const {
  unsigned wanted = 0;
  block.begin(parent);
  add_samples(parent, lattice_samples, cell_samples, block);
  block.query();
  for (std::size_t octant = 0; octant < 8; ++octant) {
    OctreeCell& child = children[octant];
    child.centre_m = octant_centre(parent, octant);
    child.half_edge_m = 0.5 * parent.half_edge_m;
    child.distance_m = parent.leaf->samples[lattice_samples + octant].value_m;
    wanted |= outside(child) ? 0U : 1U << octant;
  }
  SiblingSamples samples(parent, neighbours);
  samples.query(wanted, block);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    if (bit(wanted, octant)) {
      children[octant].leaf = std::make_unique<OctreeCell::Leaf>();
      samples.collect(octant, children[octant].leaf->samples);
    }
  }
  fit(children, block);
  for (OctreeCell& child : children) {
    if (child.lacks_cubic(threshold_m3)) {
      fit_cubic(child);
    }
  }
}

}  // namespace musclebench

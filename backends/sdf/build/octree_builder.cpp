#include "backends/sdf/build/octree_builder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/build/octree_cells.hpp"
#include "backends/sdf/build/octree_memory.hpp"
#include "backends/sdf/build/octree_sign_error.hpp"
#include "backends/sdf/build/reference_samples.hpp"
#include "backends/sdf/octree/octree_entry.hpp"
#include "core/base/input_error.hpp"
#include "core/base/percentile.hpp"
#include "core/base/portable_math.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// Shares of the diagonal of the bone's box.
constexpr double near_share = 0.005;
constexpr double coarsest_wanted = 0.02;
constexpr double finest_wanted = 1e-8;  // coefficients are floats

constexpr double root_edge_near = 8;  ///< edge of a root over what counts as near
constexpr double finest_edge = 1e-4;  ///< over the root's: a limit that bones never reach
static_assert(finest_edge * (1 << octree_most_levels) >= 2);
constexpr double first_threshold = 3e-4;  ///< of the error indicator of a leaf, over the volume of all near points
/// Over what counts as near. Proving 0.75 of it takes 4 % of a build and saves 2 % of a collision (femur, 0.05 mm).
constexpr double least_reach = 1;
/// They tell the error that 99 % are below to 2.5 % (one standard deviation on scanned bones; twice as many to 1.7 %).
constexpr std::size_t sample_count = 10000;
/// Cells that are prefetched together.
constexpr std::size_t split_together = 4;
/// Target over the wanted error: the jumps across faces between leaves exceed the error by up to an eighth.
constexpr double aim_share = 0.88;

double number(std::size_t count) { return static_cast<double>(count); }

class OctreeBuilder {
 public:
  OctreeBuilder(const SignedSurface& surface, const TriangleMesh& mesh, const OctreeShape& shape,
                const ErrorTarget& target, const OctreeSettings& settings, const std::string& bone, int threads)
      : m_surface(surface),
        m_mesh(mesh),
        m_shape(shape),
        m_target(target),
        m_maker(surface, target),
        m_max_error_m(settings.max_error_m),
        m_memory(bone, settings.max_error_m, target.wanted_m, settings.memory_bytes),
        m_threads(threads) {}

  OctreeField build(const BuildProgress& progress) {
    const auto tell = [&](double share) {
      if (progress) {
        progress(share);
      }
    };
    tell(0);
    plant_roots();
    draw_samples();
    double first_p99_m = 0;
    double reached = 0;
    for (m_threshold_m3 = first_threshold * m_near_m3;; m_threshold_m3 *= next_step()) {
      const bool exhausted = !refine();
      // An eighth of the samples tells when it is worth measuring all.
      measure(8);
      if (share_beyond_target() <= 0.02) {
        measure(1);
      }
      if (m_errors_m.size() == m_samples.size() && share_beyond_target() <= allowed_share_beyond_target()) {
        OctreeField field = pack();
        tell(1);
        return field;
      }
      const double p99_m = error_quantile_m(0.99);
      first_p99_m = first_p99_m > 0 ? first_p99_m : p99_m;
      m_memory.learn(m_cells.size(), p99_m, exhausted);
      reached = std::max(reached, std::log(first_p99_m / p99_m) / std::log(first_p99_m / m_target.wanted_m));
      tell(std::clamp(reached, 0.0, 1.0));
    }
  }

 private:
  /// The error at a reference sample as it was measured last, in this cell by this polynomial.
  struct Measured {
    static constexpr std::size_t no_cell = std::numeric_limits<std::size_t>::max();
    std::size_t cell = no_cell;
    bool cubic = false;
    double error_m = 0;
  };

  void plant_roots() {
    m_cells.resize(m_shape.root_count());
    const GridIndex roots = m_shape.root_grid();
#pragma omp parallel num_threads(m_threads)
    {
      SampleBlock block(m_surface);
#pragma omp for schedule(dynamic, 8)
      for (std::size_t root = 0; root < m_cells.size(); ++root) {
        const auto [i, j, k] = roots.coordinates(root);
        const Vec3 index(number(i), number(j), number(k));
        const Vec3 centre_m = m_shape.lower_m + m_shape.root_edge_m * (index + Vec3::Constant(0.5));
        m_cells[root] = m_maker.root(centre_m, 0.5 * m_shape.root_edge_m, block);
      }
    }
  }

  void draw_samples() {
    m_samples = reference_samples(m_surface, m_mesh, m_target.near_m, sample_count, 1, m_threads);
    // Only the order of magnitude counts: the roots that hold near points are about half full of them.
    const auto near_roots = std::count_if(m_cells.begin(), m_cells.end(), [&](const OctreeCell& cell) {
      return std::abs(cell.distance_m) <= m_target.near_m + cell.reach_m();
    });
    m_near_m3 = 0.5 * static_cast<double>(near_roots) * m_shape.root_edge_m * m_shape.root_edge_m * m_shape.root_edge_m;
  }

  [[nodiscard]] bool can_split(const OctreeCell& cell) const {
    return cell.leaf != nullptr && cell.half_edge_m > m_target.finest_edge_m;
  }

  /// Splits the leaves whose error indicator is above the threshold until there is none. False when even a lower
  /// threshold would change nothing.
  bool refine() {
    fit_cubics();
    std::vector<std::size_t> work;
    bool more = false;
    for (std::size_t c = 0; c < m_cells.size(); ++c) {
      more = more || (can_split(m_cells[c]) && m_cells[c].quadratic_indicator_m3 > 0);
      if (can_split(m_cells[c]) && m_cells[c].indicator_m3() > m_threshold_m3) {
        work.push_back(c);
      }
    }
    while (!work.empty()) {
      work = split_all(work);
    }
    return more;
  }

  /// A cubic polynomial is fitted to a leaf when a threshold may let it take one, which half of them never see.
  void fit_cubics() {
#pragma omp parallel for schedule(dynamic, 64) num_threads(m_threads)
    for (std::size_t c = 0; c < m_cells.size(); ++c) {
      if (m_cells[c].lacks_cubic(m_threshold_m3)) {
        m_maker.fit_cubic(m_cells[c]);
      }
    }
  }

  /// Splits these cells; returns the children that have to be split, too.
  std::vector<std::size_t> split_all(const std::vector<std::size_t>& work) {
    const std::size_t needed = m_cells.size() + 16 * work.size();  // while they grow, the old ones are there
    if (!m_memory.has_room_for(needed)) {
      m_memory.refuse(needed,
                      m_errors_m.empty() ? m_target.near_m : error_quantile_m(1 - allowed_share_beyond_target()));
    }
    std::vector<std::size_t> next;
    // Cells across a face have different colours: the second colour takes over samples of the first.
    for (const bool odd : {false, true}) {
      std::vector<std::size_t> cells;
      std::copy_if(work.begin(), work.end(), std::back_inserter(cells),
                   [&](std::size_t cell) { return is_odd(cell) == odd; });
      split_apart(cells, next);
    }
    return next;
  }

  /// Sum of a cell's three indices in a grid of its size.
  [[nodiscard]] bool is_odd(std::size_t cell) const {
    const std::size_t roots = m_shape.root_count();
    if (cell >= roots) {
      return std::popcount((cell - roots) % 8) % 2 != 0;
    }
    const auto [i, j, k] = m_shape.root_grid().coordinates(cell);
    return (i + j + k) % 2 != 0;
  }

  /// Splits cells of which no two of one size share a face. (Of larger ones nothing is read that splitting writes.)
  void split_apart(const std::vector<std::size_t>& work, std::vector<std::size_t>& next) {
    const std::size_t first = m_cells.size();
    m_cells.resize(first + 8 * work.size());
#pragma omp parallel num_threads(m_threads)
    {
      SampleBlock block(m_surface);
      std::array<NeighbourChildren, split_together> neighbours;
#pragma omp for schedule(dynamic)
      for (std::size_t start = 0; start < work.size(); start += split_together) {
        const std::size_t end = std::min(start + split_together, work.size());
        for (std::size_t w = start; w < end; ++w) {
          neighbours[w - start] = neighbour_children(m_cells[work[w]]);
          fetch(m_cells[work[w]], neighbours[w - start]);
        }
        for (std::size_t w = start; w < end; ++w) {
          const std::span<OctreeCell, 8> children(&m_cells[first + 8 * w], 8);
          m_maker.split(m_cells[work[w]], neighbours[w - start], m_threshold_m3, children, block);
        }
      }
    }
    for (std::size_t w = 0; w < work.size(); ++w) {
      OctreeCell& cell = m_cells[work[w]];
      cell.first_child = first + 8 * w;
      cell.leaf.reset();
      for (std::size_t child = cell.first_child; child < cell.first_child + 8; ++child) {
        if (can_split(m_cells[child]) && m_cells[child].indicator_m3() > m_threshold_m3) {
          next.push_back(child);
        }
      }
    }
  }

  [[nodiscard]] NeighbourChildren neighbour_children(const OctreeCell& cell) const {
    NeighbourChildren children{};
    for (std::size_t face = 0; face < children.size(); ++face) {
      const Vec3 out = (face % 2 == 0 ? -2 : 2) * cell.half_edge_m * Vec3::Unit(static_cast<Eigen::Index>(face / 2));
      const Vec3 centre_m = cell.centre_m + out;
      const OctreeCell& found = m_cells[find(centre_m, cell.half_edge_m)];
      const bool is_there = (found.centre_m - centre_m).norm() < cell.half_edge_m;
      children[face] = is_there && found.split() ? &m_cells[found.first_child] : nullptr;
    }
    return children;
  }

  /// The leaf that holds a point, or its ancestor with this half edge.
  [[nodiscard]] std::size_t find(const Vec3& point, double half_edge_m = 0) const {
    std::array<std::size_t, 3> root{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      const double along = std::floor((point[a] - m_shape.lower_m[a]) / m_shape.root_edge_m);
      root[axis] = static_cast<std::size_t>(std::clamp(along, 0.0, m_shape.roots[axis] - 1.0));
    }
    return find_below(m_shape.root_grid().index(root), point, half_edge_m);
  }

  /// The same, starting from a cell that holds the point.
  [[nodiscard]] std::size_t find_below(std::size_t cell, const Vec3& point, double half_edge_m = 0) const {
    while (m_cells[cell].split() && m_cells[cell].half_edge_m > half_edge_m) {
      const Vec3& centre = m_cells[cell].centre_m;
      const std::size_t octant =
          (point[0] >= centre[0] ? 1U : 0U) + (point[1] >= centre[1] ? 2U : 0U) + (point[2] >= centre[2] ? 4U : 0U);
      cell = m_cells[cell].first_child + octant;
    }
    return cell;
  }

  /// At every `step`-th reference sample. Most leaves stay what they were when they were measured before.
  void measure(std::size_t step) {
    m_measured.resize(m_samples.size());
    m_errors_m.resize(m_samples.size() / step);
#pragma omp parallel for schedule(static) num_threads(m_threads)
    for (std::size_t p = 0; p < m_errors_m.size(); ++p) {
      const ReferenceSample& sample = m_samples[p * step];
      Measured& last = m_measured[p * step];
      const bool is_first = last.cell == Measured::no_cell;
      const std::size_t found = is_first ? find(sample.point) : find_below(last.cell, sample.point);
      const OctreeCell& cell = m_cells[found];
      const bool cubic = cell.takes_cubic(m_threshold_m3);
      if (found != last.cell || cubic != last.cubic) {
        // Without a leaf the sample is as far as near points are, to rounding.
        const double error_m = cell.leaf == nullptr ? 0 : std::abs(value_of(cell, sample.point) - sample.distance_m);
        last = {found, cubic, error_m};
      }
      m_errors_m[p] = last.error_m;
    }
  }

  [[nodiscard]] double value_of(const OctreeCell& cell, const Vec3& point) const {
    const Vec3 at = (point - cell.centre_m) / cell.half_edge_m;
    return cell.chosen(m_threshold_m3).value(at, cell.chosen_terms(m_threshold_m3));
  }

  [[nodiscard]] double error_quantile_m(double share) const {
    if (m_errors_m.empty()) {
      return 0;
    }
    return percentile(m_errors_m, share);
  }

  /// Of the samples that were measured last.
  [[nodiscard]] double share_beyond_target() const {
    const auto wrong = std::count_if(m_errors_m.begin(), m_errors_m.end(),
                                     [&](double error_m) { return error_m > m_target.wanted_m; });
    return static_cast<double>(wrong) / number(m_errors_m.size());
  }

  /// One in a hundred, less two standard deviations, so that another sample confirms the target.
  [[nodiscard]] double allowed_share_beyond_target() const {
    const double one_in_hundred = 0.01 * number(m_samples.size());
    return std::max(0.0, one_in_hundred - 2 * std::sqrt(one_in_hundred)) / number(m_samples.size());
  }

  /// Of the threshold. On scanned bones the share of samples beyond the target falls with its power 0.7 to 0.8. A
  /// little short of that, so as not to overshoot the aim by many cells; but not so short that samples are measured for
  /// nothing.
  [[nodiscard]] double next_step() const {
    constexpr double power = 1.25;
    constexpr double longest = 0.1;
    constexpr double shortest = 0.9;
    return std::clamp(portable::pow(allowed_share_beyond_target() / share_beyond_target(), power), longest, shortest);
  }

  OctreeField pack() {
    m_entries.reserve(m_cells.size());
    m_entries.assign(m_shape.root_count(), 0);
    m_coefficients.reserve(coefficient_count() + cubic_terms);
    m_quality = {m_max_error_m, m_target.near_m};
    m_quality.finest_edge_m = m_shape.root_edge_m;
    for (std::size_t root = 0; root < m_shape.root_count(); ++root) {
      pack(root, root);
    }
    m_coefficients.resize(m_coefficients.size() + cubic_terms);
    m_quality.sign_error_distance_m = largest_sign_error_distance_m();
    m_quality.samples = static_cast<std::int64_t>(m_errors_m.size());
    m_quality.p99_m = error_quantile_m(0.99);
    m_quality.largest_m = error_quantile_m(1);
    for (const double error_m : m_errors_m) {
      m_quality.mean_m += error_m / number(m_errors_m.size());
    }
    return {m_shape, m_quality, std::move(m_entries), std::move(m_coefficients)};
  }

  [[nodiscard]] std::size_t coefficient_count() const {
    std::size_t count = 0;
    for (const OctreeCell& cell : m_cells) {
      const std::size_t of_leaf = cell.leaf == nullptr ? 1 : cell.chosen_terms(m_threshold_m3);
      count += cell.split() ? 0 : of_leaf;
    }
    return count;
  }

  void pack(std::size_t from, std::size_t entry) {
    using octree_entry::Kind;
    const OctreeCell& cell = m_cells[from];
    if (m_coefficients.size() + 2 * cubic_terms > octree_entry::most_offsets) {
      m_memory.refuse_any_size(error_quantile_m(0.99));
    }
    if (cell.split()) {
      const std::size_t first = m_entries.size();
      m_entries[entry] = octree_entry::entry(Kind::split, first);
      m_entries.resize(first + 8);
      for (std::size_t octant = 0; octant < 8; ++octant) {
        pack(cell.first_child + octant, first + octant);
      }
    } else if (cell.leaf == nullptr) {
      m_entries[entry] = octree_entry::entry(Kind::outside, m_coefficients.size());
      m_coefficients.push_back(static_cast<float>(cell.distance_m * (1 - 1e-6)));
    } else {
      const bool cubic = cell.takes_cubic(m_threshold_m3);
      const PolynomialFit& fit = cell.chosen(m_threshold_m3);
      m_entries[entry] = octree_entry::entry(cubic ? Kind::cubic : Kind::quadratic, m_coefficients.size());
      m_coefficients.insert(
          m_coefficients.end(), fit.coefficients.begin(),
          fit.coefficients.begin() + static_cast<std::ptrdiff_t>(cubic ? cubic_terms : quadratic_terms));
      m_quality.finest_edge_m = std::min(m_quality.finest_edge_m, 2 * cell.half_edge_m);
      m_quality.excess_m = std::max(m_quality.excess_m, fit.excess_m);
      const bool known = (cell.inside() && fit.largest() < 0) || (cell.outside() && fit.smallest() > 0);
      m_quality.bound_m = known ? m_quality.bound_m : std::max(m_quality.bound_m, fit.bound_m);
    }
  }

  [[nodiscard]] double largest_sign_error_distance_m() const {
    const double least_m = least_reach * m_target.near_m;
    double reach_m = least_m;
#pragma omp parallel for schedule(dynamic, 64) num_threads(m_threads) reduction(max : reach_m)
    for (std::size_t c = 0; c < m_cells.size(); ++c) {
      const OctreeCell& cell = m_cells[c];
      if (cell.leaf != nullptr) {
        const std::size_t terms = cell.chosen_terms(m_threshold_m3);
        reach_m =
            std::max(reach_m, sign_error_distance_m(m_surface, cell, cell.chosen(m_threshold_m3), terms, least_m));
      }
    }
    return reach_m;
  }

  const SignedSurface& m_surface;
  const TriangleMesh& m_mesh;
  OctreeShape m_shape;
  ErrorTarget m_target;
  OctreeCellMaker m_maker;
  double m_max_error_m;  ///< the target is a little less
  OctreeMemory m_memory;
  int m_threads;

  std::vector<OctreeCell> m_cells;  ///< the roots, then children, eight and eight
  std::vector<ReferenceSample> m_samples;
  std::vector<Measured> m_measured;  ///< at each reference sample
  std::vector<double> m_errors_m;    ///< at every n-th one
  double m_near_m3 = 0;
  double m_threshold_m3 = 0;

  OctreeQuality m_quality;
  std::vector<std::uint32_t> m_entries;
  std::vector<float> m_coefficients;
};

}  // namespace

double octree_reach_m(const TriangleMesh& mesh, const OctreeSettings& settings) {
  const double diagonal_m = bounding_box(mesh.vertices).diagonal().norm();
  const double near_m = settings.near_m > 0 ? settings.near_m : near_share * diagonal_m;
  return std::numbers::sqrt3 * (settings.margin * diagonal_m + root_edge_near * near_m);
}

OctreeField build_octree(const SignedSurface& surface, const TriangleMesh& mesh, const OctreeSettings& settings,
                         const std::string& bone_name, int threads, const BuildProgress& progress) {
  const Eigen::AlignedBox3d box = bounding_box(mesh.vertices);
  const double diagonal_m = box.diagonal().norm();
  const double wanted_m = settings.max_error_m;
  if (!(wanted_m >= finest_wanted * diagonal_m && wanted_m <= coarsest_wanted * diagonal_m)) {
    throw InputError(fmt::format("sdf: max_error_mm ({})", bone_name),
                     fmt::format("{:.3g} is out of proportion to a bone of {:.3g} mm; {:.2g} to {:.2g} makes sense",
                                 wanted_m * 1e3, diagonal_m * 1e3, diagonal_m * 2e-2, diagonal_m * 2));
  }
  const double near_m = settings.near_m > 0 ? settings.near_m : near_share * diagonal_m;
  OctreeShape shape;
  shape.root_edge_m = root_edge_near * near_m;
  const Vec3 size = box.sizes() + Vec3::Constant(2 * settings.margin * diagonal_m);
  const Vec3 roots = (size / shape.root_edge_m).array().ceil().cwiseMax(1.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    shape.roots[axis] = static_cast<std::int32_t>(roots[static_cast<Eigen::Index>(axis)]);
  }
  shape.lower_m = box.center() - 0.5 * shape.root_edge_m * roots;
  const ErrorTarget target{aim_share * wanted_m, near_m, finest_edge * shape.root_edge_m};
  return OctreeBuilder(surface, mesh, shape, target, settings, bone_name, threads).build(progress);
}

}  // namespace musclebench

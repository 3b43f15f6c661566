#include "bench/cases/verification.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "backends/registry.hpp"
#include "core/base/input_error.hpp"
#include "core/base/random_numbers.hpp"
#include "core/mesh/surface_sampler.hpp"
#include "core/mesh_repair/repair_mesh.hpp"
#include "core/referee/referee.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

Eigen::AlignedBox3d box_of_triangles(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Triangle& triangle : mesh.triangles) {
    for (const int vertex : triangle) {
      box.extend(mesh.vertices[static_cast<std::size_t>(vertex)]);
    }
  }
  return box;
}

/// A random point of a random triangle, of its edges and of its corners.
class PointSource {
 public:
  PointSource(const TriangleMesh& mesh, std::uint64_t seed)
      : m_mesh(mesh), m_box(box_of_triangles(mesh)), m_diagonal_m(m_box.diagonal().norm()), m_random(seed) {}

  Vec3 anywhere() { return m_box.min() + m_box.sizes().cwiseProduct(1.2 * within_unit_box() - Vec3::Constant(0.1)); }

  Vec3 near_surface(double jitter_share) {
    const auto corner = random_triangle();
    const double v = m_random.share();
    const Vec3 on_surface = point_of_triangle(corner[0], corner[1], corner[2], v, m_random.share());
    return on_surface + jitter_share * m_diagonal_m * (2 * within_unit_box() - Vec3::Ones());
  }

  Vec3 vertex() { return random_triangle()[m_random.below(3)]; }

  Vec3 edge_middle() {
    const auto corner = random_triangle();
    const std::size_t edge = m_random.below(3);
    return 0.5 * (corner[edge] + corner[(edge + 1) % 3]);
  }

 private:
  Vec3 within_unit_box() {
    const double x = m_random.share();
    const double y = m_random.share();
    return {x, y, m_random.share()};
  }

  std::array<Vec3, 3> random_triangle() {
    const Triangle& triangle = m_mesh.triangles[m_random.below(m_mesh.triangles.size())];
    std::array<Vec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = m_mesh.vertices[static_cast<std::size_t>(triangle[i])];
    }
    return corners;
  }

  const TriangleMesh& m_mesh;
  Eigen::AlignedBox3d m_box;
  double m_diagonal_m;
  RandomNumbers m_random;
};

/// The signed distances of the points from `first` to the end of `answers`, a batch at a time.
template <typename Distance>
void answer_all(std::span<const Vec3> points, [[maybe_unused]] const VerificationSettings& settings,
                const std::string& stage, std::ptrdiff_t batch, const VerificationProgress& progress,
                const Distance& distance) {
  const auto count = static_cast<std::ptrdiff_t>(points.size());
  for (std::ptrdiff_t first = 0; first < count; first += batch) {
    const std::ptrdiff_t end = std::min(first + batch, count);
#pragma omp parallel for num_threads(settings.threads) schedule(dynamic, 16) if (settings.threads > 1)
    for (std::ptrdiff_t i = first; i < end; ++i) {
      distance(static_cast<std::size_t>(i));
    }
    progress(stage, static_cast<int>(end), static_cast<int>(count));
  }
}

/// Signed distances by one implementation at the points, or at the first of them.
struct Answers {
  std::string name;
  std::vector<double> distances_m;
};

Agreement compare(std::span<const Vec3> points, const Answers& by_one, const Answers& by_other, double tolerance_m) {
  const std::vector<double>& one = by_one.distances_m;
  const std::vector<double>& other = by_other.distances_m;
  Agreement result{by_one.name, by_other.name};
  result.points = static_cast<std::int64_t>(other.size());
  for (std::size_t i = 0; i < other.size(); ++i) {
    double difference = std::abs(std::abs(one[i]) - std::abs(other[i]));
    if (std::isnan(difference)) {  // no answer is the worst answer
      difference = std::numeric_limits<double>::infinity();
    }
    const bool differ = (one[i] < 0) != (other[i] < 0);
    const bool beyond = std::max(std::abs(one[i]), std::abs(other[i])) > tolerance_m;
    const bool is_first_sign = differ && beyond && result.sign_differences == 0;
    if (difference > result.largest_difference_m || (is_first_sign && result.largest_difference_m <= tolerance_m)) {
      result.worst_point_m = points[i];
    }
    result.largest_difference_m = std::max(result.largest_difference_m, difference);
    result.sign_differences += differ && beyond ? 1 : 0;
    result.inside += one[i] < 0 ? 1 : 0;
  }
  return result;
}

std::int64_t points_for(const TriangleMesh& mesh, const VerificationSettings& settings) {
  constexpr std::int64_t share_if_open = 50;
  const std::int64_t fewer = std::max(settings.points / share_if_open, settings.brute_force_points);
  return is_closed(mesh) ? settings.points : std::min(settings.points, fewer);
}

}  // namespace

double agreed_difference_m(const TriangleMesh& mesh) {
  const Eigen::AlignedBox3d box = box_of_triangles(mesh);
  const double largest_coordinate_m = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
  return agreed_share * box.diagonal().norm() +
         agreed_roundings * std::numeric_limits<double>::epsilon() * largest_coordinate_m;
}

bool SurfaceVerification::holds(const Agreement& agreement) const {
  return agreement.sign_differences == 0 && agreement.largest_difference_m <= agreed_m;
}

bool SurfaceVerification::held() const {
  return std::all_of(pairs.begin(), pairs.end(), [&](const Agreement& pair) { return holds(pair); });
}

std::vector<Vec3> points_about(const TriangleMesh& mesh, std::int64_t count, std::uint64_t seed) {
  PointSource source(mesh, seed);
  std::vector<Vec3> points;
  points.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    switch (i % 10) {
      case 0:
      case 1:
      case 2:
        points.push_back(source.anywhere());
        break;
      case 3:
      case 4:
      case 5:
        points.push_back(source.near_surface(5e-3));
        break;
      case 6:
        points.push_back(source.near_surface(1e-6));
        break;
      case 7:
        points.push_back(source.near_surface(1e-12));
        break;
      case 8:
        points.push_back(source.vertex());
        break;
      default:
        points.push_back(source.edge_middle());
    }
  }
  return points;
}

SurfaceVerification verify_surface(const Bone& bone, const VerificationSettings& settings,
                                   const VerificationProgress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const TriangleMesh& mesh = bone.surface.mesh;
  const Referee referee(std::span(&bone, 1), 0);
  const BackendEntry& exact = exact_backend();
  if (!exact.signed_distance) {
    throw InputError("verify", fmt::format("'{}' tells no signed distances to compare", exact.name));
  }
  const SignedDistance by_exact = exact.signed_distance(bone, settings.threads);
  const std::vector<Vec3> points = points_about(mesh, points_for(mesh, settings), settings.seed);
  const auto few = std::span(points).first(
      static_cast<std::size_t>(std::min(std::ssize(points), static_cast<std::ptrdiff_t>(settings.brute_force_points))));

  Answers of_exact{exact.name, std::vector<double>(points.size())};
  Answers of_referee{"Referee", std::vector<double>(points.size())};
  answer_all(points, settings, exact.name + " and Referee", 2000, progress, [&](std::size_t i) {
    of_exact.distances_m[i] = by_exact(points[i]);
    of_referee.distances_m[i] = referee.signed_distance(0, points[i]);
  });

  SurfaceVerification result;
  result.diagonal_m = box_of_triangles(mesh).diagonal().norm();
  result.agreed_m = agreed_difference_m(mesh);
  result.pairs.push_back(compare(points, of_exact, of_referee, result.agreed_m));
  for (const BackendEntry& other : backend_registry()) {
    if (!other.signed_distance || &other == &exact) continue;
    if (other.exact || is_clean(mesh)) {
      const SignedDistance by_other = other.signed_distance(bone, settings.threads);
      Answers of_other{other.name, std::vector<double>(few.size())};
      answer_all(few, settings, other.name, 64, progress,
                 [&](std::size_t i) { of_other.distances_m[i] = by_other(points[i]); });
      result.pairs.push_back(compare(points, of_exact, of_other, result.agreed_m));
      result.pairs.push_back(compare(points, of_referee, of_other, result.agreed_m));
    }
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace musclebench

#include "bench/cases/verification.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "backends/brute_force/brute_force_surface.hpp"
#include "backends/bvh/exact_surface.hpp"
#include "core/base/random_numbers.hpp"
#include "core/mesh/surface_sampler.hpp"
#include "core/referee/referee.hpp"

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

Agreement compare(std::span<const Vec3> points, std::span<const double> one, std::span<const double> other,
                  double tolerance_m) {
  Agreement result;
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

std::int64_t points_for(const ExactSurface& surface, const VerificationSettings& settings) {
  constexpr std::int64_t share_if_open = 50;
  const std::int64_t fewer = std::max(settings.points / share_if_open, settings.brute_force_points);
  return surface.closed() ? settings.points : std::min(settings.points, fewer);
}

}  // namespace

bool SurfaceVerification::holds(const Agreement& agreement) const {
  return agreement.sign_differences == 0 && agreement.largest_difference_m <= agreed_m;
}

bool SurfaceVerification::held() const {
  return holds(bvh_referee) && holds(bvh_brute_force) && holds(referee_brute_force);
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
  const ExactSurface bvh(bone.surface, settings.threads);
  const std::vector<Vec3> points = points_about(mesh, points_for(bvh, settings), settings.seed);
  const std::size_t few = static_cast<std::size_t>(std::min(std::ssize(points), settings.brute_force_points));

  std::vector<double> by_bvh(points.size());
  std::vector<double> by_referee(points.size());
  answer_all(points, settings, "bvh and Referee", 2000, progress, [&](std::size_t i) {
    by_bvh[i] = bvh.signed_distance_m(points[i]);
    by_referee[i] = referee.signed_distance(0, points[i]);
  });
  std::vector<double> by_brute_force(few);
  answer_all(std::span(points).first(few), settings, "brute_force", 64, progress, [&](std::size_t i) {
    const SurfacePoint place = locate_by_brute_force(mesh, points[i]);
    by_brute_force[i] = place.inside ? -place.distance_m : place.distance_m;
  });

  SurfaceVerification result;
  const Eigen::AlignedBox3d box = box_of_triangles(mesh);
  result.diagonal_m = box.diagonal().norm();
  const double largest_coordinate_m = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
  result.agreed_m = agreed_share * result.diagonal_m +
                    agreed_roundings * std::numeric_limits<double>::epsilon() * largest_coordinate_m;
  result.bvh_referee = compare(points, by_bvh, by_referee, result.agreed_m);
  result.bvh_brute_force = compare(points, by_bvh, by_brute_force, result.agreed_m);
  result.referee_brute_force = compare(points, by_referee, by_brute_force, result.agreed_m);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace musclebench

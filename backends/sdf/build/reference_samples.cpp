#include "backends/sdf/build/reference_samples.hpp"

#include "core/base/random_numbers.hpp"
#include "core/mesh/morton_order.hpp"
#include "core/mesh/surface_sampler.hpp"

namespace musclebench {

std::vector<ReferenceSample> reference_samples(const SignedSurface& surface, const TriangleMesh& mesh, double near_m,
                                               std::size_t count, std::uint64_t seed, [[maybe_unused]] int threads) {
  const SurfaceSampler sampler(mesh);
  RandomNumbers random(seed);
  std::vector<Vec3> points(count);
  std::vector<int> below(count);
  for (std::size_t p = 0; p < count; ++p) {
    const SurfaceSample sample = sampler.draw(random);
    points[p] = sample.point + (2 * random.share() - 1) * near_m * sample.normal;
    below[p] = sample.triangle;
  }
  const std::vector<int> order = morton_order(points);
  std::vector<ReferenceSample> samples(count);
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
  for (std::size_t p = 0; p < count; ++p) {
    const auto drawn = static_cast<std::size_t>(order[p]);
    const Vec3& point = points[drawn];
    samples[p] = {point, surface.locate_from(point, below[drawn]).signed_distance_m()};
  }
  return samples;
}

}  // namespace musclebench

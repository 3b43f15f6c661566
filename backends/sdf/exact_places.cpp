#include "backends/sdf/exact_places.hpp"

#include "core/base/random_numbers.hpp"
#include "core/geometry/surface_sampler.hpp"

namespace musclebench {

std::vector<ExactPlace> places_about(const SignedSurface& surface, const TriangleMesh& mesh, double near_m,
                                     std::size_t count, std::uint64_t seed, [[maybe_unused]] int threads) {
  const SurfaceSampler sampler(mesh);
  RandomNumbers random(seed);
  std::vector<SurfaceSample> samples(count);
  std::vector<ExactPlace> places(count);
  for (std::size_t p = 0; p < count; ++p) {
    samples[p] = sampler.draw(random);
    places[p].point = samples[p].point + (2 * random.share() - 1) * near_m * samples[p].normal;
  }
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
  for (std::size_t p = 0; p < count; ++p) {
    const ClosestPoint closest = surface.tree().closest_point_from(places[p].point, samples[p].triangle);
    places[p].distance_m = surface.is_inside(places[p].point, closest) ? -closest.distance_m : closest.distance_m;
  }
  return places;
}

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// A point near the surface and its exact signed distance.
struct ReferenceSample {
  Vec3 point = Vec3::Zero();
  double distance_m = 0;
};

/// `count` points, as contacts meet them: uniform over the area of the surface of `mesh` and over distances up to
/// `near_m` to both sides of it. In Morton order, so that every n-th of them is a uniform sample, too, and neighbours
/// share cache lines. Deterministic.
std::vector<ReferenceSample> reference_samples(const SignedSurface& surface, const TriangleMesh& mesh, double near_m,
                                               std::size_t count, std::uint64_t seed, int threads);

}  // namespace musclebench

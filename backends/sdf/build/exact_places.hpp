#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// A place and its exact distance.
struct ExactPlace {
  Vec3 point = Vec3::Zero();
  double distance_m = 0;
};

/// `count` places, as contacts meet them: evenly spread over the area of the surface of `mesh` and the way up to
/// `near_m` to both sides of it. Those that follow each other are neighbours, so a part of them, every n-th, is spread
/// evenly, too, and what is looked up for them is still in the caches. Deterministic.
std::vector<ExactPlace> places_about(const SignedSurface& surface, const TriangleMesh& mesh, double near_m,
                                     std::size_t count, std::uint64_t seed, int threads);

}  // namespace musclebench

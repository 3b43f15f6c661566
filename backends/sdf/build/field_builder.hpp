#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "backends/sdf/grid/cubic_field.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// Resolution and extent of a bone's grid.
struct GridSettings {
  int cells = 64;          ///< along each axis of the bone's box; not used where `cell_size_m` is given
  double cell_size_m = 0;  ///< edge of cubic cells; 0: use `cells`
  double margin = 1e-3;    ///< the domain is the bone's bounding box, grown on all sides by this share of its diagonal
};

/// The grid over a bone's surface. Throws InputError (about `cell_size_m` of the bone) where the cells are larger than
/// the bone or absurdly small.
GridShape grid_over(const TriangleMesh& mesh, const GridSettings& settings, const std::string& bone_name);

/// Fills the grid with the exact signed distance at its nodes (Koschier et al. 2017), marks the cells where the cubic
/// field may be negative, and estimates its error. The answers of a part of the grid are those of the whole. The same
/// bits for any number of threads.
/// `progress`, where given, is called from time to time by one thread with the share that is done.
CubicField build_field(const SignedSurface& surface, const GridShape& shape, int threads,
                       const std::function<void(double)>& progress = {});

/// Compares at `samples` random points of the domain within two cells (their diagonal) of the surface; deterministic.
FieldError estimate_error(const CubicField& field, const SignedSurface& surface, int samples, std::uint64_t seed = 1);

}  // namespace musclebench

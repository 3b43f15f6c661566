#pragma once

#include <cstdint>
#include <string>

#include "backends/sdf/cubic_field.hpp"
#include "core/geometry/signed_surface.hpp"

namespace musclebench {

/// How a bone's grid is laid out.
struct GridSettings {
  int cells = 64;          ///< along each axis of the bone's box; not used where `cell_size_m` is given
  double cell_size_m = 0;  ///< edge of cubic cells; 0: use `cells`
  double margin = 1e-3;    ///< the domain is the bone's bounding box, grown on all sides by this share of its diagonal
};

/// The grid over a bone's surface. Throws InputError (place: `cell_size_m` of the bone) where the cells are larger than
/// the bone or absurdly small.
GridShape grid_over(const TriangleMesh& mesh, const GridSettings& settings, const std::string& bone_name);

/// Fills the grid with the exact signed distance at its nodes (Koschier et al. 2017), and marks the cells where the
/// cubic field may be negative. Where interpolation would make the field negative on the border of the domain, the
/// edges there are made straight: all vertices of the border are outside the bone. The same bits for any number of
/// threads.
CubicField build_field(const SignedSurface& surface, const GridShape& shape, FieldPrecision precision, int threads);

/// How far a field is from the exact distance.
struct FieldError {
  int samples = 0;
  double largest_m = 0;
  double p99_m = 0;
  double mean_m = 0;
  int wrong_signs = 0;              ///< samples on the other side than the field says
  double deepest_wrong_sign_m = 0;  ///< largest exact distance of those
};

/// Compares at `samples` random points of the domain within two cells (their diagonal) of the surface; deterministic.
FieldError estimate_error(const CubicField& field, const SignedSurface& surface, int samples, std::uint64_t seed = 1);

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <string>

#include "backends/sdf/grid/cubic_field.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// Throws InputError (about the path) where a field from another program, whose file has neither surface nor checksum,
/// can't be the distance field of a bone: one of its surface, in metres, negative inside.
/// - It has to cover the bone and be positive at most corners of its domain.
/// - Of some thousand nodes, near the surface and far, 99 of 100 have to hold the distance to the surface, and all of
///   them its side.
/// - No two nodes of a cell may differ by more than the distance between them (the field is 1-Lipschitz); checked for
///   all cells, so that a damaged node changes the field by less than a cell, or is found.
///
/// Values may be off by a thousandth of a cell and a millionth of the domain, for surfaces and fields in files of few
/// digits. A wrong sign is accepted where Discregrid is known to produce it: next to features of the surface
/// that have no pseudo-normal (see `ManifoldFeatures`), next to corners whose faces do not all face the point, and
/// anywhere about a surface that is not closed, unless half of the inside is missing. Deterministic.
void require_field_of(const CubicField& field, const TriangleMesh& mesh, const SignedSurface& surface,
                      const std::string& bone_name, const std::filesystem::path& path);

}  // namespace musclebench

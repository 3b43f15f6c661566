#pragma once

#include <filesystem>
#include <string>

#include "backends/sdf/grid/cubic_field.hpp"

namespace musclebench {

/// Fields in the binary format of Discregrid (.cdf, what its CubicLagrangeDiscreteGrid::save writes; Bullet's btMiniSDF
/// reads it, too), in this machine's byte order as there: domain, resolution, size of a cell and its inverse, numbers
/// of cells and of fields; then for each field the values of all nodes, for each cell its 32 nodes, and for each cell
/// index of the grid its cell. The format names no surface and has no checksum.

/// Writes a field, in double precision. Throws InputError (about the path) when the file can't be written.
void write_discregrid(const CubicField& field, const std::filesystem::path& path);

/// Reads the first field of a file, in double precision. Throws InputError (about the path) that says what is wrong
/// with a file that is none, of another byte order, truncated, or lacks cells (what Discregrid calls a reduced field).
/// `require_field_of` checks the values.
CubicField read_discregrid(const std::filesystem::path& path, int threads);

}  // namespace musclebench

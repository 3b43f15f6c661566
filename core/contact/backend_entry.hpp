#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/contact/muscle_contact.hpp"
#include "core/contact/response.hpp"
#include "core/contact/surface_queries.hpp"

namespace musclebench {

/// A function that long work calls repeatedly. `share` is the part done, 0 to 1.
using ShareReport = std::function<void(double share)>;

/// A structure that a backend built over one bone, ready to be written to a file. Errors are in metres, compared with
/// the exact distance at `samples` points near the bone's surface.
struct BuiltStructure {
  std::string cells;  ///< number and size of the cells, in words
  std::size_t bytes = 0;
  double p99_error_m = 0;  ///< 99th percentile
  double largest_error_m = 0;
  std::int64_t samples = 0;
  std::function<void(const std::filesystem::path& out)> write;  ///< writes the file; throws InputError if it can't
};

/// Writes a backend's structure over one bone to a file that other programs read (`musclebench field`).
struct StructureExport {
  std::string formats = {};  ///< for help: the allowed endings of a file, and the parameters that they require
  /// Throws InputError if the parameters cannot be exported, or if the ending of `out` does not fit them.
  std::function<void(const Parameters& parameters, const std::filesystem::path& out)> require_fit;
  std::function<BuiltStructure(const Bone& bone, const Parameters& parameters, int threads, const ShareReport& report)>
      build;

  /// Whether the backend can write its structure.
  [[nodiscard]] explicit operator bool() const { return build != nullptr; }
};

/// A function that returns the signed distance of a point in the rest frame of one bone. It is in metres, negative
/// inside. Several threads call it at once.
using SignedDistance = std::function<double(const Vec3& point)>;

/// A backend's row in the table of backends: what `list` prints, and the functions that make the backend. A folder
/// `NAME` defines `BackendEntry NAME_entry()` in namespace musclebench.
struct BackendEntry {
  std::string name;  ///< the same in folder, target, `--backend`, CSV and legend
  std::string help;  ///< one line
  /// Whose code it is, for `list`: a library with its version, or this project and the source of the method.
  std::string implementation = {};
  ResponseKind default_response = ResponseKind::project;
  /// With default parameters its answers are exact up to rounding. The first exact backend of the table computes the
  /// reference for the others.
  bool exact = false;
  std::vector<ParameterSpec> parameters = {};
  /// Values that turn on `Capabilities::point_queries`, if the defaults lack it.
  std::map<std::string, ParameterValue> for_points = {};
  /// Makes the backend. May throw InputError for a combination of parameters that it does not support.
  std::function<std::unique_ptr<CollisionBackend>(const Parameters&)> make = nullptr;
  /// Builds the signed distance over one bone, which must outlive it. `verify` and query sets compare it. An exact
  /// backend has it; another one may have it if it is exact over clean bones (`is_clean`).
  std::function<SignedDistance(const Bone& bone, int threads)> signed_distance = nullptr;
  /// Makes a detector of contacts between muscles. Empty if the backend cannot follow deforming surfaces.
  MakeMuscleContactDetector make_muscle_detector = nullptr;
  /// What contact of faces with bones asks (`--for faces=NAME`). Empty if the backend does not offer it. Throws
  /// InputError for parameters that do not fit the bones.
  std::function<MakeSurfaceQueries(const Parameters&, std::span<const Bone> bones)> make_surface_queries = nullptr;
  StructureExport structure_export = {};
  std::string study = {};  ///< the text of its study.toml; the build fills it in
};

}  // namespace musclebench

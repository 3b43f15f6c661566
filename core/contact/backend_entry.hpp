#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/contact/muscle_contact.hpp"
#include "core/contact/response.hpp"

namespace musclebench {

/// Called repeatedly with the share that is done.
using ShareReport = std::function<void(double share)>;

/// The structure that a backend has built over one bone, ready to be written.
struct BuiltStructure {
  std::string cells;  ///< for people: how many there are and how large
  std::size_t bytes = 0;
  double p99_error_m = 0;  ///< at samples near the bone's surface
  double largest_error_m = 0;
  std::int64_t samples = 0;
  std::function<void(const std::filesystem::path& out)> write;
};

/// How a backend's structure over one bone is written to a file that other programs read (`musclebench field`).
struct StructureExport {
  std::string formats = {};  ///< for help: the endings that a file may have, and which parameters they fit
  /// Throws InputError where the parameters can't be exported or the ending of `out` does not fit them.
  std::function<void(const Parameters& parameters, const std::filesystem::path& out)> require_fit;
  std::function<BuiltStructure(const Bone& bone, const Parameters& parameters, int threads, const ShareReport& report)>
      build;

  [[nodiscard]] explicit operator bool() const { return build != nullptr; }
};

/// The signed distance of a point in one bone's rest frame, in metres, negative inside. Called by several threads at
/// once.
using SignedDistance = std::function<double(const Vec3& point)>;

/// A backend's row in the table of backends. It has one name everywhere: folder, target, `--backend`, CSV, legend.
struct BackendEntry {
  std::string name;
  std::string help;
  /// Whose code it is: a library with its version, or this project, and after whose method.
  std::string implementation = {};
  ResponseKind default_response = ResponseKind::project;
  /// With its default parameters only rounding lies between its answers and the truth. The first exact one of the
  /// table drives what others are compared with.
  bool exact = false;
  std::vector<ParameterSpec> parameters = {};
  /// With these it answers about single points (Capabilities::point_queries), where with its defaults it does not.
  std::map<std::string, ParameterValue> for_points = {};
  std::function<std::unique_ptr<CollisionBackend>(const Parameters&)> make = nullptr;
  /// Of an exact one, over one bone, which outlives the answer: what `verify` compares.
  std::function<SignedDistance(const Bone& bone, int threads)> signed_distance = nullptr;
  /// Empty for a backend that can't follow a surface that deforms.
  MakeMuscleContactDetector make_muscle_detector = nullptr;
  StructureExport structure_export = {};
  std::string study = {};  ///< the text of its study.toml; empty: none
};

}  // namespace musclebench

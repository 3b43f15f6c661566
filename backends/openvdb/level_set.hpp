#pragma once

#include <cstddef>
#include <memory>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What a level set is built from.
struct LevelSetRequest {
  const TriangleMesh& mesh;
  Vec3 middle;  ///< m; voxels count from here
  double voxel_size_m = 0;
  double outside_voxels = 0;  ///< that have distances
  double inside_voxels = 0;
  int threads = 1;
};

/// Reads a level set from one thread, and is fastest where points follow each other closely.
class LevelSetReader {
 public:
  LevelSetReader() = default;
  LevelSetReader(const LevelSetReader&) = delete;
  LevelSetReader& operator=(const LevelSetReader&) = delete;
  virtual ~LevelSetReader() = default;

  /// The distance, m, negative inside, interpolated linearly along each axis; `at` is in voxels from the middle.
  [[nodiscard]] virtual double value_m(const Vec3& at) const = 0;
};

/// A level set of OpenVDB, which is in a module of its own: loading OpenVDB takes 50 ms, which only those wait for who
/// use it.
class LevelSet {
 public:
  LevelSet() = default;
  LevelSet(const LevelSet&) = delete;
  LevelSet& operator=(const LevelSet&) = delete;
  virtual ~LevelSet() = default;

  /// Several threads may ask for theirs at once.
  [[nodiscard]] virtual std::unique_ptr<LevelSetReader> reader() const = 0;
  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

/// What the module offers, by this name: the caller owns what it makes.
using MakeLevelSet = LevelSet* (*)(const LevelSetRequest& request);
inline constexpr const char* make_level_set_name = "musclebench_make_level_set";

}  // namespace musclebench

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <dlfcn.h>
#include <limits>
#include <memory>
#include <openvdb/version.h>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "backends/openvdb/level_set.hpp"
#include "core/base/input_error.hpp"
#include "core/base/system_memory.hpp"
#include "core/base/unsupported_input.hpp"
#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/surface_volume.hpp"
#include "core/signed_distance/field_error.hpp"

namespace musclebench {

namespace {

struct OpenvdbSettings {
  double voxel_size_m = 0;
  double band_voxels = 3;  ///< outside
  double depth_m = 0;      ///< inside; 0: all of it
};

/// From where it was built, or from where it is installed beside the program. It stays loaded.
MakeLevelSet load_module() {
  for (const char* path : {MUSCLEBENCH_OPENVDB_MODULE, "$ORIGIN/../lib/" MUSCLEBENCH_OPENVDB_MODULE_NAME,
                           MUSCLEBENCH_OPENVDB_MODULE_NAME}) {
    void* module = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (module == nullptr) continue;
    if (void* found = dlsym(module, make_level_set_name)) return reinterpret_cast<MakeLevelSet>(found);
  }
  throw InputError("openvdb", fmt::format("its module can't be loaded: put {} into ../lib beside the program ({})",
                                          MUSCLEBENCH_OPENVDB_MODULE_NAME, dlerror()));
}

std::unique_ptr<LevelSet> level_set_of(const TriangleMesh& mesh, const Vec3& middle, const OpenvdbSettings& settings,
                                       int threads) {
  static const MakeLevelSet make_level_set = load_module();
  const double inside_voxels = settings.depth_m > 0 ? std::max(settings.depth_m / settings.voxel_size_m, 1.0)
                                                    : static_cast<double>(std::numeric_limits<float>::max());
  return std::unique_ptr<LevelSet>(make_level_set({.mesh = mesh,
                                                   .middle = middle,
                                                   .voxel_size_m = settings.voxel_size_m,
                                                   .outside_voxels = settings.band_voxels,
                                                   .inside_voxels = inside_voxels,
                                                   .threads = threads}));
}

class OpenvdbBone {
 public:
  OpenvdbBone(const Bone& bone, const OpenvdbSettings& settings, int threads)
      : m_middle(bounding_box(bone.surface.mesh.vertices).center()),
        m_voxel_size_m(settings.voxel_size_m),
        m_band_m(settings.band_voxels * settings.voxel_size_m),
        m_level_set(level_set_of(bone.surface.mesh, m_middle, settings, threads)) {
    constexpr int samples = 2000;
    const Session session(*this);
    const FieldError error = estimate_error(
        bone.signed_distance(),
        {.box = bounding_box(bone.surface.mesh.vertices), .reach_m = 2 * m_voxel_size_m, .count = samples},
        [&](const Vec3& point) { return session.value_m(point); });
    m_error = {"", bytes(), error.samples, error.largest_m, error.p99_m};
  }

  class Session {
   public:
    explicit Session(const OpenvdbBone& bone) : m_bone(bone), m_reader(bone.m_level_set->reader()) {}

    [[nodiscard]] LocatedPoint locate(const Vec3& point, int& /*near*/) const {
      const double at_m = value_m(point);
      if (at_m >= 0) {
        // What interpolates distances linearly along each axis changes by no more than sqrt(3) times the way; half
        // leaves room for what the builder smooths.
        return {.clearance_m = 0.5 * at_m};
      }
      // The gradient of a linear interpolation jumps between voxels. Differences over a voxel do not.
      Vec3 slope;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const Vec3 half = 0.5 * m_bone.m_voxel_size_m * Vec3::Unit(axis);
        slope[axis] = (value_m(point + half) - value_m(point - half)) / m_bone.m_voxel_size_m;
      }
      // Deeper than the band all values are the same.
      const Vec3 out = slope.norm() > 1e-9 ? slope.normalized() : (point - m_bone.m_middle).stableNormalized();
      return {.inside = true, .depth_m = -at_m, .outward = out.isZero() ? Vec3::UnitX() : out};
    }

    [[nodiscard]] double value_m(const Vec3& point) const {
      const Vec3 in_voxels = (point - m_bone.m_middle) / m_bone.m_voxel_size_m;
      constexpr double farthest = 1e9;  // of numbers that voxels are counted by
      return (in_voxels.array().abs() < farthest).all() ? m_reader->value_m(in_voxels) : m_bone.m_band_m;
    }

   private:
    const OpenvdbBone& m_bone;
    std::unique_ptr<LevelSetReader> m_reader;
  };

  [[nodiscard]] Session session() const { return Session(*this); }

  /// Weights of eight corners at a distance of at most sqrt(3/4) voxels on average, for distances that are right there,
  /// and what the direction out errs by beside an edge. Sheets thinner than a voxel and a half lie outside it.
  [[nodiscard]] AnswerBound answer_bound() const {
    const double bound_m = 1.5 * m_voxel_size_m;
    return {bound_m, bound_m, m_voxel_size_m};
  }
  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + m_level_set->bytes(); }
  [[nodiscard]] std::optional<StructureError> error() const { return m_error; }

 private:
  Vec3 m_middle;
  double m_voxel_size_m;
  double m_band_m;
  std::unique_ptr<LevelSet> m_level_set;
  StructureError m_error;
};

/// Of voxels inside, unless the band is narrower, and in the band outside; with what the tree and its builder take.
double bytes_to_build(const TriangleMesh& mesh, const OpenvdbSettings& settings) {
  constexpr double bytes_a_voxel = 12;
  const double area_m2 = surface_area_m2(mesh);
  const double volume_m3 = std::abs(surface_volume_m3(mesh.vertices, mesh.triangles));
  const double inside_m3 = settings.depth_m > 0 ? std::min(volume_m3, area_m2 * settings.depth_m) : volume_m3;
  const double kept_m3 = inside_m3 + area_m2 * settings.band_voxels * settings.voxel_size_m;
  return bytes_a_voxel * kept_m3 / std::pow(settings.voxel_size_m, 3);
}

void require_fitting_voxels(std::span<const Bone> bones, const OpenvdbSettings& settings) {
  double bytes = 0;
  for (const Bone& bone : bones) {
    const Vec3 sizes = bounding_box(bone.surface.mesh.vertices).sizes();
    if (sizes.minCoeff() < 1.5 * settings.voxel_size_m) {
      throw UnsupportedInput(
          fmt::format("openvdb: voxel_size_m (bone '{}')", bone.name),
          fmt::format("{} is too coarse: OpenVDB needs 1.5 voxels between two surfaces, and the bone is "
                      "{:.3g} m thick; take a smaller one",
                      settings.voxel_size_m, sizes.minCoeff()));
    }
    bytes += bytes_to_build(bone.surface.mesh, settings);
  }
  const double share = std::cbrt(bytes / static_cast<double>(available_memory_bytes()));
  require_memory(static_cast<std::size_t>(std::min(bytes, 1e18)), "openvdb: voxel_size_m",
                 fmt::format("voxels of {:.2g} m fit", 1.05 * settings.voxel_size_m * share));
}

std::unique_ptr<CollisionBackend> make_openvdb_backend(const Parameters& parameters) {
  const OpenvdbSettings settings{parameters.number("voxel_size_m"), parameters.number("band_voxels"),
                                 parameters.number("depth_m")};
  return make_point_backend(
      {.capabilities = {.has_cache = uses_clearance_cache(parameters)},
       .cache_needs_closed_bones = true,
       .require_fit = [settings](std::span<const Bone> bones) { require_fitting_voxels(bones, settings); },
       .contact_reach_m = [settings](const Bone& /*bone*/) { return 2 * settings.voxel_size_m; },
       .build = build_located(parameters, [settings](const Bone& bone, int threads, const ShareReport& /*report*/) {
         return std::make_unique<const OpenvdbBone>(bone, settings, threads);
       })});
}

}  // namespace

// How it is driven follows OpenVDB's cookbook ("Interpolation of grid values", on accessors) and its thread 903 on thin
// parts.
BackendEntry openvdb_entry() {
  return {
      .name = "openvdb",
      .help = "level set of cubic voxels over each bone by OpenVDB, interpolated linearly",
      .implementation = "OpenVDB " + std::to_string(OPENVDB_LIBRARY_MAJOR_VERSION_NUMBER) + "." +
                        std::to_string(OPENVDB_LIBRARY_MINOR_VERSION_NUMBER) + "." +
                        std::to_string(OPENVDB_LIBRARY_PATCH_VERSION_NUMBER) + ", MPL-2.0",
      .default_response = ResponseKind::project,
      .parameters = {parameter::number({.name = "voxel_size_m",
                                        .unit = "m",
                                        .default_value = 0.002,
                                        .minimum = 1e-6,
                                        .maximum = 1,
                                        .role = ParameterRole::resolution,
                                        .help = "edge length of the cubic voxels"}),
                     parameter::number({.name = "band_voxels",
                                        .default_value = 3,
                                        .minimum = 1,
                                        .maximum = 1000,
                                        .help = "voxels outside the bone that have distances"}),
                     parameter::number({.name = "depth_m",
                                        .unit = "m",
                                        .default_value = 0,
                                        .minimum = 0,
                                        .maximum = 10,
                                        .help = "how deep inside the bone voxels have distances; deeper nodes do not "
                                                "find out; 0: everywhere"}),
                     cull_parameter(), clearance_cache_parameter()},
      .make = make_openvdb_backend};
}

}  // namespace musclebench

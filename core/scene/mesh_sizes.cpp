#include "core/scene/mesh_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/percentile.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// No bone and no muscle of an animal is larger.
constexpr double largest_m = 2;
constexpr double smallest_m = 1e-3;
/// What a bone or a muscle measures: of two units that fit, the one that leads nearer to it is the likely one.
constexpr double typical_m = 0.2;

struct Unit {
  std::string_view name;
  std::string_view key;  ///< of a scene's `unit`
  double metres;
};
constexpr Unit units[] = {{"millimetres", "mm", 1e-3}, {"centimetres", "cm", 1e-2}};

struct MeasuredMesh {
  std::string name;             ///< "bone 'femur'"
  std::string location;         ///< of its table
  bool has_unit = false;        ///< from the scene, or a scale
  Eigen::AlignedBox3d box;      ///< without stray vertices
  int stray_vertices = 0;       ///< far from all others
  double stray_distance_m = 0;  ///< of the farthest one, from the middle of the others

  [[nodiscard]] double size_m() const { return box.diagonal().norm(); }
  [[nodiscard]] bool is_too_large() const { return size_m() > largest_m; }
};

Vec3 median_of(const std::vector<Vec3>& points) {
  Vec3 middle;
  std::vector<double> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), values.begin(), [&](const Vec3& p) { return p[axis]; });
    middle[axis] = median(values);
  }
  return middle;
}

/// The distance from the middle within which the mesh lies but for stray vertices: more than half of all lie within,
/// and no other one within ten times of it.
double radius_without_strays(std::vector<double> distances) {
  constexpr double gap = 10;
  const auto half = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), half, distances.end());
  const double farthest = *std::max_element(half, distances.end());
  if (farthest <= gap * *half) {
    return farthest;
  }
  std::sort(distances.begin(), distances.end());
  for (std::size_t i = distances.size() / 2; i + 1 < distances.size(); ++i) {
    if (distances[i] > 0 && distances[i + 1] > gap * distances[i]) {
      return distances[i];
    }
  }
  return distances.back();
}

MeasuredMesh measure(std::string name, const std::vector<Vec3>& vertices) {
  MeasuredMesh measured;
  measured.name = std::move(name);
  if (vertices.empty()) {
    return measured;
  }
  const Vec3 middle = median_of(vertices);
  std::vector<double> distances(vertices.size());
  std::transform(vertices.begin(), vertices.end(), distances.begin(),
                 [&](const Vec3& v) { return (v - middle).norm(); });
  const double radius_m = radius_without_strays(distances);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (distances[i] <= radius_m) {
      measured.box.extend(vertices[i]);
    } else {
      ++measured.stray_vertices;
      measured.stray_distance_m = std::max(measured.stray_distance_m, distances[i]);
    }
  }
  return measured;
}

std::vector<MeasuredMesh> measure(const Scene& scene) {
  std::vector<MeasuredMesh> meshes;
  const auto add = [&](std::string name, const std::vector<Vec3>& vertices, const SceneMesh* file) {
    MeasuredMesh& measured = meshes.emplace_back(measure(std::move(name), vertices));
    if (file == nullptr) return;
    measured.location = file->location;
    measured.has_unit = file->has_unit;
  };
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    add(fmt::format("bone '{}'", scene.bones[i].name), scene.bones[i].surface.mesh.vertices,
        i < scene.bone_meshes.size() ? &scene.bone_meshes[i] : nullptr);
  }
  for (const Muscle& muscle : scene.muscles) {
    add(fmt::format("muscle '{}'", muscle.body.name), scene.vertices_of(muscle.body), &muscle.file);
  }
  return meshes;
}

/// The unit that makes the mesh plausible; of several the one that leads to where the others are, then to a typical
/// size.
std::optional<Unit> likely_unit(const MeasuredMesh& mesh, const Eigen::AlignedBox3d& others) {
  std::optional<Unit> likely;
  double least = std::numeric_limits<double>::infinity();
  for (const Unit& unit : units) {
    const double size_m = mesh.size_m() * unit.metres;
    if (size_m > largest_m || size_m < smallest_m) {
      continue;
    }
    const Eigen::AlignedBox3d scaled(unit.metres * mesh.box.min(), unit.metres * mesh.box.max());
    const double gap = others.isEmpty() ? 0 : scaled.exteriorDistance(others) / others.diagonal().norm();
    constexpr double weight_of_gap = 10;
    const double doubt = std::abs(std::log(size_m / typical_m)) + weight_of_gap * gap;
    if (doubt < least) {
      least = doubt;
      likely = unit;
    }
  }
  return likely;
}

/// `where`: the table or tables that `unit` belongs into.
std::string unit_cure(const std::optional<Unit>& unit, std::string_view whose, std::string_view where) {
  return unit ? fmt::format("{} unit is likely {}: write unit = \"{}\" in {}", whose, unit->name, unit->key, where)
              : fmt::format("coordinates are metres: write the metres of {} unit as scale in {}", whose, where);
}

std::string table_of(const MeasuredMesh& mesh) {
  return mesh.location.empty() ? "its table" : fmt::format("its table ({})", mesh.location);
}

std::string cure_of_large(const MeasuredMesh& mesh, const Eigen::AlignedBox3d& plausible) {
  if (mesh.has_unit) return fmt::format("check unit and scale in {}", table_of(mesh));
  return unit_cure(likely_unit(mesh, plausible), "its", table_of(mesh));
}

void warn_of_units(const std::vector<MeasuredMesh>& meshes, std::vector<SceneWarning>& warnings) {
  Eigen::AlignedBox3d plausible;
  Eigen::AlignedBox3d all;
  for (const MeasuredMesh& mesh : meshes) {
    all.extend(mesh.box);
    if (!mesh.is_too_large()) {
      plausible.extend(mesh.box);
    }
  }
  if (plausible.isEmpty()) {
    std::vector<std::string> sizes;
    for (const MeasuredMesh& mesh : meshes) {
      sizes.push_back(fmt::format("{} {:.3g} m", mesh.name, mesh.size_m()));
    }
    const auto& largest = *std::ranges::max_element(meshes, {}, &MeasuredMesh::size_m);
    const std::string cure = std::ranges::any_of(meshes, &MeasuredMesh::has_unit)
                                 ? "check unit and scale of each"
                                 : unit_cure(likely_unit(largest, {}), "their", "each [[bone]] and [[muscle]]");
    warnings.push_back(
        {"unit", fmt::format("all meshes are implausibly large ({}): {}", fmt::join(sizes, ", "), cure)});
    return;
  }
  for (const MeasuredMesh& mesh : meshes) {
    if (mesh.is_too_large()) {
      warnings.push_back(
          {"unit", fmt::format("{} is {:.3g} m large, out of step with the other meshes ({:.3g} m): {}", mesh.name,
                               mesh.size_m(), plausible.diagonal().norm(), cure_of_large(mesh, plausible))});
    } else if (mesh.size_m() < smallest_m) {
      warnings.push_back(
          {"unit", fmt::format("{} is {:.3g} mm large: was it scaled to metres twice? Check {}{}", mesh.name,
                               1e3 * mesh.size_m(), mesh.has_unit ? "unit and scale in " : "", table_of(mesh))});
    }
  }
}

void warn_of_far_meshes(const std::vector<MeasuredMesh>& meshes, std::vector<SceneWarning>& warnings) {
  constexpr double far = 5;  // sizes
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const MeasuredMesh& mesh = meshes[i];
    if (mesh.stray_vertices > 0) {
      warnings.push_back(
          {"far_mesh",
           fmt::format("{} has {} {} far outside the rest of it, up to {:.3g} m away: check its coordinates", mesh.name,
                       mesh.stray_vertices, mesh.stray_vertices == 1 ? "vertex" : "vertices", mesh.stray_distance_m)});
    }
    Eigen::AlignedBox3d others;
    for (std::size_t j = 0; j < meshes.size(); ++j) {
      if (j != i) {
        others.extend(meshes[j].box);
      }
    }
    const bool is_said_of_the_muscle = meshes.size() == 2 && i == 0;
    if (mesh.box.isEmpty() || others.isEmpty() || is_said_of_the_muscle || mesh.is_too_large() ||
        others.diagonal().norm() > largest_m) {
      continue;  // where a unit is wrong, that is to be mended first
    }
    const double gap_m = mesh.box.exteriorDistance(others);
    if (gap_m > far * std::max(mesh.size_m(), others.diagonal().norm())) {
      warnings.push_back(
          {"far_mesh", fmt::format("{} is {:.3g} m away from the other meshes: are they in one frame and unit?",
                                   mesh.name, gap_m)});
    }
  }
}

void warn_of_far_centres(const Scene& scene, const std::vector<MeasuredMesh>& meshes,
                         std::vector<SceneWarning>& warnings) {
  Eigen::AlignedBox3d all;
  for (const MeasuredMesh& mesh : meshes) {
    all.extend(mesh.box);
  }
  constexpr double far = 10;  // sizes
  for (std::size_t bone = 0; bone < scene.motions.size() && !all.isEmpty(); ++bone) {
    for (const BoneRotation& rotation : scene.motions[bone].rotations) {
      const double distance_m = all.exteriorDistance(rotation.centre_m);
      if (distance_m > far * all.diagonal().norm()) {
        warnings.push_back(
            {"far_centre", fmt::format("bone '{}' turns about a point {:.3g} m away from all meshes: check centre_m",
                                       scene.bones[bone].name, distance_m)});
      }
    }
  }
}

}  // namespace

std::optional<std::string> size_warning(const TriangleMesh& mesh) {
  const MeasuredMesh measured = measure("it", mesh.vertices);
  if (measured.is_too_large()) {
    return fmt::format("it is {:.3g} m large: {}", measured.size_m(),
                       unit_cure(likely_unit(measured, {}), "its", "the scene's table that names it"));
  }
  if (measured.size_m() >= smallest_m) return std::nullopt;
  return fmt::format("it is {:.3g} mm large: was it scaled to metres twice?", 1e3 * measured.size_m());
}

std::vector<SceneWarning> size_warnings(const Scene& scene) {
  const std::vector<MeasuredMesh> meshes = measure(scene);
  std::vector<SceneWarning> warnings;
  warn_of_units(meshes, warnings);
  warn_of_far_meshes(meshes, warnings);
  warn_of_far_centres(scene, meshes, warnings);
  return warnings;
}

}  // namespace musclebench

#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// A body of a random scene: a shape, what is wrong with its mesh, and its place.
struct FuzzBody {
  std::string shape;
  std::string defect;  ///< empty: none
  double scale = 1;
  RigidMotion place = {};
  // Of a bone that turns; 0 degrees: it stands still.
  double to_deg = 0;
  Vec3 axis = Vec3::UnitX();
  Vec3 centre_m = Vec3::Zero();
  std::vector<double> table_deg = {};  ///< its angles, from a table; empty: evenly to `to_deg`
  std::string backend = {};            ///< of a bone that has one of its own
  bool has_fibres = false;             ///< of a muscle, between its attachments
};

/// Nodes of a muscle near a bone are bound to it, on the side that they look at each other from.
struct FuzzAttachment {
  std::size_t muscle = 0;
  std::size_t bone = 0;
  double distance_m = 0;
};

/// A random scene, small enough that a thousand of them run in some minutes. What it lists can be left out piece by
/// piece.
struct FuzzScene {
  std::uint64_t seed = 0;
  std::string backend;
  std::vector<FuzzBody> muscles;
  std::vector<FuzzBody> bones;
  std::vector<FuzzAttachment> attachments;
  bool muscle_contact = false;
  std::string response;  ///< empty: the backend's own
  std::map<std::string, ParameterValue> loop;
  std::map<std::string, std::map<std::string, ParameterValue>> effects;  ///< by name
};

/// The same for the same seed and the same registry of effects, on every machine. `backends`: to choose from.
FuzzScene fuzz_scene(std::uint64_t seed, const std::vector<std::string>& backends);

/// By reference in `text_of`: "muscle_0", "bone_0", ...
std::map<std::string, TriangleMesh> meshes_of(const FuzzScene& scene);
/// By name of their bone: files of motion.
std::map<std::string, std::string> tables_of(const FuzzScene& scene);
/// As a scene file; a mesh's reference is its name between `prefix` and `suffix`, a table's between `tables` and .mot.
std::string text_of(const FuzzScene& scene, const std::string& prefix, const std::string& suffix,
                    const std::string& tables = "");
/// Throws InputError where it can't be run, as any scene.
Scene read_fuzz_scene(const FuzzScene& scene);

/// The scene without one of the pieces that it may be without: a muscle, a bone, an attachment, a defect, an effect, a
/// given parameter, half of the frames. Those that take out most come first.
std::vector<FuzzScene> smaller_scenes(const FuzzScene& scene);

/// scene.toml, its meshes (PLY) and tables in `folder`, which is made: what `run` takes. Throws InputError.
void write_fuzz_scene(const FuzzScene& scene, const std::filesystem::path& folder);

}  // namespace musclebench

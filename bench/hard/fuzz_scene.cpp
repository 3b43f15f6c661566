#include "bench/hard/fuzz_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <ostream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/base/atomic_file.hpp"
#include "core/base/portable_math.hpp"
#include "core/base/random_numbers.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/scene/read_scene.hpp"
#include "datasets/hard/hard_shapes.hpp"

namespace musclebench {

namespace {

struct Shape {
  std::string_view name;
  TriangleMesh (*make)();
  bool is_muscle;  ///< smooth enough for one
};

constexpr std::array shapes = {
    Shape{"coarse_ball", [] { return make_sphere(0.025, 1); }, true},
    Shape{"ball", [] { return make_sphere(0.025, 2); }, true},
    Shape{"bumpy_ball", [] { return make_bumpy_ball(2); }, true},
    Shape{"box", [] { return make_box(Vec3(0.02, 0.03, 0.015), 3); }, true},
    Shape{"capsule", [] { return make_capsule(0.01, 0.03, 10); }, true},
    Shape{"spike", make_spike, false},
    Shape{"thin_plate", [] { return make_plate(0.0005); }, false},
    Shape{"plate", [] { return make_plate(0.005); }, false},
};
constexpr std::array<std::string_view, 6> defects = {"",           "hole", "bad_triangles",
                                                     "inside_out", "soup", "unused_vertices"};

/// Each triangle with corners of its own, as in STL.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh result;
  for (const Triangle& triangle : mesh.triangles) {
    const int first = static_cast<int>(result.vertices.size());
    for (const int vertex : triangle) result.vertices.push_back(mesh.vertices[static_cast<std::size_t>(vertex)]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

TriangleMesh spoilt(TriangleMesh mesh, std::string_view defect) {
  if (defect == "hole") return with_hole(mesh, 1, Vec3(0.3, 0.5, 0.8));
  if (defect == "bad_triangles") return with_bad_triangles(mesh);
  if (defect == "inside_out") return inside_out(std::move(mesh));
  if (defect == "soup") return soup(mesh);
  if (defect == "unused_vertices") mesh.vertices.insert(mesh.vertices.end(), 7, Vec3(0.3, -0.2, 0.1));
  return mesh;
}

TriangleMesh mesh_of(const FuzzBody& body) {
  TriangleMesh mesh = spoilt(std::ranges::find(shapes, body.shape, &Shape::name)->make(), body.defect);
  for (Vec3& vertex : mesh.vertices) vertex = body.place.apply(body.scale * vertex);
  return mesh;
}

/// Draws what scenes are made of.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : m_random(seed) {}

  bool chance(double share) { return m_random.share() < share; }
  double between(double low, double high) { return low + (high - low) * m_random.share(); }
  /// Evenly by magnitude; both above 0.
  double by_magnitude(double low, double high) { return low * portable::pow(high / low, m_random.share()); }
  template <typename Range>
  const auto& one_of(const Range& range) {
    return range[m_random.below(std::size(range))];
  }
  Vec3 direction() {
    const double z = between(-1, 1);
    const double angle = between(0, 2 * std::numbers::pi);
    const double radius = std::sqrt(1 - z * z);
    return {radius * portable::cos(angle), radius * portable::sin(angle), z};
  }
  RigidMotion place(double reach_m) {
    // One after the other: a compiler may evaluate operands in any order.
    const double distance_m = between(0, reach_m);
    const Vec3 towards = direction();
    const Vec3 axis = direction();
    const double angle_rad = between(0, 2 * std::numbers::pi);
    return RigidMotion{Mat3::Identity(), distance_m * towards} * RigidMotion::about_axis(axis, Vec3::Zero(), angle_rad);
  }

  /// One of its limits, its default or something between.
  ParameterValue value_of(const ParameterSpec& spec) {
    if (spec.kind == ParameterKind::flag) return chance(0.5);
    if (spec.kind == ParameterKind::choice) return one_of(spec.choices);
    if (!spec.has_range()) return spec.default_value;
    const double low = spec.minimum;
    const double high = spec.maximum;
    const double kind = m_random.share();
    double value = kind < 0.2 ? low : kind < 0.4 ? high : between(low, std::min(high, low + 1));
    if (kind > 0.7 && high > 0) value = by_magnitude(std::max(low, high * 1e-9), high);
    if (spec.kind == ParameterKind::integer)
      return static_cast<std::int64_t>(std::clamp(value, low, std::min(high, 100.0)));
    return value;
  }

 private:
  RandomNumbers m_random;
};

FuzzBody fuzz_bone(Dice& dice) {
  FuzzBody bone;
  bone.shape = dice.one_of(shapes).name;
  if (dice.chance(0.4)) bone.defect = dice.one_of(defects);
  bone.scale = dice.by_magnitude(0.3, 3);
  bone.place = dice.place(0.06);
  if (dice.chance(0.7)) {
    bone.to_deg = dice.by_magnitude(0.01, 180);  // in 25 or 50 frames: from creeping to tunnelling
    bone.axis = dice.direction();
    const double distance_m = dice.between(0, 0.1);
    bone.centre_m = distance_m * dice.direction();
  }
  return bone;
}

std::string toml_of(const ParameterValue& value) {
  if (std::holds_alternative<std::string>(value)) return '"' + std::get<std::string>(value) + '"';
  if (std::holds_alternative<double>(value)) {
    const std::string text = fmt::format("{}", std::get<double>(value));
    return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
  }
  return format_parameter_value(value);
}

std::string toml_of(const Vec3& vector) {
  return fmt::format("[{}, {}, {}]", toml_of(ParameterValue(vector.x())), toml_of(ParameterValue(vector.y())),
                     toml_of(ParameterValue(vector.z())));
}

std::string table_of(const std::map<std::string, ParameterValue>& values) {
  std::string text;
  for (const auto& [key, value] : values) text += fmt::format("{} = {}\n", key, toml_of(value));
  return text;
}

std::string bone_name(std::size_t index) { return fmt::format("bone_{}", index); }

}  // namespace

FuzzScene fuzz_scene(std::uint64_t seed, const std::vector<std::string>& backends) {
  Dice dice(seed);
  FuzzScene scene;
  scene.seed = seed;
  scene.backend = dice.one_of(backends);
  do {
    scene.muscle.shape = dice.one_of(shapes).name;
  } while (!std::ranges::find(shapes, scene.muscle.shape, &Shape::name)->is_muscle);
  if (dice.chance(0.2)) scene.muscle.defect = dice.chance(0.5) ? "soup" : "unused_vertices";
  scene.muscle.scale = dice.by_magnitude(0.5, 2);
  const double crowd = dice.between(0, 1);
  const int bones = crowd < 0.5 ? 1 : crowd < 0.9 ? 2 : 3;
  for (int i = 0; i < bones; ++i) scene.bones.push_back(fuzz_bone(dice));
  scene.loop = {{"frames", std::int64_t{50}},
                {"substeps", std::int64_t{1} + (dice.chance(0.5) ? 3 : 0)},
                {"iterations", std::int64_t{1} + (dice.chance(0.3) ? 9 : 0)},
                {"time_step_s", dice.by_magnitude(1e-5, 1)},
                {"start_noise_m", dice.chance(0.3) ? dice.by_magnitude(1e-9, 1e-3) : 0.0}};
  for (const EffectEntry& entry : effect_registry()) {
    if (!dice.chance(0.35)) continue;
    std::map<std::string, ParameterValue>& values = scene.effects[entry.name];
    for (const ParameterSpec& spec : entry.parameters) {
      if (dice.chance(0.3)) values[spec.name] = dice.value_of(spec);
    }
  }
  return scene;
}

std::map<std::string, TriangleMesh> meshes_of(const FuzzScene& scene) {
  std::map<std::string, TriangleMesh> meshes = {{"muscle", mesh_of(scene.muscle)}};
  for (std::size_t i = 0; i < scene.bones.size(); ++i) meshes[bone_name(i)] = mesh_of(scene.bones[i]);
  return meshes;
}

std::string text_of(const FuzzScene& scene, const std::string& prefix, const std::string& suffix) {
  std::string text = fmt::format("# A random scene (seed {}), for the backend {}.\ntitle = \"random scene {}\"\n",
                                 scene.seed, scene.backend, scene.seed);
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    const FuzzBody& bone = scene.bones[i];
    text += fmt::format("\n[[bone]]\nname = \"{0}\"\nmesh = \"{1}{0}{2}\"\n", bone_name(i), prefix, suffix);
    if (bone.to_deg != 0) {
      text += fmt::format("[bone.motion]\naxis = {}\ncentre_m = {}\nfrom_deg = 0.0\nto_deg = {}\n", toml_of(bone.axis),
                          toml_of(bone.centre_m), toml_of(ParameterValue(bone.to_deg)));
    }
  }
  text += fmt::format("\n[muscle]\nname = \"muscle\"\nmesh = \"{}muscle{}\"\n\n[loop]\n{}", prefix, suffix,
                      table_of(scene.loop));
  for (const auto& [name, values] : scene.effects) text += fmt::format("\n[effects.{}]\n{}", name, table_of(values));
  return text;
}

Scene read_fuzz_scene(const FuzzScene& scene) {
  const std::map<std::string, TriangleMesh> meshes = meshes_of(scene);
  SceneRequest request;
  request.name = fmt::format("seed_{}", scene.seed);
  request.file = request.name + ".toml";
  request.text = text_of(scene, "synthetic:", "");
  request.synthetic_mesh = [&](const std::string& name) { return meshes.at(name); };
  return read_scene(request);
}

std::vector<FuzzScene> smaller_scenes(const FuzzScene& scene) {
  std::vector<FuzzScene> smaller;
  const auto without = [&](const std::function<void(FuzzScene&)>& remove) {
    FuzzScene other = scene;
    remove(other);
    smaller.push_back(std::move(other));
  };
  for (std::size_t i = 0; i < scene.bones.size() && scene.bones.size() > 1; ++i) {
    without([&](FuzzScene& other) { other.bones.erase(other.bones.begin() + static_cast<std::ptrdiff_t>(i)); });
  }
  for (const auto& effect : scene.effects) {
    without([&](FuzzScene& other) { other.effects.erase(effect.first); });
    for (const auto& given : effect.second) {
      without([&](FuzzScene& other) { other.effects[effect.first].erase(given.first); });
    }
  }
  const auto frames = std::get<std::int64_t>(scene.loop.at("frames"));
  if (frames > 2) without([&](FuzzScene& other) { other.loop["frames"] = frames / 2; });
  for (const auto& given : scene.loop) {
    if (given.first != "frames") without([&](FuzzScene& other) { other.loop.erase(given.first); });
  }
  if (!scene.muscle.defect.empty()) without([](FuzzScene& other) { other.muscle.defect.clear(); });
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    if (!scene.bones[i].defect.empty()) without([&](FuzzScene& other) { other.bones[i].defect.clear(); });
    if (scene.bones[i].to_deg != 0) without([&](FuzzScene& other) { other.bones[i].to_deg = 0; });
  }
  return smaller;
}

void write_fuzz_scene(const FuzzScene& scene, const std::filesystem::path& folder) {
  for (const auto& [name, mesh] : meshes_of(scene)) {
    write_ply(mesh, folder / (name + ".ply"));
  }
  write_atomically(folder / "scene.toml", [&](std::ostream& out) { out << text_of(scene, "", ".ply"); });
}

}  // namespace musclebench

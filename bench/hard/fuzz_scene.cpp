#include "bench/hard/fuzz_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <ostream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/base/atomic_file.hpp"
#include "core/base/input_error.hpp"
#include "core/base/portable_math.hpp"
#include "core/base/random_numbers.hpp"
#include "core/base/temporary_folder.hpp"
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
std::string muscle_name(std::size_t index) { return fmt::format("muscle_{}", index); }

FuzzBody fuzz_muscle(Dice& dice) {
  FuzzBody muscle;
  do {
    muscle.shape = dice.one_of(shapes).name;
  } while (!std::ranges::find(shapes, muscle.shape, &Shape::name)->is_muscle);
  if (dice.chance(0.2)) muscle.defect = dice.chance(0.5) ? "soup" : "unused_vertices";
  muscle.scale = dice.by_magnitude(0.5, 2);
  return muscle;
}

void draw_tables_and_backends(Dice& dice, const std::vector<std::string>& backends, std::vector<FuzzBody>& bones) {
  for (FuzzBody& bone : bones) {
    if (bone.to_deg != 0 && dice.chance(0.3)) {
      const int rows = 2 + static_cast<int>(dice.between(0, 6));
      for (int row = 0; row < rows; ++row) bone.table_deg.push_back(dice.between(-1, 1) * bone.to_deg);
    }
    if (dice.chance(0.15)) bone.backend = dice.one_of(backends);
  }
}

void draw_attachments(Dice& dice, FuzzScene& scene) {
  for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
    for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
      if (dice.chance(0.4)) scene.attachments.push_back({muscle, bone, dice.by_magnitude(1e-3, 2e-2)});
    }
    scene.muscles[muscle].has_fibres = dice.chance(0.2);
  }
}

/// Corners of a square between the two bodies that faces both.
std::string outline_of(const Vec3& from, const Vec3& to) {
  const Vec3 between = to - from;
  const Vec3 along = between.norm() > 1e-6 ? Vec3(between.normalized()) : Vec3(Vec3::UnitZ());
  const Vec3 side = along.unitOrthogonal();
  const Vec3 up = along.cross(side);
  const Vec3 centre = 0.5 * (from + to);
  constexpr double half_m = 0.05;
  std::string text;
  for (const auto& [a, b] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
    text += (text.empty() ? "" : ", ") + toml_of(Vec3(centre + half_m * (a * side + b * up)));
  }
  return text;
}

}  // namespace

FuzzScene fuzz_scene(std::uint64_t seed, const std::vector<std::string>& backends) {
  Dice dice(seed);
  FuzzScene scene;
  scene.seed = seed;
  scene.backend = dice.one_of(backends);
  scene.muscles.push_back(fuzz_muscle(dice));
  while (scene.muscles.size() < 3 && dice.chance(0.25)) {
    scene.muscles.push_back(fuzz_muscle(dice));
    scene.muscles.back().place = dice.place(0.08);
  }
  scene.muscle_contact = scene.muscles.size() > 1 && dice.chance(0.7);
  const double crowd = dice.between(0, 1);
  const int bones = crowd < 0.5 ? 1 : crowd < 0.9 ? 2 : 3;
  for (int i = 0; i < bones; ++i) scene.bones.push_back(fuzz_bone(dice));
  draw_tables_and_backends(dice, backends, scene.bones);
  if (dice.chance(0.5)) draw_attachments(dice, scene);
  if (dice.chance(0.2)) scene.response = dice.chance(0.5) ? "project" : "backtrack";
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
  std::map<std::string, TriangleMesh> meshes;
  for (std::size_t i = 0; i < scene.muscles.size(); ++i) meshes[muscle_name(i)] = mesh_of(scene.muscles[i]);
  for (std::size_t i = 0; i < scene.bones.size(); ++i) meshes[bone_name(i)] = mesh_of(scene.bones[i]);
  return meshes;
}

std::map<std::string, std::string> tables_of(const FuzzScene& scene) {
  std::map<std::string, std::string> tables;
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    const std::vector<double>& angles_deg = scene.bones[i].table_deg;
    if (scene.bones[i].to_deg == 0 || angles_deg.empty()) continue;
    std::string& text = tables[bone_name(i)];
    text = fmt::format("random\nnRows={}\nnColumns=2\ninDegrees=yes\nendheader\ntime\tangle\n", angles_deg.size());
    for (std::size_t row = 0; row < angles_deg.size(); ++row) text += fmt::format("{}\t{}\n", row, angles_deg[row]);
  }
  return tables;
}

namespace {

std::string bone_text(const FuzzScene& scene, std::size_t index, const std::string& mesh, const std::string& tables) {
  const FuzzBody& bone = scene.bones[index];
  std::string text = fmt::format("\n[[bone]]\nname = \"{}\"\nmesh = \"{}\"\n", bone_name(index), mesh);
  if (!bone.backend.empty()) text += fmt::format("backend = \"{}\"\n", bone.backend);
  if (bone.to_deg == 0) return text;
  text += fmt::format("[bone.motion]\naxis = {}\ncentre_m = {}\n", toml_of(bone.axis), toml_of(bone.centre_m));
  return text + (bone.table_deg.empty()
                     ? fmt::format("from_deg = 0.0\nto_deg = {}\n", toml_of(ParameterValue(bone.to_deg)))
                     : fmt::format("table = \"{}{}.mot\"\ncolumn = \"angle\"\n", tables, bone_name(index)));
}

/// Files, for as long as a scene is read.
class TemporaryTables {
 public:
  explicit TemporaryTables(const FuzzScene& scene) {
    const std::map<std::string, std::string> tables = tables_of(scene);
    if (tables.empty()) return;
    m_folder.emplace();
    for (const auto& [bone, text] : tables) {
      write_atomically(*m_folder / (bone + ".mot"), [&text = text](std::ostream& out) { out << text; });
    }
  }
  [[nodiscard]] std::string prefix() const { return m_folder ? m_folder->path().string() + "/" : ""; }

 private:
  std::optional<TemporaryFolder> m_folder;
};

std::string attachment_text(const FuzzScene& scene, std::size_t index) {
  const FuzzAttachment& attachment = scene.attachments[index];
  return fmt::format(
      "\n[[attachment]]\nname = \"area_{}\"\nbone = \"{}\"\nmuscle = \"{}\"\ndistance_m = {}\noutline_m = [{}]\n",
      index, bone_name(attachment.bone), muscle_name(attachment.muscle), toml_of(ParameterValue(attachment.distance_m)),
      outline_of(scene.bones[attachment.bone].place.translation_m,
                 scene.muscles[attachment.muscle].place.translation_m));
}

}  // namespace

std::string text_of(const FuzzScene& scene, const std::string& prefix, const std::string& suffix,
                    const std::string& tables) {
  std::string text = fmt::format("# A random scene (seed {}), for the backend {}.\ntitle = \"random scene {}\"\n",
                                 scene.seed, scene.backend, scene.seed);
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    text += bone_text(scene, i, prefix + bone_name(i) + suffix, tables);
  }
  for (std::size_t i = 0; i < scene.muscles.size(); ++i) {
    text += fmt::format("\n[[muscle]]\nname = \"{0}\"\nmesh = \"{1}{0}{2}\"\n{3}", muscle_name(i), prefix, suffix,
                        scene.muscles[i].has_fibres ? "fibres = \"between_attachments\"\n" : "");
  }
  for (std::size_t i = 0; i < scene.attachments.size(); ++i) text += attachment_text(scene, i);
  if (scene.muscle_contact || !scene.response.empty()) text += "\n[contact]\n";
  if (scene.muscle_contact) text += "muscle_contact = true\n";
  if (!scene.response.empty()) text += fmt::format("response = \"{}\"\n", scene.response);
  text += "\n[loop]\n" + table_of(scene.loop);
  for (const auto& [name, values] : scene.effects) text += fmt::format("\n[effects.{}]\n{}", name, table_of(values));
  return text;
}

Scene read_fuzz_scene(const FuzzScene& scene) {
  const std::map<std::string, TriangleMesh> meshes = meshes_of(scene);
  const TemporaryTables tables(scene);
  SceneRequest request;
  request.name = fmt::format("seed_{}", scene.seed);
  request.file = request.name + ".toml";
  request.text = text_of(scene, "synthetic:", "", tables.prefix());
  request.synthetic_mesh = [&](const std::string& name) { return meshes.at(name); };
  return read_scene(request);
}

namespace {

/// A body with its attachments, whose others are numbered anew.
void leave_out(std::size_t index, std::vector<FuzzBody>& bodies, std::size_t FuzzAttachment::*of,
               std::vector<FuzzAttachment>& attachments) {
  bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(index));
  std::erase_if(attachments, [&](const FuzzAttachment& attachment) { return attachment.*of == index; });
  for (FuzzAttachment& attachment : attachments) attachment.*of -= attachment.*of > index ? 1 : 0;
}

}  // namespace

std::vector<FuzzScene> smaller_scenes(const FuzzScene& scene) {
  std::vector<FuzzScene> smaller;
  const auto without = [&](const std::function<void(FuzzScene&)>& remove) {
    FuzzScene other = scene;
    remove(other);
    smaller.push_back(std::move(other));
  };
  for (std::size_t i = 0; i < scene.muscles.size() && scene.muscles.size() > 1; ++i) {
    without([&](FuzzScene& other) { leave_out(i, other.muscles, &FuzzAttachment::muscle, other.attachments); });
  }
  for (std::size_t i = 0; i < scene.bones.size() && scene.bones.size() > 1; ++i) {
    without([&](FuzzScene& other) { leave_out(i, other.bones, &FuzzAttachment::bone, other.attachments); });
  }
  for (std::size_t i = 0; i < scene.attachments.size(); ++i) {
    without([&](FuzzScene& other) { other.attachments.erase(other.attachments.begin() + static_cast<long>(i)); });
  }
  if (scene.muscle_contact) without([](FuzzScene& other) { other.muscle_contact = false; });
  if (!scene.response.empty()) without([](FuzzScene& other) { other.response.clear(); });
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
  for (std::size_t i = 0; i < scene.muscles.size(); ++i) {
    if (!scene.muscles[i].defect.empty()) without([&](FuzzScene& other) { other.muscles[i].defect.clear(); });
    if (scene.muscles[i].has_fibres) without([&](FuzzScene& other) { other.muscles[i].has_fibres = false; });
  }
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    if (!scene.bones[i].defect.empty()) without([&](FuzzScene& other) { other.bones[i].defect.clear(); });
    if (scene.bones[i].to_deg != 0) without([&](FuzzScene& other) { other.bones[i].to_deg = 0; });
    if (!scene.bones[i].table_deg.empty()) without([&](FuzzScene& other) { other.bones[i].table_deg.clear(); });
    if (!scene.bones[i].backend.empty()) without([&](FuzzScene& other) { other.bones[i].backend.clear(); });
  }
  return smaller;
}

void write_fuzz_scene(const FuzzScene& scene, const std::filesystem::path& folder) {
  for (const auto& [name, mesh] : meshes_of(scene)) {
    write_ply(mesh, folder / (name + ".ply"));
  }
  for (const auto& [bone, text] : tables_of(scene)) {
    write_atomically(folder / (bone + ".mot"), [&, &table = text](std::ostream& out) { out << table; });
  }
  write_atomically(folder / "scene.toml", [&](std::ostream& out) { out << text_of(scene, "", ".ply"); });
}

}  // namespace musclebench

#include "core/scene/read_scene.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/morton_order.hpp"
#include "core/mesh/split_mesh.hpp"
#include "core/mesh/surface_volume.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/mesh_repair/weld_mesh.hpp"
#include "core/scene/effect_override.hpp"
#include "core/scene/landmarks.hpp"
#include "core/scene/read_attachments.hpp"
#include "core/scene/read_contact.hpp"
#include "core/scene/read_measure.hpp"
#include "core/scene/read_motion.hpp"
#include "core/scene/read_placement.hpp"
#include "core/scene/read_retinacula.hpp"
#include "core/scene/scene_warnings.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {

namespace {

std::string sha256_of(const TriangleMesh& mesh) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(mesh.vertices)));
  hash.add(std::as_bytes(std::span(mesh.triangles)));
  return hash.hex_digest();
}

std::string mesh_location(const TomlTable& table, const SceneMesh& mesh) {
  return fmt::format("{} ({})", table.location("mesh"), mesh.reference);
}

/// Into metres and the scene's frame.
void place_mesh(const TomlTable& table, SceneMesh& mesh) {
  mesh.placement = read_placement(table);
  mesh.placement.apply_to(mesh.mesh.vertices);
  if (std::ranges::all_of(mesh.mesh.vertices, [](const Vec3& vertex) { return vertex.allFinite(); })) return;
  throw InputError(mesh_location(table, mesh), "has coordinates that are too large once they are scaled; check scale");
}

SceneMesh read_scene_mesh(const SceneRequest& request, const TomlTable& table) {
  SceneMesh result;
  result.reference = table.word("mesh");
  result.location = table.place();
  result.has_unit = table.has("unit") || table.has("scale");
  static const std::string synthetic_prefix = "synthetic:";
  result.mesh = read_at(table.location("mesh"), [&] {
    return result.reference.starts_with(synthetic_prefix)
               ? request.synthetic_mesh(result.reference.substr(synthetic_prefix.size()))
               : read_mesh(resolve_reference(request, result.reference, table.location("mesh")).path);
  });
  place_mesh(table, result);
  result.sha256 = sha256_of(result.mesh);
  return result;
}

/// Before each is split in four `times` times.
void require_few_triangles(const TomlTable& table, const SceneMesh& mesh, int times) {
  constexpr std::size_t most = 20'000'000;
  const std::size_t triangles = mesh.mesh.triangles.size() << (2 * times);
  if (triangles <= most) return;
  throw InputError(mesh_location(table, mesh),
                   fmt::format("would have {} triangles after [meshes], more than {}; split "
                               "it less often",
                               triangles, most));
}

/// The keys of a body's table: `own`, and those that place its mesh.
std::vector<std::string> body_keys(std::vector<std::string> own) {
  own.insert(own.end(), placement_keys.begin(), placement_keys.end());
  return own;
}

/// Names become file names.
std::string checked_name(const TomlTable& table) {
  std::string name = table.word("name");
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  });
  if (!plain || name.front() == '.') {
    throw InputError(table.location("name"), fmt::format("'{}' may hold letters, digits, '_', '-' and '.' only", name));
  }
  return name;
}

/// Every muscle has a row with every bone, and two muscles may touch: memory grows with the square of what a file of a
/// few megabytes can list.
std::vector<TomlTable> few_enough(std::vector<TomlTable> bodies, const TomlTable& root, std::string_view key) {
  constexpr std::size_t most_bodies = 1000;
  if (bodies.size() > most_bodies) {
    throw InputError(root.location(key), fmt::format("lists {} of them, and a scene has at most {}; leave some out",
                                                     bodies.size(), most_bodies));
  }
  return bodies;
}

/// A sheet, or a surface that runs back over itself: nothing could be inside. A cube has 0.07 of what is divided by, a
/// plate a hundred times as wide as thick some 0.003.
void require_volume(const TomlTable& table, const SceneMesh& file, const TriangleMesh& mesh) {
  constexpr double least = 1e-7;
  const double volume_m3 = surface_volume_m3(mesh.vertices, mesh.triangles);
  if (std::abs(volume_m3) > least * std::pow(surface_area_m2(mesh), 1.5)) return;
  throw InputError(mesh_location(table, file),
                   "encloses no volume, so that nothing can be in it: the mesh is a sheet; give it a thickness");
}

/// Two of one mesh lie in one place, and contact between them has no side to push to.
void refuse_same_mesh(const TomlTable& table, const SceneMesh& file, const Scene& scene) {
  for (const Muscle& other : scene.muscles) {
    if (other.file.sha256 != file.sha256) continue;
    throw InputError(mesh_location(table, file),
                     fmt::format("is the mesh of muscle '{}', too, in the same place; name another, or leave one out",
                                 other.body.name));
  }
}

void read_bones(const SceneRequest& request, const TomlTable& root, Scene& scene) {
  for (const TomlTable& table : few_enough(root.tables("bone"), root, "bone")) {
    table.allow_only(body_keys({"name", "mesh", "motion", "backend", "parameters", "response", "steps"}));
    const std::string name = checked_name(table);
    for (const Bone& bone : scene.bones) {
      if (bone.name == name) {
        throw InputError(table.location("name"),
                         fmt::format("'{}' is the name of an earlier bone; choose another", name));
      }
    }
    SceneMesh mesh = read_scene_mesh(request, table);
    Bone bone{name, repair_mesh(mesh.mesh, mesh_location(table, mesh))};
    if (const int times = scene.mesh_splits.smooth_bones; times > 0) {
      // A repaired surface is wound alike, which tells where it is smooth.
      require_few_triangles(table, mesh, times);
      bone.surface.mesh = split_curved(bone.surface.mesh, times);
    }
    // What is near a node is then in few pages and cache lines, whatever order a file has.
    sort_in_morton_order(bone.surface.mesh);
    require_volume(table, mesh, bone.surface.mesh);
    scene.bones.push_back(std::move(bone));
    scene.bone_meshes.push_back(std::move(mesh));
    scene.bone_contacts.push_back(read_bone_contact(table));
    scene.motions.push_back(read_motion(request, table));
  }
  if (scene.bones.empty()) {
    throw InputError(fmt::format("{}: bone", request.file), "is missing; a scene needs at least one [[bone]]");
  }
}

void read_fibres(const SceneRequest& request, const TomlTable& table, std::size_t index, Scene& scene) {
  Muscle& muscle = scene.muscles[index];
  const std::string fibres = table.word_or("fibres", "none");
  if (fibres == "between_attachments") {
    muscle.fibres_between_attachments = true;
    if (!scene.attach_at_first_contact && scene.fibres_with(scene.bound_nodes())[index].empty()) {
      const InputError obstacle(table.location("fibres"), describe_missing_fibres(scene, index));
      if (!request.notes_obstacles) {
        throw obstacle;
      }
      scene.obstacles.emplace_back(obstacle.what());
    }
  } else if (fibres != "none") {
    const std::string location = table.location("fibres");
    const SceneReference reference = resolve_reference(request, fibres, location);
    if (reference.selector.empty()) {
      throw InputError(location, fmt::format("'{}' has to be none, between_attachments or FILE#MUSCLE; did you mean "
                                             "'{}'?",
                                             fibres, nearest_word(fibres, {"none", "between_attachments"})));
    }
    muscle.fibres = read_at(
        location, [&] { return read_landmark_fibres(reference.path, reference.selector, muscle.file.placement); });
  }
}

void read_mass_velocity_and_activation(const TomlTable& table, Muscle& muscle) {
  if (table.has("activation")) muscle.body.activation = table.number("activation", 0, 1);
  if (table.has("density_kg_per_m3")) muscle.density_kg_per_m3 = table.number("density_kg_per_m3", 1e-6, 1e12);
  if (!table.has("velocity_m_per_s")) return;
  constexpr double fastest_m_per_s = 1e6;
  muscle.velocity_m_per_s = table.point("velocity_m_per_s");
  if (!(muscle.velocity_m_per_s.norm() <= fastest_m_per_s)) {
    throw InputError(table.location("velocity_m_per_s"),
                     fmt::format("is faster than {:g} m/s; give metres a second", fastest_m_per_s));
  }
}

void read_muscles(const SceneRequest& request, const TomlTable& root, Scene& scene) {
  const std::vector<TomlTable> tables = few_enough(root.table_or_tables("muscle"), root, "muscle");
  for (const TomlTable& table : tables) {
    table.allow_only(body_keys({"name", "mesh", "fibres", "density_kg_per_m3", "velocity_m_per_s", "activation"}));
    const std::string name = checked_name(table);
    if (std::ranges::any_of(scene.muscles, [&](const Muscle& other) { return other.body.name == name; })) {
      throw InputError(table.location("name"),
                       fmt::format("'{}' is the name of an earlier muscle; choose another", name));
    }
    if (tables.size() > 1 && std::ranges::find(scene.bones, name, &Bone::name) != scene.bones.end()) {
      // A pair MUSCLE/OTHER could not tell which is meant.
      throw InputError(table.location("name"), fmt::format("'{}' is the name of a bone; choose another", name));
    }
    SceneMesh file = read_scene_mesh(request, table);
    if (const int times = scene.mesh_splits.split_muscles; times > 0) {
      // Before welding, so that the vertices of the file stay the first ones of what a run writes.
      require_few_triangles(table, file, times);
      file.mesh = split_flat(std::move(file.mesh), times);
    }
    refuse_same_mesh(table, file, scene);
    WeldedMesh welded = weld_mesh(file.mesh, mesh_location(table, file));
    Muscle& muscle = scene.add_muscle(name, welded.mesh);
    muscle.file = std::move(file);
    muscle.changes = std::move(welded.changes);
    muscle.node_of_vertex = std::move(welded.welded_vertex);
    read_mass_velocity_and_activation(table, muscle);
    for (int& node : muscle.node_of_vertex) {
      node += node < 0 ? 0 : muscle.body.first_node;
    }
  }
  read_attachments(request, root, scene);
  read_retinacula(root, scene);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    read_fibres(request, tables[i], i, scene);
  }
}

/// The values of a table of the preset, overwritten by the same table of the scene.
std::map<std::string, ParameterValue> merged_values(const std::optional<TomlTable>& preset,
                                                    const std::optional<TomlTable>& scene) {
  std::map<std::string, ParameterValue> values = preset ? preset->values() : std::map<std::string, ParameterValue>{};
  if (scene) {
    for (const auto& [key, value] : scene->values()) {
      values[key] = value;
    }
  }
  return values;
}

Parameters checked(const std::vector<ParameterSpec>& specs, const std::optional<TomlTable>& preset,
                   const std::optional<TomlTable>& scene) {
  // Each key is checked alone first, so that a message names the file and the line that it stands in.
  for (const auto& table : {preset, scene}) {
    for (const auto& [key, value] : table ? table->values() : std::map<std::string, ParameterValue>{}) {
      (void)Parameters(specs, {{key, value}}, table->line_of(key));
    }
  }
  return {specs, merged_values(preset, scene), scene ? scene->location() : "preset"};
}

Parameters with_overrides(const std::vector<ParameterSpec>& specs, const Parameters& of_files,
                          const std::map<std::string, ParameterValue>& overrides, std::string_view option) {
  std::map<std::string, ParameterValue> values = of_files.values();
  for (const auto& [key, value] : overrides) values[key] = value;
  return {specs, values, option};
}

/// The table `[effects]`; none where `effects = "auto"` stands in its place.
std::optional<TomlTable> effects_table(const TomlTable& root, AutoEffects& chosen) {
  if (root.is_word("effects")) {
    if (root.word("effects") != "auto") {
      throw InputError(root.location("effects"), "has to be \"auto\", or write [effects.NAME] tables");
    }
    chosen.wanted = true;
    return std::nullopt;
  }
  auto table = root.table("effects");
  if (table && table->flag_or("auto", false)) chosen.wanted = true;
  return table;
}

/// What the literature calls an effect and has its place elsewhere in a scene.
void refuse_names_of_other_places(const TomlTable& effects) {
  constexpr std::array other_places{
      std::pair{"muscle_contact",
                "is contact between muscles: write [contact] with muscle_contact = true, or a [[pair]]"},
      std::pair{"contact", "is always there: choose the backend by --backend and the response in [contact]"},
      std::pair{"fibre_anisotropy", "is a parameter: write [effects.edge_length] with anisotropy_exponent"}};
  for (const auto& [name, cure] : other_places) {
    if (effects.has(name)) throw InputError(effects.location(name), cure);
  }
}

void read_effects(const std::optional<TomlTable>& preset, const std::optional<TomlTable>& own, Scene& scene) {
  std::vector<std::string> known;
  for (const EffectEntry& entry : effect_registry()) {
    known.push_back(entry.name);
  }
  if (preset) preset->allow_only(known);
  known.emplace_back("auto");
  if (own) {
    refuse_names_of_other_places(*own);
    own->allow_only(known);
  }
  for (const EffectEntry& entry : effect_registry()) {
    // `bending = false` in the scene takes away what the preset names, and keeps out what the checker would add.
    if (own && own->is_false(entry.name)) {
      scene.exclusions.push_back({entry.name, preset && preset->has(entry.name)});
      continue;
    }
    const auto of_preset = preset ? preset->table(entry.name) : std::nullopt;
    const auto of_scene = own ? own->table(entry.name) : std::nullopt;
    if (of_preset || of_scene) {
      scene.effects.push_back({entry.name, checked(entry.parameters, of_preset, of_scene),
                               of_scene ? of_scene->place() : of_preset->place(),
                               of_scene ? of_scene->keys() : std::vector<std::string>{}, of_scene.has_value()});
    }
  }
}

/// `location`: of local_volume, for the message.
void require_one_pressure(const Scene& scene, const std::string& location) {
  const auto named = [&](std::string_view name) { return std::ranges::find(scene.effects, name, &SceneEffect::name); };
  const auto whole = named("volume");
  const auto local = named("local_volume");
  if (whole == scene.effects.end() || local == scene.effects.end()) return;
  // Regions add up to the whole.
  const double whole_pressure = whole->parameters.number("pressure");
  const double local_pressure = local->parameters.number("pressure");
  if (whole_pressure != local_pressure) {
    throw InputError(location,
                     fmt::format("has the pressure {:g} and effect 'volume' {:g}, which contradict each other: the "
                                 "regions are the whole; give both the same, or take one out (volume = false)",
                                 local_pressure, whole_pressure));
  }
}

/// What the command line changes. Where the checker adds effects, one that is taken out and not there is kept out.
std::vector<EffectOverride> overrides_of(const SceneRequest& request, Scene& scene) {
  std::vector<EffectOverride> overrides;
  for (const EffectOverride& change : request.effect_overrides) {
    const bool is_kept_out = scene.auto_effects.wanted && change.is_removed && find_effect(change.name) != nullptr;
    if (is_kept_out) scene.exclusions.push_back({change.name, has_effect(scene, change.name)});
    if (!is_kept_out || has_effect(scene, change.name)) overrides.push_back(change);
  }
  return overrides;
}

toml::table parse_scene(const SceneRequest& request) {
  try {
    return parse_toml(request.text, request.file);
  } catch (const InputError& error) {
    const std::string message = error.what();
    if (message.find("existing string 'effects") == std::string::npos) throw;
    throw InputError(message.substr(0, message.find(": ")),
                     "[effects.NAME] tables cannot follow effects = \"auto\"; write [effects] with auto = true "
                     "instead");
  }
}

void read_time_step_changes(const TomlTable& root, LoopParameters& loop) {
  if (!root.has("time_step_change")) return;
  for (const TomlTable& table : root.table_or_tables("time_step_change")) {
    table.allow_only({"from_frame", "time_step_s"});
    const double frame = table.number("from_frame", 1, 1e7);
    if (frame != std::floor(frame)) throw InputError(table.location("from_frame"), "has to be a whole number");
    const TimeStepChange change{static_cast<int>(frame), table.number("time_step_s", 1e-9, 1e3)};
    if (!loop.time_step_changes.empty() && change.from_frame <= loop.time_step_changes.back().from_frame) {
      throw InputError(table.location("from_frame"), fmt::format("has to be after {}, the frame of the previous change",
                                                                 loop.time_step_changes.back().from_frame));
    }
    loop.time_step_changes.push_back(change);
  }
}

void read_wanted(const SceneRequest& request, const std::optional<TomlTable>& own, Scene& scene) {
  scene.wanted = wanted_from(with_overrides(wanted_parameters(), checked(wanted_parameters(), std::nullopt, own),
                                            request.wanted_overrides, "--wanted"));
  scene.wanted.is_given = own || !request.wanted_overrides.empty();
  if (own) scene.wanted.own_values = own->values();
  for (const auto& [name, value] : request.wanted_overrides) scene.wanted.own_values[name] = value;
}

void require_motion(const SceneRequest& request, const std::optional<TomlTable>& own, const LoopParameters& loop) {
  if (loop.rest_frames < loop.frames) return;
  const bool is_in_file = own && own->has("rest_frames") && !request.loop_overrides.contains("rest_frames");
  throw InputError(is_in_file ? own->location("rest_frames") : "--loop rest_frames",
                   fmt::format("{} of {} frames leave none for the motion; rest in fewer, or run more",
                               loop.rest_frames, loop.frames));
}

SceneSource source_from(const TomlTable& table) {
  table.allow_only({"licence", "cite", "url", "non_commercial"});
  return {table.word("licence"), table.has("cite") ? table.words("cite") : std::vector<std::string>{},
          table.word_or("url", ""), table.flag_or("non_commercial", false)};
}

}  // namespace

Scene read_scene(const SceneRequest& request) {
  const toml::table text = parse_scene(request);
  const TomlTable root(text, request.file, "");
  root.allow_only({"title", "preset", "bone", "muscle", "pair", "attachment", "retinaculum", "contact", "effects",
                   "loop", "measure", "meshes", "source", "time_step_change", "wanted"});

  Scene scene;
  scene.name = request.name;
  scene.file = request.file;
  scene.title = root.word_or("title", request.name);
  if (const auto source = root.table("source")) scene.source = source_from(*source);
  scene.preset = request.preset_override.empty() ? root.word_or("preset", "") : request.preset_override;
  toml::table preset_text;
  if (!scene.preset.empty()) {
    const std::string text_of_preset = read_at(request.preset_override.empty() ? root.location("preset") : "--preset",
                                               [&] { return request.preset_text(scene.preset); });
    preset_text = parse_toml(text_of_preset, fmt::format("preset '{}'", scene.preset));
  }
  const TomlTable preset(preset_text, fmt::format("preset '{}'", scene.preset), "");
  preset.allow_only({"title", "effects", "loop"});

  if (const auto own = root.table("loop"); own && own->has("damping_per_s")) {
    throw InputError(own->location("damping_per_s"), "is an effect: write `[effects.damping]` with `rate_per_s`");
  }
  scene.loop =
      loop_from(with_overrides(loop_parameters(), checked(loop_parameters(), preset.table("loop"), root.table("loop")),
                               request.loop_overrides, "--loop"));
  const Parameters meshes =
      with_overrides(mesh_parameters(), checked(mesh_parameters(), std::nullopt, root.table("meshes")),
                     request.mesh_overrides, "--meshes");
  scene.mesh_splits = {.split_muscles = static_cast<int>(meshes.integer("split_muscles")),
                       .smooth_bones = static_cast<int>(meshes.integer("smooth_bones"))};
  read_wanted(request, root.table("wanted"), scene);
  read_time_step_changes(root, scene.loop);
  require_motion(request, root.table("loop"), scene.loop);
  const auto contact = root.table("contact");
  read_response(contact, scene);
  scene.auto_effects.wanted = request.auto_effects;
  scene.auto_effects.keeps_out_muscle_contact = contact && contact->is_false("muscle_contact");
  const auto own_effects = effects_table(root, scene.auto_effects);
  read_effects(preset.table("effects"), own_effects, scene);
  override_effects(overrides_of(request, scene), scene.effects);
  require_one_pressure(scene, own_effects ? own_effects->location("local_volume") : request.file);
  read_bones(request, root, scene);
  read_muscles(request, root, scene);
  read_pairs(root, contact, scene);
  read_measure(request, root.table("measure"), scene);
  return scene;
}

}  // namespace musclebench

#include "bench/results/manifest.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "bench/results/build_info.hpp"
#include "core/base/sha256.hpp"

namespace musclebench {

namespace {

Json json_of(const Parameters& parameters) {
  Json json = Json::object();
  for (const auto& [name, value] : parameters.values()) {
    std::visit([&, &key = name](const auto& v) { json[key] = v; }, value);
  }
  return json;
}

Json json_of_effects(const Scene& scene) {
  Json effects = Json::object();
  for (const SceneEffect& effect : scene.effects) {
    effects[effect.name] = json_of(effect.parameters);
  }
  return effects;
}

Json json_of_loop(const LoopParameters& loop) {
  Json json = {{"frames", loop.frames},
               {"rest_frames", loop.rest_frames},
               {"settle_substeps", loop.settle_substeps},
               {"substeps", loop.substeps},
               {"iterations", loop.iterations},
               {"time_step_s", loop.time_step_s},
               {"node_mass_kg", loop.node_mass_kg},
               {"density_kg_per_m3", loop.density_kg_per_m3},
               {"start_noise_m", loop.start_noise_m},
               {"bone_motion", loop.interpolate_poses ? "interpolated" : "per_frame"}};
  for (const TimeStepChange& change : loop.time_step_changes) {
    json["time_step_changes"].push_back({{"from_frame", change.from_frame}, {"time_step_s", change.time_step_s}});
  }
  return json;
}

std::string_view attachment_mode(const Scene& scene) {
  return scene.attach_at_first_contact ? "first_contact" : "areas";
}

Json json_of(const BoneRotation& rotation) {
  return {{"axis", {rotation.axis.x(), rotation.axis.y(), rotation.axis.z()}},
          {"centre_m", {rotation.centre_m.x(), rotation.centre_m.y(), rotation.centre_m.z()}},
          {"times", rotation.times},
          {"angles_rad", rotation.angles_rad},
          {"there_and_back", rotation.there_and_back}};
}

/// One rotation, of no angles where the bone stands still, or a list of several.
Json json_of(const BoneMotion& motion) {
  if (motion.rotations.empty()) return json_of(BoneRotation());
  if (motion.rotations.size() == 1) return json_of(motion.rotations.front());
  Json rotations = Json::array();
  for (const BoneRotation& rotation : motion.rotations) rotations.push_back(json_of(rotation));
  return rotations;
}

Json json_of(const std::string& name, const SceneMesh& mesh) {
  return {{"name", name},
          {"mesh", mesh.reference},
          {"vertices", mesh.mesh.vertices.size()},
          {"triangles", mesh.mesh.triangles.size()},
          {"mesh_sha256", mesh.sha256}};
}

Json json_of(const Muscle& muscle) {
  Json json = json_of(muscle.body.name, muscle.file);
  json["nodes"] = muscle.body.last_node - muscle.body.first_node;
  if (muscle.density_kg_per_m3) json["density_kg_per_m3"] = *muscle.density_kg_per_m3;
  if (const Vec3& v = muscle.velocity_m_per_s; !v.isZero(0)) json["velocity_m_per_s"] = {v.x(), v.y(), v.z()};
  if (muscle.body.activation != 1) json["activation"] = muscle.body.activation;
  json["repairs"] = muscle.changes;
  return json;
}

Json json_of(const BackendChoice& choice) {
  return {{"backend", choice.entry->name}, {"parameters", json_of(choice.parameters)}};
}

/// What `of_pair` tells of a muscle and a bone (Scene::bone_pair; null: nothing), below `key`: by the bone's name where
/// it is the same for all muscles, else by both names.
template <typename OfPair>
void add_by_bone(Json& json, const char* key, const Scene& scene, const OfPair& of_pair) {
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    std::vector<Json> of_muscles;
    for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
      of_muscles.push_back(of_pair(scene.bone_pair(muscle, bone)));
    }
    const std::string& name = scene.bones[bone].name;
    const bool same =
        std::all_of(of_muscles.begin(), of_muscles.end(), [&](const Json& each) { return each == of_muscles.front(); });
    if (same) {
      if (!of_muscles.front().is_null()) json[key][name] = of_muscles.front();
      continue;
    }
    for (std::size_t muscle = 0; muscle < scene.muscles.size(); ++muscle) {
      if (!of_muscles[muscle].is_null()) {
        json[key][fmt::format("{}/{}", scene.muscles[muscle].body.name, name)] = of_muscles[muscle];
      }
    }
  }
}

/// What readers of one muscle look at, of all.
Json sum_of_muscles(const Json& muscles) {
  Json sum = muscles.front();
  for (std::size_t i = 1; i < muscles.size(); ++i) {
    for (const char* text : {"name", "mesh", "mesh_sha256"}) {
      sum[text] = fmt::format("{} + {}", sum[text].get<std::string>(), muscles[i][text].get<std::string>());
    }
    for (const char* count : {"vertices", "triangles", "nodes"}) {
      sum[count] = sum[count].get<int>() + muscles[i][count].get<int>();
    }
    sum["repairs"].insert(sum["repairs"].end(), muscles[i]["repairs"].begin(), muscles[i]["repairs"].end());
  }
  return sum;
}

Json json_of_machine() {
  const MachineInfo machine = machine_info();
  return {{"cpu", machine.cpu},
          {"cores", machine.cores},
          {"governor", machine.governor},
          {"clock_resolution_ns", machine.clock_resolution_ns}};
}

/// What a scene file outlines or draws in becomes nodes and fibres; they are the input, however they were described.
void add_nodes_and_fibres(Sha256& hash, const Scene& scene) {
  for (const Attachment& attachment : scene.attachments) {
    hash.add(fmt::format("{} {} ", attachment.name, attachment.bone));
    hash.add(std::as_bytes(std::span(attachment.nodes)));
  }
  for (const Muscle& muscle : scene.muscles) {
    hash.add(muscle.fibres_between_attachments ? "fibres between attachments" : "fibres of a file");
    hash.add(std::as_bytes(std::span(muscle.fibres)));
  }
}

}  // namespace

Json names_of(const Scene& scene, const MusclePair& pair) {
  return {scene.muscles[static_cast<std::size_t>(pair.first)].body.name,
          scene.muscles[static_cast<std::size_t>(pair.second)].body.name};
}

std::string text_of(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json json_of_case(const Case& resolved, std::string_view mode) {
  Json json = {{"mode", mode},
               {"scene", resolved.scene.name},
               {"preset", resolved.scene.preset},
               {"backend", resolved.backend.name},
               {"response", resolved.responses.size() == 1 ? name_of(resolved.responses.front()) : "by_bone"},
               {"response_steps", resolved.scene.response_steps},
               {"parameters", json_of(resolved.parameters)},
               {"threads", resolved.threads},
               {"repetition", resolved.repetition},
               {"attachment", attachment_mode(resolved.scene)},
               {"effects", json_of_effects(resolved.scene)},
               {"loop", json_of_loop(resolved.scene.loop)},
               {"meshes", json_of(mesh_values(resolved.scene.mesh_splits))}};
  const auto& with_bones = resolved.colliders.with_bones;
  add_by_bone(json, "bone_backends", resolved.scene, [&](std::size_t pair) {
    return pair < with_bones.size() && with_bones[pair] ? json_of(*with_bones[pair]) : Json();
  });
  const std::vector<BoneResponse> responses = resolved.scene.responses(resolved.responses);
  add_by_bone(json, "bone_responses", resolved.scene, [&](std::size_t pair) {
    const auto& [kind, steps] = responses[pair];
    return resolved.responses.size() > 1 || steps != resolved.scene.response_steps
               ? Json{{"response", name_of(kind)}, {"steps", steps}}
               : Json();
  });
  if (resolved.colliders.of_faces) json["face_contact"] = json_of(*resolved.colliders.of_faces);
  for (std::size_t pair = 0; pair < resolved.colliders.of_muscle_pairs.size(); ++pair) {
    json["muscle_contact"].push_back(
        {{"muscles", names_of(resolved.scene, resolved.scene.muscle_pairs[pair].muscles)},
         {"backend", resolved.colliders.of_muscle_pairs[pair].entry->name},
         {"parameters", json_of(resolved.colliders.of_muscle_pairs[pair].parameters)},
         {"steps", resolved.scene.muscle_pairs[pair].response_steps.value_or(resolved.scene.response_steps)}});
  }
  return json;
}

Json json_of_inputs(const Scene& scene) {
  Json bones = Json::array();
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    Json bone = json_of(scene.bones[i].name, scene.bone_meshes[i]);
    bone["repairs"] = scene.bones[i].surface.changes;
    bone["motion"] = json_of(scene.motions[i]);
    bones.push_back(bone);
  }
  Json muscles = Json::array();
  for (const Muscle& muscle : scene.muscles) {
    muscles.push_back(json_of(muscle));
  }
  Json inputs = {{"muscle", sum_of_muscles(muscles)}, {"bones", bones}};
  if (muscles.size() > 1) inputs["muscles"] = muscles;
  return inputs;
}

Json json_of_build() {
  const BuildInfo build = build_info();
  return {{"version", build.version},
          {"git", build.git},
          {"compiler", build.compiler},
          {"flags", build.flags},
          {"type", build.type}};
}

void add_origin(Json& json, const StructureOrigin& origin) {
  json["structures"] = origin.is_from_file ? "loaded" : "built";
  json["kept_build_ns"] = origin.kept_build_ns ? Json(*origin.kept_build_ns) : Json(nullptr);
}

Json json_of(const MachineState& state) {
  const auto figure = [](const auto& value) { return value ? Json(*value) : Json(nullptr); };
  const CpuSettings settings = cpu_settings();
  return {{"involuntary_context_switches", state.switches.involuntary},
          {"voluntary_context_switches", state.switches.voluntary},
          {"load_average_1m",
           {{"before", figure(state.before.load_average_1m)}, {"after", figure(state.after.load_average_1m)}}},
          {"cpu_mhz", {{"before", figure(state.before.cpu_mhz)}, {"after", figure(state.after.cpu_mhz)}}},
          {"governor", figure(state.after.governor)},
          {"allowed_cores", settings.allowed_cores},
          {"nice", settings.nice},
          {"turbo", figure(settings.turbo)},
          {"smt", figure(settings.smt)}};
}

Json json_of(const std::vector<PrunedResult>& pruned, const Scene& scene) {
  Json list = Json::array();
  for (const PrunedResult& each : pruned) {
    const Bone& bone = scene.bones[static_cast<std::size_t>(each.pruned.bone)];
    const bool in_part = each.pruned.kept_share > 0;
    list.push_back({{"bone", bone.name},
                    {"reason", in_part ? "partly_out_of_reach" : "out_of_reach"},
                    {"kept_share", each.pruned.kept_share},
                    {"distance_m", each.reach.distance_m},
                    {"margin_m", each.reach.margin_m},
                    {"watch_m", each.pruned.reach_m},
                    {"saved_triangles", in_part || each.pruned.is_back ? 0 : bone.surface.mesh.triangles.size()},
                    {"saved_queries", each.pruned.saved_queries},
                    {"is_back", each.pruned.is_back},
                    {"frame_back", each.frame_back ? Json(*each.frame_back) : Json(nullptr)},
                    {"build_ns", each.pruned.build_ns}});
  }
  return list;
}

/// By the name of each backend of a case, whose code it is.
Json implementations_of(const Case& resolved) {
  Json found = {{resolved.backend.name, resolved.backend.implementation}};
  const auto add = [&](const BackendChoice& choice) { found[choice.entry->name] = choice.entry->implementation; };
  for (const std::optional<BackendChoice>& choice : resolved.colliders.with_bones) {
    if (choice) add(*choice);
  }
  for (const BackendChoice& choice : resolved.colliders.of_muscle_pairs) add(choice);
  if (resolved.colliders.of_faces) add(*resolved.colliders.of_faces);
  return found;
}

Json manifest_head(std::string_view status, std::string_view status_detail, const Json& json_of_case,
                   const Case& resolved) {
  const Scene& scene = resolved.scene;
  Json json = {{"schema_version", schema_version},     {"status", status},     {"status_detail", status_detail},
               {"run_id", id_of(json_of_case, scene)}, {"title", scene.title}, {"case", json_of_case}};
  if (const SceneSource& source = scene.source; !source.licence.empty()) {
    json["source"] = {{"licence", source.licence},
                      {"cite", source.citations},
                      {"url", source.url},
                      {"non_commercial", source.is_non_commercial}};
  }
  json.update(json_of_inputs(scene));
  json["implementations"] = implementations_of(resolved);
  json["build"] = json_of_build();
  json["machine"] = json_of_machine();
  return json;
}

std::string id_of(const Json& json_of_case, const Scene& scene) {
  Sha256 hash;
  hash.add(text_of(json_of_case));
  hash.add(text_of(json_of_inputs(scene)));
  add_nodes_and_fibres(hash, scene);
  hash.add(text_of(json_of_build()));
  return hash.hex_digest().substr(0, 16);
}

std::string scene_hash(const Scene& scene) {
  Sha256 hash;
  for (const Muscle& muscle : scene.muscles) {
    hash.add(muscle.file.sha256);
  }
  for (std::size_t i = 0; i < scene.bones.size(); ++i) {
    hash.add(scene.bone_meshes[i].sha256);
    hash.add(text_of(Json(scene.bones[i].surface.changes)));
    hash.add(text_of(json_of(scene.motions[i])));
  }
  hash.add(attachment_mode(scene));
  // Not what is as it was before a scene could say it: recordings stay those of their scenes.
  Json effects = json_of_effects(scene);
  for (Json& effect : effects) {
    if (!effect.value("per_area", false)) effect.erase("per_area");
  }
  hash.add(text_of(effects));
  hash.add(text_of(json_of_loop(scene.loop)));
  if (scene.mesh_splits.split_muscles > 0 || scene.mesh_splits.smooth_bones > 0) {
    hash.add(text_of(json_of(mesh_values(scene.mesh_splits))));
  }
  if (scene.response_steps != default_projection_steps) {
    hash.add(fmt::format("{} steps of a response", scene.response_steps));
  }
  for (std::size_t pair = 0; pair < scene.bone_contacts.size(); ++pair) {
    if (const auto steps = scene.bone_contacts[pair].response_steps) {
      hash.add(fmt::format("bone {} in {} steps", pair, *steps));
    }
  }
  for (const SceneMusclePair& pair : scene.muscle_pairs) {
    hash.add(fmt::format("{} touches {}", pair.muscles.first, pair.muscles.second));
    if (pair.response_steps) hash.add(fmt::format("in {} steps", *pair.response_steps));
  }
  add_nodes_and_fibres(hash, scene);
  return hash.hex_digest();
}

}  // namespace musclebench

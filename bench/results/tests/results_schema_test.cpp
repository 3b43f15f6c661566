#include "bench/results/results_schema.hpp"

#include <algorithm>
#include <fstream>
#include <numeric>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/kept_frames.hpp"
#include "bench/results/probe_output.hpp"
#include "bench/results/replay_output.hpp"
#include "bench/results/run_output.hpp"
#include "bench/results/tests/small_run.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {
namespace {

/// Two muscles that touch, and a bone that is out of reach.
Scene scene_of_two() {
  Scene scene = small_scene();
  Muscle& ball = scene.add_muscle("ball", make_sphere(0.005, 1));
  ball.file = {"ball", "", make_sphere(0.005, 1)};
  ball.node_of_vertex.resize(ball.file.mesh.vertices.size());
  std::iota(ball.node_of_vertex.begin(), ball.node_of_vertex.end(), ball.body.first_node);
  ball.changes = {"made by hand"};
  scene.muscle_pairs = {{{0, 1}, {}}};
  Bone far{"far", {make_box({0.01, 0.01, 0.01}, 1), true, {}}};
  for (Vec3& vertex : far.surface.mesh.vertices) vertex.x() += 5;
  scene.bone_meshes.push_back({"far", "", far.surface.mesh});
  scene.motions.emplace_back();
  scene.bones.push_back(std::move(far));
  scene.bone_contacts.resize(scene.bones.size());
  scene.bone_contacts.front().response_steps = 5;
  scene.source = {"CC BY 4.0", {"somebody"}, "https://example.org", false};
  scene.auto_effects = {.wanted = true, .added = {{"friction", "a_rule", "a reason"}}};
  return scene;
}

/// What an approximating backend leaves behind has every key.
RunCase approximate_case(const Scene& scene) {
  RunCase run = case_of(scene, "sdf", {{"cells", std::int64_t{16}}});
  run.colliders = choose_collider_backends({"femur=bvh"}, scene, run.backend);
  return run;
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  if (text.ends_with(at)) parts.emplace_back();
  return parts;
}

std::string header_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// Paths of all leaves; an empty list or object is a leaf whose path ends there.
void add_paths(const Json& json, const std::string& path, std::set<std::string>& paths) {
  if (json.is_structured() && json.empty()) {
    paths.insert(path + (json.is_array() ? "[]" : ".*"));
  } else if (json.is_array()) {
    for (const Json& element : json) add_paths(element, path + "[]", paths);
  } else if (json.is_object()) {
    for (const auto& [key, value] : json.items())
      add_paths(value, path.empty() ? key : std::string(path).append(".").append(key), paths);
  } else {
    paths.insert(path);
  }
}

bool matches(const std::string& path, const ManifestKey& key) {
  const std::vector<std::string> names = split(path, '.');
  const std::vector<std::string> wanted = split(std::string(key.info.name), '.');
  return names.size() == wanted.size() &&
         std::equal(names.begin(), names.end(), wanted.begin(),
                    [](const std::string& name, const std::string& want) { return want == "*" || name == want; });
}

/// Whether the key can only stand in a list that is empty there.
bool is_below_an_empty_list(const ManifestKey& key, const std::set<std::string>& paths) {
  return std::any_of(paths.begin(), paths.end(),
                     [&](const std::string& path) { return path.ends_with("[]") && key.info.name.starts_with(path); });
}

void expect_schema(const Json& manifest, ResultKind kind) {
  std::set<std::string> paths;
  add_paths(manifest, "", paths);
  const auto keys = manifest_keys();
  for (const std::string& path : paths) {
    EXPECT_TRUE(std::any_of(keys.begin(), keys.end(),
                            [&](const ManifestKey& key) { return key.is_in(kind) && matches(path, key); }))
        << name_of(kind) << ": the schema lacks " << path;
  }
  for (const ManifestKey& key : keys) {
    if (!key.is_in(kind) || is_below_an_empty_list(key, paths)) continue;
    EXPECT_TRUE(std::any_of(paths.begin(), paths.end(), [&](const std::string& path) { return matches(path, key); }))
        << name_of(kind) << ": nothing writes " << key.info.name;
  }
}

std::string names_in(const Json& columns, const std::vector<std::string>& effects = {},
                     const std::vector<std::string>& stages = {}) {
  std::string names;
  for (const Json& column : columns["columns"]) {
    if (column["name"] == effect_column) {
      for (const std::string& effect : effects) names.append(",").append(effect).append("_ns");
    } else if (column["name"] == stage_column) {
      for (const std::string& stage : stages) names.append(",").append(stage).append("_ns");
    } else {
      names.append(",").append(column["name"].get<std::string>());
    }
  }
  return names.substr(1);
}

/// As if one fibre of each muscle had been followed, and others refused: the muscles here hang on no bone.
void add_fibres(Scene& scene, RunResult& result) {
  scene.fibre_count = 1;
  result.fibres_refused = "scene.toml: needs a motion";
  for (int frame = 0; frame <= static_cast<int>(result.records.size()); ++frame) {
    result.fibres.push_back({frame, 0.1 * frame, {}});
  }
  for (const Muscle& muscle : scene.muscles) {
    result.followed_fibres.push_back({muscle.body.name, 1, 1});
    for (FibreFrame& frame : result.fibres) frame.muscles.push_back({{0.1}, 0.0});
    for (Snapshot& snapshot : result.snapshots) snapshot.fibres.push_back({Vec3::Zero(), Vec3::UnitX()});
  }
}

TEST(ResultsSchema, HoldsForARun) {
  Scene scene = scene_of_two();
  scene.warnings = {{"a_rule", "a text"}};
  RunCase run = approximate_case(scene);
  run.snapshots = {0, 2};
  run.count_self_intersections = true;
  run.forces = true;
  scene.wanted.own_values = {{"surface_mm", 0.1}};
  run.colliders.of_faces = BackendChoice{&run.backend, run.parameters};
  RunResult result = result_of(run);
  add_fibres(scene, result);
  result.gave_up.push_back({"no_passage", 1, "two bones come together"});
  result.forces.push_back({.source = ForceSource::joint, .other = "bone", .torque_n_m = 0.1});  // no bone turns here
  for (Snapshot& snapshot : result.snapshots) {
    // Left out in this scene, whose nodes weigh 1 kg.
    snapshot.contact = {std::vector<Vec3>(snapshot.positions.size(), Vec3::Zero()),
                        std::vector<double>(snapshot.positions.size())};
  }
  for (const StepRecord& record : result.records) {
    ASSERT_EQ(record.pairs.size(), 2 * scene.bones.size() + 1);
    const PairRecord& touching = record.pairs.back();
    EXPECT_EQ(touching.muscle, scene.muscles[0].body.name);
    EXPECT_EQ(touching.other, scene.muscles[1].body.name);
    EXPECT_LT(touching.detect_ns, record.times.frame_ns);
    EXPECT_EQ(touching.contacts, record.muscle_contacts);
  }
  EXPECT_GT(result.records.front().pairs.back().detect_ns, 0);
  const TemporaryFolder folder;
  write_run(folder.path() / "out", run, result);
  EXPECT_EQ(header_of(folder.path() / "out" / "frames.csv"),
            names_in(results_schema_json()["run"], result.effect_names, result.stage_names));
  EXPECT_EQ(header_of(folder.path() / "out" / "muscles.csv"), names_in(results_schema_json()["muscles"]));
  EXPECT_EQ(header_of(folder.path() / "out" / "pairs.csv"), names_in(results_schema_json()["pairs"]));
  for (const char* table : {"fibres", "fibre_lengths", "forces"}) {
    EXPECT_EQ(header_of(folder.path() / "out" / (std::string(table) + ".csv")), names_in(results_schema_json()[table]));
  }
  EXPECT_EQ(header_of(folder.path() / "out" / "snapshots" / "bones_0002.csv"),
            names_in(results_schema_json()["bone_pressure"]));
  expect_schema(manifest_in(folder.path() / "out"), ResultKind::run);
}

TEST(ResultsSchema, HoldsForAReplay) {
  const Scene scene = scene_of_two();
  const RunCase run = approximate_case(scene);
  const BuiltBackend built = build_backend(run);
  const PreparedSimulation prepared = prepare_simulation(scene, *built.backend, run.responses, run.threads,
                                                         make_contact_methods(scene, run.colliders, run.threads));
  KeptFrames frames(static_cast<int>(scene.muscle_mesh.vertices.size()), prepared.simulation->free_nodes(), true);
  for (int frame = 1; frame <= 2; ++frame) {
    frames.begin_frame(frame, 0);
    prepared.simulation->step_frame(frame, &frames);
  }
  const ReplayCase replay{static_cast<const Case&>(run)};
  const ReplayResult result = replay_case(replay, frames, [](int) {});
  const TemporaryFolder folder;
  write_replay(folder.path() / "out", replay, result, frames.header(), "kept.recording");
  EXPECT_EQ(header_of(folder.path() / "out" / "frames.csv"), names_in(results_schema_json()["replay"]));
  EXPECT_EQ(header_of(folder.path() / "out" / "muscles.csv"), names_in(results_schema_json()["replay_muscles"]));
  EXPECT_EQ(header_of(folder.path() / "out" / "pairs.csv"), names_in(results_schema_json()["replay_pairs"]));
  expect_schema(manifest_in(folder.path() / "out"), ResultKind::replay);
}

TEST(ResultsSchema, HoldsForAProbe) {
  const Scene scene = scene_of_two();
  const ProbeCase what{static_cast<const Case&>(approximate_case(scene)), 100};
  const ProbeResult result = probe(what, [](int) {});
  const TemporaryFolder folder;
  write_probe(folder.path() / "out", what, result);
  EXPECT_EQ(header_of(folder.path() / "out" / "probe.csv"), names_in(results_schema_json()["probe"]));
  expect_schema(manifest_in(folder.path() / "out"), ResultKind::probe);
}

TEST(ResultsSchema, EveryNameStandsOnceAndSaysWhatItMeans) {
  const Json schema = results_schema_json();
  EXPECT_EQ(schema["results_schema"], schema_version);
  for (const ResultKind kind : result_kinds) {
    for (const Json& list : {schema[std::string(name_of(kind))]["columns"], schema["replay_muscles"]["columns"],
                             schema["replay_pairs"]["columns"], schema["run_json"][std::string(name_of(kind))]}) {
      std::set<std::string> names;
      for (const Json& entry : list) {
        EXPECT_TRUE(names.insert(entry["name"]).second) << entry["name"];
        EXPECT_FALSE(entry["help"].get<std::string>().empty()) << entry["name"];
      }
      EXPECT_GE(names.size(), 9U);
    }
  }
}

}  // namespace
}  // namespace musclebench

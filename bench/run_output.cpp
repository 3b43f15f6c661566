#include "bench/run_output.hpp"

#include <algorithm>
#include <fstream>
#include <set>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/build_info.hpp"
#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/geometry/read_mesh.hpp"

namespace musclebench {

namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int schema_version = 1;

/// Names that are no UTF-8 are written with replacement characters.
std::string text_of(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json json_of(const Parameters& parameters) {
  Json json = Json::object();
  for (const auto& [name, value] : parameters.values()) {
    std::visit([&, &key = name](const auto& v) { json[key] = v; }, value);
  }
  return json;
}

Json json_of_case(const RunCase& run) {
  const LoopParameters& loop = run.scene.loop;
  Json effects = Json::object();
  for (const SceneEffect& effect : run.scene.effects) {
    effects[effect.name] = json_of(effect.parameters);
  }
  return {{"scene", run.scene.name},
          {"preset", run.scene.preset},
          {"backend", run.backend.name},
          {"parameters", json_of(run.parameters)},
          {"threads", run.threads},
          {"repetition", run.repetition},
          {"warm_up_frames", run.warm_up_frames},
          {"judged", run.judge},
          {"snapshots", run.snapshots},
          {"attachment", run.scene.attach_at_first_contact ? "first_contact" : "areas"},
          {"effects", effects},
          {"loop",
           {{"frames", loop.frames},
            {"substeps", loop.substeps},
            {"iterations", loop.iterations},
            {"time_step_s", loop.time_step_s},
            {"damping_per_s", loop.damping_per_s},
            {"node_mass_kg", loop.node_mass_kg},
            {"density_kg_per_m3", loop.density_kg_per_m3},
            {"bone_motion", loop.interpolate_poses ? "interpolated" : "per_frame"}}}};
}

Json json_of_mesh(const std::string& name, const SceneMesh& mesh) {
  return {{"name", name},
          {"mesh", mesh.reference},
          {"vertices", mesh.mesh.vertices.size()},
          {"triangles", mesh.mesh.triangles.size()},
          {"mesh_sha256", mesh.sha256}};
}

Json json_of_build() {
  const BuildInfo build = build_info();
  return {{"version", build.version},
          {"git", build.git},
          {"compiler", build.compiler},
          {"flags", build.flags},
          {"type", build.type}};
}

Json json_of_inputs(const RunCase& run) {
  Json bones = Json::array();
  for (std::size_t i = 0; i < run.scene.bones.size(); ++i) {
    Json bone = json_of_mesh(run.scene.bones[i].name, run.scene.bone_meshes[i]);
    bone["repairs"] = run.scene.bones[i].surface.changes;
    const BoneMotion& motion = run.scene.motions[i];
    bone["motion"] = {{"axis", {motion.axis.x(), motion.axis.y(), motion.axis.z()}},
                      {"centre_m", {motion.centre_m.x(), motion.centre_m.y(), motion.centre_m.z()}},
                      {"times", motion.times},
                      {"angles_rad", motion.angles_rad},
                      {"there_and_back", motion.there_and_back}};
    bones.push_back(bone);
  }
  return {{"muscle", json_of_mesh(run.scene.muscle_name, run.scene.muscle)}, {"bones", bones}};
}

Json json_of_attachments(const RunCase& run, const RunResult& result) {
  Json attachments = Json::array();
  for (const Attachment& attachment : run.scene.attachments) {
    attachments.push_back({{"name", attachment.name},
                           {"bone", run.scene.bones[attachment.bone].name},
                           {"nodes", attachment.nodes.size()}});
  }
  if (run.scene.attach_at_first_contact) {
    for (std::size_t bone = 0; bone < run.scene.bones.size(); ++bone) {
      const auto nodes = std::count_if(result.bound_nodes.begin(), result.bound_nodes.end(),
                                       [&](const BoundNode& n) { return n.bone == static_cast<int>(bone); });
      attachments.push_back({{"name", "first_contact"}, {"bone", run.scene.bones[bone].name}, {"nodes", nodes}});
    }
  }
  return attachments;
}

std::string snapshot_file(const Snapshot& snapshot) { return fmt::format("snapshots/frame_{:04}.ply", snapshot.frame); }

Json json_of_snapshots(const RunResult& result) {
  Json snapshots = Json::array();
  for (const Snapshot& snapshot : result.snapshots) {
    Json poses = Json::array();
    for (const RigidMotion& pose : snapshot.bone_poses) {
      Json rotation = Json::array();
      for (int i = 0; i < 9; ++i) {
        rotation.push_back(pose.rotation(i / 3, i % 3));
      }
      poses.push_back({{"rotation", rotation},
                       {"translation_m", {pose.translation_m.x(), pose.translation_m.y(), pose.translation_m.z()}}});
    }
    snapshots.push_back({{"frame", snapshot.frame},
                         {"angle_deg", snapshot.angle_deg},
                         {"file", snapshot_file(snapshot)},
                         {"bone_poses", poses}});
  }
  return snapshots;
}

Json manifest(const RunCase& run, const RunResult& result) {
  const MachineInfo machine = machine_info();
  Json json = {{"schema_version", schema_version},
               {"status", result.status},
               {"status_detail", result.status_detail},
               {"run_id", run_id(run)},
               {"title", run.scene.title},
               {"case", json_of_case(run)}};
  json.update(json_of_inputs(run));
  json["muscle"]["rest_volume_m3"] = result.rest_volume_m3;
  json["attachments"] = json_of_attachments(run, result);
  json["bound_nodes"] = result.bound_nodes.size();
  json["build"] = json_of_build();
  json["machine"] = {{"cpu", machine.cpu},
                     {"cores", machine.cores},
                     {"governor", machine.governor},
                     {"clock_resolution_ns", machine.clock_resolution_ns}};
  json["structure_bytes"] = result.structure_bytes;
  json["build_ns"] = result.build_ns;
  json["memory"] = {{"before_first_frame_bytes", result.memory_before_bytes},
                    {"after_last_frame_bytes", result.memory_after_bytes},
                    {"peak_bytes", result.memory_peak_bytes},
                    {"referee_bytes", result.referee_bytes}};
  json["state_hash"] = result.state_hash;
  json["wall_ns"] = result.wall_ns;
  json["frames"] = result.records.size();
  json["snapshots"] = json_of_snapshots(result);
  return json;
}

/// A file whose every failure, up to closing, is an InputError.
class OutputFile {
 public:
  explicit OutputFile(const fs::path& path) : m_path(path), m_stream(path, std::ios::binary) { check(); }
  std::ostream& stream() { return m_stream; }
  void close() {
    m_stream.close();
    check();
  }

 private:
  void check() const {
    if (!m_stream) {
      throw InputError(m_path.string(), "cannot be written; is the disk full or the folder write-protected?");
    }
  }
  fs::path m_path;
  std::ofstream m_stream;
};

template <typename Value>
void put(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void write_snapshot(const fs::path& path, const Snapshot& snapshot, const RunCase& run,
                    const std::vector<BoundNode>& bound_nodes) {
  std::vector<unsigned char> attached(snapshot.positions.size(), 0);
  for (const BoundNode& bound : bound_nodes) {
    attached[bound.node] = 1;
  }
  const std::vector<Triangle>& triangles = run.scene.muscle.mesh.triangles;
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double "
      "z\n"
      "property double depth_m\nproperty uchar attached\nelement face {}\nproperty list uchar int vertex_indices\n"
      "end_header\n",
      snapshot.positions.size(), triangles.size());
  for (std::size_t i = 0; i < snapshot.positions.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      put(bytes, snapshot.positions[i][axis]);
    }
    put(bytes, snapshot.depths_m[i]);
    put(bytes, attached[i]);
  }
  for (const Triangle& triangle : triangles) {
    put(bytes, static_cast<unsigned char>(3));
    for (const int corner : triangle) {
      put(bytes, corner);
    }
  }
  OutputFile file(path);
  file.stream() << bytes;
  file.close();
}

void write_files(const fs::path& folder, const RunCase& run, const RunResult& result) {
  OutputFile frames(folder / "frames.csv");
  write_frames_csv(frames.stream(), result.effect_names, result.records);
  frames.close();
  if (!result.snapshots.empty()) {
    fs::create_directory(folder / "snapshots");
    fs::create_directory(folder / "meshes");
    for (const Snapshot& snapshot : result.snapshots) {
      write_snapshot(folder / snapshot_file(snapshot), snapshot, run, result.bound_nodes);
    }
    for (const Bone& bone : run.scene.bones) {
      write_ply(bone.surface.mesh, folder / "meshes" / (bone.name + ".ply"));
    }
  }
  OutputFile json(folder / "run.json");
  json.stream() << text_of(manifest(run, result), 2) << '\n';
  json.close();
}

/// Makes the missing folders of a path, and removes those again that it made unless told to keep them.
class MissingFolders {
 public:
  explicit MissingFolders(const fs::path& folder) {
    for (fs::path path = folder; !fs::exists(path); path = path.parent_path()) {
      m_first_made = path;
    }
    fs::create_directories(folder);
  }
  MissingFolders(const MissingFolders&) = delete;
  MissingFolders& operator=(const MissingFolders&) = delete;
  ~MissingFolders() {
    if (!m_first_made.empty()) {
      std::error_code ignored;
      fs::remove_all(m_first_made, ignored);
    }
  }
  void keep() { m_first_made.clear(); }

 private:
  fs::path m_first_made;
};

/// Absolute, without links and without a slash at its end.
fs::path resolved(const fs::path& folder) {
  const fs::path canonical = fs::weakly_canonical(fs::absolute(folder));
  return canonical.has_filename() ? canonical : canonical.parent_path();
}

fs::path beside(const fs::path& folder, std::string_view ending) {
  return folder.parent_path() / fmt::format(".{}.{}.{}", folder.filename().string(), getpid(), ending);
}

Json read_manifest(const fs::path& folder) {
  std::ifstream file(folder / "run.json");
  return Json::parse(file, nullptr, false);
}

bool is_text(const Json& manifest, const char* key) {
  return manifest.is_object() && manifest.contains(key) && manifest[key].is_string();
}

/// A folder is replaced only when it is empty or holds a run and nothing else.
void require_replaceable(const fs::path& folder) {
  if (!fs::exists(folder)) {
    return;
  }
  if (!fs::is_directory(folder)) {
    throw InputError(folder.string(), "is a file; choose another --out");
  }
  const fs::path current = fs::current_path();
  if (current == folder || current.string().starts_with(folder.string() + "/")) {
    throw InputError(folder.string(), "holds the current folder and can't be replaced; choose another --out");
  }
  static const std::set<std::string> of_a_run = {"run.json", "frames.csv", "snapshots", "meshes", "case.json"};
  const bool foreign = std::any_of(fs::directory_iterator(folder), fs::directory_iterator(), [](const auto& entry) {
    return of_a_run.count(entry.path().filename().string()) == 0;
  });
  if (foreign || (!fs::is_empty(folder) && !is_text(read_manifest(folder), "run_id"))) {
    throw InputError(folder.string(), "holds something else than a run and would be replaced; choose another --out");
  }
}

}  // namespace

std::string run_id(const RunCase& run) {
  Sha256 hash;
  hash.add(text_of(json_of_case(run)));
  hash.add(text_of(json_of_inputs(run)));
  // What a scene file outlines or draws in becomes nodes and fibres; they are the input, however they were described.
  for (const Attachment& attachment : run.scene.attachments) {
    hash.add(fmt::format("{} {} ", attachment.name, attachment.bone));
    hash.add(std::as_bytes(std::span(attachment.nodes)));
  }
  hash.add(run.scene.fibres_between_attachments ? "fibres between attachments" : "fibres of a file");
  hash.add(std::as_bytes(std::span(run.scene.fibres)));
  hash.add(text_of(json_of_build()));
  return hash.hex_digest().substr(0, 16);
}

bool is_complete(const fs::path& folder, const std::string& id) {
  const Json manifest = read_manifest(folder);
  return is_text(manifest, "run_id") && manifest["run_id"] == id && is_text(manifest, "status") &&
         manifest["status"] == "ok" && fs::exists(folder / "frames.csv");
}

void require_writable(const fs::path& folder) {
  try {
    const fs::path place = resolved(folder);
    require_replaceable(place);
    const MissingFolders probe(beside(place, "part"));
  } catch (const fs::filesystem_error& failure) {
    throw InputError(folder.string(),
                     fmt::format("cannot be written ({}); choose another --out", failure.code().message()));
  }
}

void write_run(const fs::path& folder, const RunCase& run, const RunResult& result) {
  try {
    const fs::path place = resolved(folder);
    MissingFolders parents(place.parent_path());
    const fs::path part = beside(place, "part");
    const MissingFolders part_folder(part);
    write_files(part, run, result);
    require_replaceable(place);
    // The old run stays until the new one is in its place.
    const fs::path old = beside(place, "old");
    if (fs::exists(place)) {
      fs::rename(place, old);
    }
    fs::rename(part, place);
    fs::remove_all(old);
    parents.keep();
  } catch (const fs::filesystem_error& failure) {
    throw InputError(folder.string(), fmt::format("cannot be written ({})", failure.code().message()));
  }
}

}  // namespace musclebench

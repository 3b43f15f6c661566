#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <unistd.h>
#include <utility>
#include <zstd.h>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/fuzz/fuzzed_reader.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/recording/recording_header.hpp"
#include "core/recording/recording_reader.hpp"
#include "core/recording/recording_writer.hpp"
#include "core/scene/bone_motion.hpp"
#include "core/scene/landmarks.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

void read_ply_bytes(std::string_view bytes) { (void)read_mesh(TemporaryFile(bytes, ".ply").path()); }
void read_obj_bytes(std::string_view bytes) { (void)read_mesh(TemporaryFile(bytes, ".obj").path()); }
void read_off_bytes(std::string_view bytes) { (void)read_mesh(TemporaryFile(bytes, ".off").path()); }
void read_stl_bytes(std::string_view bytes) { (void)read_mesh(TemporaryFile(bytes, ".stl").path()); }

/// What a scene may name: walk.mot, landmarks.json and ball.ply.
class SceneFolder {
 public:
  SceneFolder() {
    std::ofstream(m_folder / "walk.mot") << "endheader\ntime hip\n0 0\n1 60\n";
    std::ofstream(m_folder / "landmarks.json")
        << R"({"attachments": [{"muscle": "m", "role": "origin", "points_m": [[0, 0, 0], [0.03, 0, 0], [0, 0.03, 0]]}],
               "fibres": [{"muscle": "m", "polylines_m": [[[0, 0, 0], [0, 0, 0.01]]]}]})";
    write_ply(make_sphere(0.02, 1), m_folder / "ball.ply");
  }
  [[nodiscard]] const std::filesystem::path& path() const { return m_folder.path(); }

 private:
  TemporaryFolder m_folder;
};

/// Every synthetic mesh that it names is a small ball. That of "n" lies beside the others: two muscles have two meshes.
void read_scene_bytes(std::string_view bytes) {
  static const SceneFolder folder;
  SceneRequest request;
  request.name = request.file = "scene.toml";
  request.text = bytes;
  request.folder = folder.path();
  request.data_folder = folder.path();
  request.preset_text = [](const std::string&) { return std::string("[effects.edge_length]\n[loop]\nframes = 9\n"); };
  request.synthetic_mesh = [](const std::string& name) {
    TriangleMesh ball = make_sphere(0.02, 1);
    for (Vec3& vertex : ball.vertices) vertex.x() += name == "n" ? 0.03 : 0;
    return ball;
  };
  (void)read_scene(request);
}

void read_motion_bytes(std::string_view bytes) {
  const TemporaryFile file(bytes, ".mot");
  BoneRotation motion;
  motion.centre_m = Vec3(0.1, 0, 0);
  const MotionTable table = read_motion_table(file.path(), "hip_flexion_r");
  motion.times = table.times;
  motion.angles_rad = table.values;
  for (const double progress : {0.0, 0.3, 0.5, 1.0}) {
    if (!std::isfinite(motion.angle_rad(progress))) throw std::logic_error("an angle that is not finite was read");
  }
}

void read_landmark_bytes(std::string_view bytes) {
  const TemporaryFile file(bytes, ".json");
  try {
    (void)read_landmark_outline(file.path(), "muscle/origin");
  } catch (const InputError&) {  // it may hold fibres only
  }
  (void)read_landmark_fibres(file.path(), "muscle");
}

/// A recording ends in its hash: no change of a bit would get past it.
std::string with_recording_hash(std::string bytes) {
  Sha256 hash;
  hash.add(bytes);
  return bytes.append(recording_hash_mark).append(hash.hex_digest());
}

void read_whole_recording(const std::string& bytes) {
  const TemporaryFile file(bytes, ".recording");
  RecordingReader reader(file.path());
  // Steps in which nothing moves take two bytes each in the file and as much memory as others: how many of them are
  // read is a matter of the machine.
  constexpr double most_positions = 1e6;
  if (1.0 * reader.header().nodes * reader.header().steps_per_frame() > most_positions) return;
  RecordedFrame frame;
  for (int i = 0; i < reader.header().frames(); ++i) reader.read(frame);
}

void read_recording_bytes(std::string_view bytes) { read_whole_recording(with_recording_hash(std::string(bytes))); }

template <typename Number>
void append_number(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

/// Takes a part from the front of `bytes` that stands after its length; what is there where that is too long.
std::string_view take_part(std::string_view& bytes) {
  std::uint16_t size = 0;
  std::memcpy(&size, bytes.data(), std::min(sizeof size, bytes.size()));
  bytes.remove_prefix(std::min(sizeof size, bytes.size()));
  const std::string_view part = bytes.substr(0, size);
  bytes.remove_prefix(part.size());
  return part;
}

/// The header and the frames of a recording, not compressed, each after its length: a change reaches the decoder of
/// steps, where a change of compressed bytes seldom gets past the decompression.
void read_recording_parts(std::string_view bytes) {
  std::string recording = std::string(recording_magic) + std::string(recording_version);
  const std::string_view header = take_part(bytes);
  append_number(recording, std::uint64_t{header.size()});
  recording += header;
  std::string block;
  while (!bytes.empty()) {
    const std::string_view frame = take_part(bytes);
    block.resize(ZSTD_compressBound(frame.size()));
    block.resize(ZSTD_compress(block.data(), block.size(), frame.data(), frame.size(), 1));
    append_number(recording, static_cast<std::uint32_t>(block.size()));
    recording += block;
  }
  append_number(recording, std::uint32_t{0});
  read_whole_recording(with_recording_hash(recording));
}

RecordingHeader small_recording_header(bool muscle_contact) {
  RecordingHeader header;
  header.scene = "a small scene";
  header.loop_overrides = {{"frames", std::int64_t{2}}, {"time_step_s", 0.5}, {"bone_motion", std::string("x")}};
  header.nodes = 3;
  header.muscles = 2;
  header.muscle_contact = muscle_contact;
  header.bones = 1;
  header.substeps = 2;
  header.iterations = 2;
  header.rounding_m = rounding_step_m(1);
  header.angles_deg = {0, 45};
  header.free_nodes = {0, 2};
  return header;
}

/// Calls add(start, positions, muscle positions, poses) for all steps of such a recording.
template <typename Add>
void for_each_step_of(const RecordingHeader& header, const Add& add) {
  std::vector<Vec3> start(static_cast<std::size_t>(header.nodes), Vec3(0.1, 0.2, 0.3));
  for (int step = 0; step < header.frames() * header.steps_per_frame(); ++step) {
    std::vector<Vec3> positions = start;
    positions.back() += Vec3(1e-3 * step, 0, 0);
    add(start, positions, header.muscle_contact ? positions : std::vector<Vec3>{}, std::vector<RigidMotion>(1));
  }
}

std::vector<std::string> make_recordings() {
  std::vector<std::string> recordings;
  for (const bool muscle_contact : {false, true}) {
    const RecordingHeader header = small_recording_header(muscle_contact);
    const TemporaryFile file(with_recording_hash(std::string(recording_magic)), ".recording");
    RecordingWriter writer(file.path(), header);
    for_each_step_of(header, [&](const auto& start, const auto& positions, const auto& muscle, const auto& poses) {
      (void)writer.add_step(start, poses, positions, poses, muscle);
    });
    (void)writer.finish();
    const std::string bytes = file.bytes();
    recordings.push_back(bytes.substr(0, bytes.size() - recording_hash_mark.size() - recording_hash_digits));
  }
  return recordings;
}

void append_part(std::string& bytes, std::string_view part) {
  append_number(bytes, static_cast<std::uint16_t>(part.size()));
  bytes += part;
}

std::vector<std::string> make_parts_of_recordings() {
  std::vector<std::string> seeds;
  for (const bool muscle_contact : {false, true}) {
    const RecordingHeader header = small_recording_header(muscle_contact);
    StepEncoder encoder(header);
    append_part(seeds.emplace_back(), text_of(header));
    std::string frame;
    int steps = 0;
    for_each_step_of(header, [&](const auto& start, const auto& positions, const auto& muscle, const auto& poses) {
      (void)encoder.encode(start, poses, positions, poses, frame, muscle);
      if (++steps % header.steps_per_frame() == 0) append_part(seeds.back(), std::exchange(frame, {}));
    });
  }
  return seeds;
}

}  // namespace

std::span<const FuzzedReader> fuzzed_readers() {
  static constexpr std::array readers = {
      FuzzedReader{"ply", read_ply_bytes},
      FuzzedReader{"obj", read_obj_bytes},
      FuzzedReader{"off", read_off_bytes},
      FuzzedReader{"stl", read_stl_bytes},
      FuzzedReader{"scene", read_scene_bytes},
      FuzzedReader{"motion", read_motion_bytes},
      FuzzedReader{"landmarks", read_landmark_bytes},
      FuzzedReader{"recording", read_recording_bytes, make_recordings},
      FuzzedReader{"recording_parts", read_recording_parts, make_parts_of_recordings},
  };
  return readers;
}

}  // namespace musclebench

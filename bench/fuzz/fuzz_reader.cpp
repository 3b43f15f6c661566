// What libFuzzer calls again and again with bytes that one reader takes for a file: the one that the environment names
// (MUSCLEBENCH_FUZZED_READER). A reader refuses them with an
// InputError or reads them; anything else that it throws ends the program, as a sanitizer's report does.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

#include "backends/sdf/files/discregrid_file.hpp"
#include "backends/sdf/files/field_file.hpp"
#include "backends/sdf/files/octree_file.hpp"
#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh_files/read_mesh.hpp"
#include "core/recording/recording_header.hpp"
#include "core/recording/recording_reader.hpp"
#include "core/scene/bone_motion.hpp"
#include "core/scene/landmarks.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

/// The bytes as a file, which is gone with this.
class TemporaryFile {
 public:
  TemporaryFile(std::span<const std::uint8_t> bytes, const std::string& ending)
      : m_path(std::filesystem::temp_directory_path() / ("musclebench-fuzz-" + std::to_string(getpid()) + ending)) {
    std::ofstream(m_path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(m_path, ignored);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return m_path; }

 private:
  std::filesystem::path m_path;
};

using Bytes = std::span<const std::uint8_t>;

void read_mesh_of(Bytes bytes, const std::string& ending) { (void)read_mesh(TemporaryFile(bytes, ending).path()); }
void read_ply(Bytes bytes) { read_mesh_of(bytes, ".ply"); }
void read_obj(Bytes bytes) { read_mesh_of(bytes, ".obj"); }
void read_off(Bytes bytes) { read_mesh_of(bytes, ".off"); }
void read_stl(Bytes bytes) { read_mesh_of(bytes, ".stl"); }

/// Every mesh that it names is a small ball.
void read_scene(Bytes bytes) {
  SceneRequest request;
  request.name = request.file = "scene.toml";
  request.text.assign(bytes.begin(), bytes.end());
  request.folder = "/nonexistent";
  request.preset_text = [](const std::string&) { return std::string("title = \"preset\"\n"); };
  request.synthetic_mesh = [](const std::string&) { return make_sphere(0.02, 1); };
  (void)musclebench::read_scene(request);
}

void read_motion(Bytes bytes) { (void)read_motion_table(TemporaryFile(bytes, ".mot").path(), "hip_flexion_r"); }

void read_landmarks(Bytes bytes) {
  const TemporaryFile file(bytes, ".json");
  (void)read_landmark_fibres(file.path(), "muscle");
}

/// With the hash that its bytes have, as no change of a bit would get past it.
void read_recording(Bytes bytes) {
  Sha256 hash;
  hash.add(std::as_bytes(bytes));
  std::vector<std::uint8_t> sealed(bytes.begin(), bytes.end());
  for (const char letter : std::string(recording_hash_mark) + hash.hex_digest()) {
    sealed.push_back(static_cast<std::uint8_t>(letter));
  }
  const TemporaryFile file(sealed, ".recording");
  RecordingReader reader(file.path());
  RecordedFrame frame;
  for (int i = 0; i < reader.header().frames(); ++i) reader.read(frame);
}

void read_field(Bytes bytes) { (void)load_field(TemporaryFile(bytes, ".field").path(), "", {}, {}); }
void read_octree(Bytes bytes) { (void)load_octree(TemporaryFile(bytes, ".octree").path(), "", {}); }
void read_discregrid(Bytes bytes) { (void)musclebench::read_discregrid(TemporaryFile(bytes, ".cdf").path(), 1); }

struct NamedReader {
  std::string_view name;
  void (*read)(Bytes bytes);
};

constexpr std::array readers = {
    NamedReader{"ply", read_ply},
    NamedReader{"obj", read_obj},
    NamedReader{"off", read_off},
    NamedReader{"stl", read_stl},
    NamedReader{"scene", read_scene},
    NamedReader{"motion", read_motion},
    NamedReader{"landmarks", read_landmarks},
    NamedReader{"recording", read_recording},
    NamedReader{"field", read_field},
    NamedReader{"octree", read_octree},
    NamedReader{"discregrid", read_discregrid},
};

/// The one that the environment names.
const NamedReader& chosen_reader() {
  const char* wanted = std::getenv("MUSCLEBENCH_FUZZED_READER");
  const auto* found = std::ranges::find(readers, wanted == nullptr ? "" : wanted, &NamedReader::name);
  if (found == readers.end()) {
    std::fputs("MUSCLEBENCH_FUZZED_READER names no reader\n", stderr);
    std::exit(2);
  }
  return *found;
}

}  // namespace
}  // namespace musclebench

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const musclebench::NamedReader& reader = musclebench::chosen_reader();
  try {
    reader.read({data, size});
  } catch (const musclebench::InputError&) {
    return 0;
  }
  return 0;
}

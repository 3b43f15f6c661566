#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/recording/recording_header.hpp"
#include "core/recording/recording_reader.hpp"
#include "core/recording/recording_writer.hpp"

namespace musclebench {
namespace {

namespace fs = std::filesystem;

class Recording : public testing::Test {
 protected:
  void SetUp() override {
    m_header.scene = "a scene";
    m_header.scene_source = "/somewhere/scene.toml";
    m_header.preset = "paper";
    m_header.loop_overrides = {{"frames", std::int64_t{3}}, {"time_step_s", 1.0}, {"bone_motion", std::string("x")}};
    m_header.scene_sha256 = std::string(64, 'a');
    m_header.backend = "bvh";
    m_header.build = "v1";
    m_header.nodes = 5;
    m_header.bones = 1;
    m_header.muscles = 3;
    m_header.substeps = 2;
    m_header.iterations = 2;
    m_header.rounding_m = rounding_step_m(1);
    m_header.angles_deg = {0.1, 1.0 / 3, 90};
    m_header.free_nodes = {0, 2, 4};
  }

  /// Of a node at a step, counted over all frames; a whole number of rounding steps.
  static Vec3 position(int step, int node) { return {node + step * 0.25, std::ldexp(step * step, -20), -1.0 * node}; }
  static RigidMotion pose(int substep) {
    return RigidMotion::about_axis(Vec3::UnitY(), Vec3(0.1, 0.2, 0.3), 0.01 * substep);
  }

  bool add_step(RecordingWriter& writer, int step) const {
    std::vector<Vec3> start;
    std::vector<Vec3> positions;
    for (int node = 0; node < m_header.nodes; ++node) {
      start.push_back(position(step / 2 * 2, node));
      positions.push_back(position(step + 1, node));
    }
    return writer.add_step(start, std::vector{pose(step / 2)}, positions, std::vector{pose(step / 2 + 1)});
  }

  RecordingFile write() const {
    RecordingWriter writer(m_file, m_header);
    for (int step = 0; step < 12; ++step) {
      EXPECT_TRUE(add_step(writer, step));
    }
    return writer.finish();
  }

  [[nodiscard]] std::string content() const {
    std::ifstream stream(m_file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void replace_content(const std::string& bytes) const { std::ofstream(m_file, std::ios::binary) << bytes; }

  /// What reading the file to its end complains of; empty when it doesn't.
  [[nodiscard]] std::string complaint() const {
    try {
      RecordingReader reader(m_file);
      RecordedFrame frame;
      for (int i = 0; i < reader.header().frames(); ++i) {
        reader.read(frame);
      }
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  /// With the hash that the changed bytes have.
  void replace_sealed(std::string bytes) const {
    bytes.resize(bytes.size() - recording_hash_digits);
    Sha256 hash;
    hash.add(bytes.substr(0, bytes.size() - recording_hash_mark.size()));
    replace_content(bytes + hash.hex_digest());
  }
  /// Replaces words of the header.
  void claim(const std::string& words, const std::string& others) const {
    std::string bytes = content();
    const std::size_t offset = bytes.find(words);
    ASSERT_NE(offset, std::string::npos);
    bytes.replace(offset, words.size(), others);
    std::uint64_t size = 0;
    constexpr std::size_t size_offset = recording_magic.size() + recording_version.size();
    std::memcpy(&size, bytes.data() + size_offset, sizeof size);
    size += others.size() - words.size();
    std::memcpy(bytes.data() + size_offset, &size, sizeof size);
    replace_sealed(bytes);
  }

  [[nodiscard]] long files() const {
    return std::distance(fs::directory_iterator(m_folder.path()), fs::directory_iterator());
  }

  TemporaryFolder m_folder;
  fs::path m_file = m_folder / "walk.recording";
  RecordingHeader m_header;
};

/// Such files are what they were before recordings told what contact between muscles is asked about.
TEST_F(Recording, OfMusclesThatTouchNoneIsTheSameToTheByte) {
  StepEncoder encoder(m_header);
  std::string bytes = text_of(m_header);
  const std::vector<RigidMotion> at_rest(1);
  for (int step = 0; step < 8; ++step) {
    std::vector<Vec3> start;
    std::vector<Vec3> positions;
    for (int node = 0; node < m_header.nodes; ++node) {
      start.push_back(position(step / 2 * 2, node));
      positions.push_back(position(step + 1, node));
    }
    ASSERT_TRUE(encoder.encode(start, at_rest, positions, at_rest, bytes));
  }
  Sha256 hash;
  hash.add(bytes);
  EXPECT_EQ(hash.hex_digest(), "9e435bfc4cd93f7f2b897e6087c3bc5910d7ca0523dceac5b526719d446ccc3f");
}

TEST_F(Recording, ReadsBackTheHeader) {
  m_header.motion_overrides = {{"to_deg", 30.0}};
  m_header.mesh_overrides = {{"split_muscles", std::int64_t{1}}};
  const RecordingFile written = write();
  const RecordingReader reader(m_file);
  const RecordingHeader& header = reader.header();
  EXPECT_EQ(header.scene, m_header.scene);
  EXPECT_EQ(header.scene_source, m_header.scene_source);
  EXPECT_EQ(header.preset, m_header.preset);
  EXPECT_EQ(header.loop_overrides, m_header.loop_overrides);
  EXPECT_EQ(header.motion_overrides, m_header.motion_overrides);
  EXPECT_EQ(header.mesh_overrides, m_header.mesh_overrides);
  EXPECT_EQ(header.scene_sha256, m_header.scene_sha256);
  EXPECT_EQ(header.backend, m_header.backend);
  EXPECT_EQ(header.build, m_header.build);
  EXPECT_EQ(header.nodes, m_header.nodes);
  EXPECT_EQ(header.bones, m_header.bones);
  EXPECT_EQ(header.muscles, m_header.muscles);
  EXPECT_EQ(header.substeps, m_header.substeps);
  EXPECT_EQ(header.iterations, m_header.iterations);
  EXPECT_EQ(header.rounding_m, m_header.rounding_m);
  EXPECT_EQ(header.angles_deg, m_header.angles_deg);
  EXPECT_EQ(header.free_nodes, m_header.free_nodes);
  EXPECT_EQ(reader.file().sha256, written.sha256);
  EXPECT_EQ(reader.file().bytes, written.bytes);
  EXPECT_EQ(written.bytes, fs::file_size(m_file));
}

TEST_F(Recording, ReadsBackEveryStepTwice) {
  write();
  RecordingReader reader(m_file);
  RecordedFrame frame;
  for (int pass = 0; pass < 2; ++pass) {
    for (int step = 0; step < 12; ++step) {
      if (step % 4 == 0) {
        reader.read(frame);
        ASSERT_EQ(frame.frame, step / 4 + 1);
        ASSERT_EQ(frame.angle_deg, m_header.angles_deg[step / 4]);
        ASSERT_EQ(frame.steps.size(), 4U);
      }
      const RecordedStep& read = frame.steps[step % 4];
      for (int node = 0; node < m_header.nodes; ++node) {
        EXPECT_EQ(read.substep_start[node], position(step / 2 * 2, node));
        EXPECT_EQ(read.positions[node], position(step + 1, node));
      }
      EXPECT_EQ(read.previous_bone_poses[0].rotation, pose(step / 2).rotation);
      EXPECT_EQ(read.bone_poses[0].translation_m, pose(step / 2 + 1).translation_m);
    }
    EXPECT_THROW(reader.read(frame), InputError);
    reader.rewind();
  }
}

TEST_F(Recording, TheSameStepsMakeTheSameFile) {
  write();
  const std::string first = content();
  write();
  EXPECT_EQ(content(), first);
  EXPECT_EQ(files(), 1);
}

TEST_F(Recording, EveryTruncationIsRefused) {
  write();
  const std::string whole = content();
  ASSERT_EQ(complaint(), "");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    replace_content(whole.substr(0, size));
    const std::string said = complaint();
    ASSERT_NE(said, "") << size;
    EXPECT_NE(said.find(m_file.string()), std::string::npos);
    if (size > 30) {
      EXPECT_NE(said.find("truncated"), std::string::npos) << size << ": " << said;
    }
  }
}

TEST_F(Recording, EveryChangedByteIsRefused) {
  write();
  const std::string whole = content();
  for (std::size_t offset = 0; offset < whole.size(); ++offset) {
    std::string changed = whole;
    changed[offset] = static_cast<char>(changed[offset] ^ 4);
    replace_content(changed);
    ASSERT_NE(complaint(), "") << offset;
  }
}

TEST_F(Recording, AChangeNamesBothHashes) {
  const std::string sha256 = write().sha256;
  std::string changed = content();
  changed[changed.size() / 2] ^= 1;
  replace_content(changed);
  const std::string said = complaint();
  EXPECT_NE(said.find("ends in " + sha256), std::string::npos) << said;
  EXPECT_NE(said.find("its hash is "), std::string::npos) << said;
}

TEST_F(Recording, OtherFilesAreRefused) {
  for (const std::string& bytes : {std::string(), std::string("ply\n"), std::string(5000, '\0')}) {
    replace_content(bytes);
    EXPECT_NE(complaint().find("is not a recording"), std::string::npos);
  }
  write();
  std::string other = content();
  other[std::string("musclebench recording ").size()] = '2';
  replace_content(other);
  EXPECT_NE(complaint().find("version '2'"), std::string::npos) << complaint();
  fs::remove(m_file);
  EXPECT_NE(complaint().find("cannot be read"), std::string::npos);
}

TEST_F(Recording, APipeIsRefused) {
  ASSERT_EQ(mkfifo(m_file.c_str(), 0600), 0);
  EXPECT_NE(complaint().find("cannot be read"), std::string::npos) << "opening it would wait for ever";
  EXPECT_THROW(require_recording_writable(m_file), InputError);
}

TEST_F(Recording, AHugeFileOfSomethingElseIsToldByItsEnds) {
  constexpr std::uintmax_t too_much_to_hash = std::uintmax_t{1} << 42;
  std::string begin(recording_magic);
  begin += recording_version;
  replace_content(begin);
  std::error_code error;
  fs::resize_file(m_file, too_much_to_hash, error);  // a hole, which takes no room
  if (error) {
    GTEST_SKIP() << "the folder of temporary files has no files with holes";
  }
  EXPECT_NE(complaint().find("truncated"), std::string::npos) << complaint();
  std::ofstream(m_file, std::ios::binary | std::ios::app) << recording_hash_mark << std::string(64, 'a');
  EXPECT_NE(complaint().find("header that cannot be read"), std::string::npos) << complaint();
  {
    std::fstream file(m_file, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(begin.size()));
    file << std::string(8, '\xff');
  }
  EXPECT_NE(complaint().find("longer than the file"), std::string::npos) << complaint();
}

TEST_F(Recording, AWriterThatEndsEarlyLeavesNothing) {
  {
    RecordingWriter writer(m_file, m_header);
    EXPECT_TRUE(add_step(writer, 0));
    EXPECT_TRUE(fs::exists(writer.part()));
  }
  EXPECT_EQ(files(), 0);
}

TEST_F(Recording, AForeignFileIsNotReplaced) {
  EXPECT_NO_THROW(require_recording_writable(m_file));
  replace_content("three years of work");
  EXPECT_THROW(require_recording_writable(m_file), InputError);
  EXPECT_THROW(require_recording_writable(m_folder.path()), InputError);
  EXPECT_THROW(require_recording_writable(m_folder / "no/such/folder/file"), InputError);
  write();
  EXPECT_NO_THROW(require_recording_writable(m_file));
  EXPECT_EQ(files(), 1);
}

TEST_F(Recording, AHeaderThatClaimsMoreNodesThanThereAreIsRefusedBeforeMemoryIsTaken) {
  (void)write();
  claim("\"nodes\":5", "\"nodes\":1000000000");
  EXPECT_NE(complaint().find("claims 1000000000 nodes"), std::string::npos) << complaint();
}

/// The size that a frame claims was believed, and 24 GB were taken for the nodes.
TEST_F(Recording, AFrameThatClaimsMoreThanItHoldsProvesNoNodes) {
  (void)write();
  claim("\"nodes\":5", "\"nodes\":1000000000");
  std::string bytes = content();
  const std::size_t frame = bytes.find("\x28\xb5\x2f\xfd");  // where Zstandard begins
  ASSERT_NE(frame, std::string::npos);
  ASSERT_EQ(bytes[frame + 4] & '\xc0', '\x40') << "a claim of two bytes, which begins after the flags";
  bytes[frame + 4] = static_cast<char>(bytes[frame + 4] | '\xc0');  // of eight
  bytes.replace(frame + 5, 2, std::string("\0\0\0\x00\x01\0\0\0", 8));
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + frame - sizeof size, sizeof size);
  size += 6;
  std::memcpy(bytes.data() + frame - sizeof size, &size, sizeof size);
  replace_sealed(bytes);
  EXPECT_NE(complaint().find("claims 1000000000 nodes"), std::string::npos) << complaint();
}

/// Memory for so many steps was taken before a frame was asked for them.
TEST_F(Recording, AHeaderThatClaimsMoreStepsThanAFrameHoldsIsRefused) {
  (void)write();
  claim("\"substeps\":2", "\"substeps\":1000000000");
  EXPECT_NE(complaint().find("claims 2000000000 steps a frame"), std::string::npos) << complaint();
}

TEST_F(Recording, AHeaderThatContradictsItselfIsRefused) {
  m_header.free_nodes = {0, 7};
  write();
  EXPECT_NE(complaint().find("contradicts itself"), std::string::npos) << complaint();
}

}  // namespace
}  // namespace musclebench

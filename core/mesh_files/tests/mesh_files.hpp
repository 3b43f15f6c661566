#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/mesh_files/read_mesh.hpp"

namespace musclebench {

namespace fs = std::filesystem;

/// Files in a folder of its own, which goes with the test.
class MeshFiles : public testing::Test {
 protected:
  [[nodiscard]] fs::path path(const std::string& name) const { return m_folder / name; }

  [[nodiscard]] fs::path write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }

  /// The file is refused in one line that begins with its path and holds `part`.
  static void expect_refused(const fs::path& file, const std::string& part) {
    try {
      read_mesh(file);
      ADD_FAILURE() << file << " was accepted";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find(file.string() + ": "), 0U) << message;
      EXPECT_NE(message.find(part), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }

  void expect_refused(const std::string& name, const std::string& content, const std::string& part) const {
    SCOPED_TRACE(name);
    expect_refused(write(name, content), part);
  }

 private:
  TemporaryFolder m_folder;
};

/// Six vertices, the first unreferenced, the second and fifth at one position, a quadrangle among the faces.
inline const std::vector<Vec3> hand_vertices = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1.0 / 3, 1, 0}};
inline const std::string hand_coordinates = "9 9 9\n0 0 0\n1 0 0\n0 1 0\n0 0 0\n0.3333333333333333 1 0\n";
inline const std::string hand_ply_header =
    "ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\nproperty double z\n"
    "element face 3\nproperty list uchar int vertex_indices\nend_header\n";
inline const std::string hand_ply = hand_ply_header + hand_coordinates + "3 1 2 3\n4 4 2 5 3\n3 2 1 3\n";
inline const std::string hand_off = "OFF\n6 3 0\n" + hand_coordinates + "3 1 2 3\n4 4 2 5 3\n3 2 1 3\n";
inline const std::string hand_obj =
    "# by hand\nmtllib none.mtl\no first\nv 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 2/1/1 3/1/1 4/1/1\n"
    "v 0 0 0\nv 0.3333333333333333 1 0\ng second\nusemtl red\nf -2//1 -4//1 6//1 4//1\nl 1 2\nf 3 2 4\n";

inline void expect_hand_mesh(const TriangleMesh& mesh) {
  EXPECT_EQ(mesh.vertices, hand_vertices);
  ASSERT_EQ(mesh.triangles.size(), 4U);
  EXPECT_EQ(mesh.triangles[0], (Triangle{1, 2, 3}));
  EXPECT_EQ(mesh.triangles[3], (Triangle{2, 1, 3}));
  // The quadrangle may be cut either way; both ways keep its area and winding.
  Vec3 area_normal = Vec3::Zero();
  for (const int t : {1, 2}) {
    const Vec3 a = mesh.vertices[mesh.triangles[t][0]];
    const Vec3 b = mesh.vertices[mesh.triangles[t][1]];
    const Vec3 c = mesh.vertices[mesh.triangles[t][2]];
    area_normal += (b - a).cross(c - a) / 2;
    for (const int vertex : mesh.triangles[t]) {
      EXPECT_TRUE(vertex == 4 || vertex == 2 || vertex == 5 || vertex == 3) << vertex;
    }
  }
  EXPECT_NEAR(area_normal.z(), 2.0 / 3, 1e-15);
}

inline std::string with_crlf(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c == '\n' ? "\r\n" : std::string(1, c);
  }
  return out;
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t offset = text.find(from);
  EXPECT_NE(offset, std::string::npos) << from;
  return text.replace(offset, from.size(), to);
}

template <typename T>
void append(std::string& bytes, T value, bool is_big_endian) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (is_big_endian) {
    std::reverse(raw, raw + sizeof(T));
  }
  bytes.append(raw, sizeof(T));
}

/// The hand-made mesh with everything that PLY allows: faces first, strange types, further properties and elements.
inline std::string binary_ply(bool is_big_endian) {
  std::string text = std::string("ply\nformat binary_") + (is_big_endian ? "big" : "little") +
                     "_endian 1.0\ncomment x\nelement face 3\nproperty uchar flag\n"
                     "property list ushort uint vertex_index\nproperty list uchar float texcoord\n"
                     "element edge 1\nproperty int vertex1\nelement vertex 6\nproperty double x\nproperty uchar red\n"
                     "property double y\nproperty double z\nend_header\n";
  const std::vector<std::vector<std::uint32_t>> faces = {{1, 2, 3}, {4, 2, 5, 3}, {2, 1, 3}};
  for (const auto& face : faces) {
    append<std::uint8_t>(text, 7, is_big_endian);
    append(text, static_cast<std::uint16_t>(face.size()), is_big_endian);
    for (const std::uint32_t vertex : face) {
      append(text, vertex, is_big_endian);
    }
    append<std::uint8_t>(text, 1, is_big_endian);
    append<float>(text, 0.5F, is_big_endian);
  }
  append<std::int32_t>(text, 3, is_big_endian);
  for (const Vec3& vertex : hand_vertices) {
    append(text, vertex.x(), is_big_endian);
    append<std::uint8_t>(text, 255, is_big_endian);
    append(text, vertex.y(), is_big_endian);
    append(text, vertex.z(), is_big_endian);
  }
  return text;
}

inline std::string binary_stl(const TriangleMesh& mesh) {
  std::string text = "solid but binary";
  text.resize(80, ' ');
  append(text, static_cast<std::uint32_t>(mesh.triangles.size()), false);
  for (const Triangle& triangle : mesh.triangles) {
    text.append(12, '\0');
    for (const int vertex : triangle) {
      for (const double x : mesh.vertices[vertex]) {
        append(text, static_cast<float>(x), false);
      }
    }
    text.append(2, '\0');
  }
  return text;
}

inline const std::string ascii_stl =
    "  solid a\n facet normal -nan(ind) 0 1\n  OUTER LOOP\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  "
    "endloop\n"
    " endfacet\nendsolid a\nsolid b\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 "
    "0\nendloop\n"
    "endfacet\nendsolid b\n";

}  // namespace musclebench

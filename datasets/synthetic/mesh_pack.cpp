#include "datasets/synthetic/mesh_pack.hpp"

#include <array>
#include <cstdint>
#include <cstring>

namespace musclebench {

namespace {

struct Header {
  std::array<char, 32> name = {};
  std::uint64_t vertex_bytes = 0;
  std::uint64_t triangle_bytes = 0;
};

}  // namespace

TriangleMesh PackedMesh::mesh() const {
  TriangleMesh mesh;
  mesh.vertices.resize(vertices.size() / sizeof(Vec3));
  mesh.triangles.resize(triangles.size() / sizeof(Triangle));
  std::memcpy(mesh.vertices.data()->data(), vertices.data(), vertices.size());
  std::memcpy(mesh.triangles.data(), triangles.data(), triangles.size());
  return mesh;
}

void append_to_pack(std::string_view name, const TriangleMesh& mesh, std::ostream& out) {
  Header header{.vertex_bytes = mesh.vertices.size() * sizeof(Vec3),
                .triangle_bytes = mesh.triangles.size() * sizeof(Triangle)};
  name.copy(header.name.data(), header.name.size() - 1);
  out.write(reinterpret_cast<const char*>(&header), sizeof(header));
  out.write(reinterpret_cast<const char*>(mesh.vertices.data()), static_cast<std::streamsize>(header.vertex_bytes));
  out.write(reinterpret_cast<const char*>(mesh.triangles.data()), static_cast<std::streamsize>(header.triangle_bytes));
}

std::vector<PackedMesh> packed_meshes(std::span<const char> bytes) {
  std::vector<PackedMesh> meshes;
  while (!bytes.empty()) {
    Header header;
    std::memcpy(&header, bytes.data(), sizeof(header));
    const char* name = bytes.data() + offsetof(Header, name);
    bytes = bytes.subspan(sizeof(header));
    meshes.push_back(
        {name, bytes.first(header.vertex_bytes), bytes.subspan(header.vertex_bytes, header.triangle_bytes)});
    bytes = bytes.subspan(header.vertex_bytes + header.triangle_bytes);
  }
  return meshes;
}

}  // namespace musclebench

#include "core/mesh_files/read_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "core/mesh/mesh_edges.hpp"
#include "core/mesh_files/polygon_mesh.hpp"

namespace musclebench {

namespace {

std::string read_text(const std::filesystem::path& path, const std::string& place) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw InputError(place, "there is no such file; check the path");
  }
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw InputError(place, "is no file but a folder or device; name a mesh file");
  }
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file.is_open() || file.bad()) {
    throw InputError(place, "can't be read; check its permissions");
  }
  if (text.empty()) {
    throw InputError(place, "is empty; copy or export it anew");
  }
  return text;
}

/// Adds the meshes of `node` and its children at their places.
void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& to_parent, PolygonMeshBuilder& builder,
              unsigned& vertices) {
  const aiMatrix4x4 to_world = to_parent * node.mTransformation;
  const bool is_mirrored = aiMatrix3x3(to_world).Determinant() < 0;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D place = to_world * mesh.mVertices[v];
      builder.add_vertex(Vec3(place.x, place.y, place.z));
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      builder.begin_polygon();
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        builder.add_corner(vertices + face.mIndices[is_mirrored ? face.mNumIndices - 1 - k : k]);
      }
      builder.end_polygon();
    }
    vertices += mesh.mNumVertices;
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    add_node(scene, *node.mChildren[c], to_world, builder, vertices);
  }
}

PolygonMesh read_through_assimp(const std::filesystem::path& path, const std::string& place) {
  Assimp::Importer importer;
  if (!importer.IsExtensionSupported(path.extension().string())) {
    throw InputError(place, "has an ending of no known mesh format; write it as PLY, OBJ, STL or OFF");
  }
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    std::string reason = importer.GetErrorString();
    std::replace_if(
        reason.begin(), reason.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, ' ');
    throw InputError(place, fmt::format("assimp can't read it ({}); write it as PLY", reason.substr(0, 200)));
  }
  PolygonMeshBuilder builder(place);
  unsigned vertices = 0;
  add_node(*scene, *scene->mRootNode, aiMatrix4x4(), builder, vertices);
  return builder.finish();
}

PolygonMesh read_polygons(const std::filesystem::path& path, const std::string& place) {
  using Parser = PolygonMesh (*)(std::string_view, const std::string&);
  constexpr std::array<std::pair<std::string_view, Parser>, 4> parsers = {
      {{".ply", parse_ply}, {".obj", parse_obj}, {".off", parse_off}, {".stl", parse_stl}}};
  const std::string ending = lower_case(path.extension().string());
  const std::string text = read_text(path, place);
  const auto parser = std::find_if(parsers.begin(), parsers.end(), [&](const auto& e) { return e.first == ending; });
  return parser != parsers.end() ? parser->second(text, place) : read_through_assimp(path, place);
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& path) {
  const std::string place = path.string();
  PolygonMesh polygons = read_polygons(path, place);
  TriangleMesh mesh;
  mesh.triangles = split_into_triangles(polygons);
  mesh.vertices = std::move(polygons.vertices);
  if (mesh.triangles.empty()) {
    throw InputError(place, "holds no triangles; export the surface of the mesh");
  }
  if (std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) { return is_flat(mesh, t); })) {
    throw InputError(place, "holds only triangles without area; export the mesh anew");
  }
  return mesh;
}

void write_ply(const TriangleMesh& mesh, const std::filesystem::path& path) {
  std::filesystem::path unfinished = path;
  unfinished += ".part";
  std::ofstream file(unfinished, std::ios::binary);
  file << fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double "
      "z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3& vertex : mesh.vertices) {
    file.write(reinterpret_cast<const char*>(vertex.data()), 3 * sizeof(double));
  }
  for (const Triangle& triangle : mesh.triangles) {
    file.put(3);
    file.write(reinterpret_cast<const char*>(triangle.data()), sizeof(triangle));
  }
  file.close();
  std::error_code error;
  if (file) {
    std::filesystem::rename(unfinished, path, error);
  }
  if (!file || error) {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    throw InputError(path.string(), "can't be written; check the folder, its permissions and the free space");
  }
}

}  // namespace musclebench

#include "core/mesh_files/read_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "core/base/atomic_file.hpp"
#include "core/base/input_file.hpp"
#include "core/base/system_memory.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh_files/polygon_mesh.hpp"

namespace musclebench {

namespace {

/// Garbage is told by its beginning, before the rest of it is read.
constexpr std::size_t head_bytes = 1 << 20;

/// Groups in groups of a scene: far more than people make, far less than the stack holds.
constexpr int most_nested_nodes = 256;

/// Adds the meshes of `node`, which lies in `depth` others, and its children where they are placed.
void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& to_parent, PolygonMeshBuilder& builder,
              unsigned& vertices, const std::string& location, int depth = 0) {
  if (depth > most_nested_nodes) {
    throw InputError(
        location, fmt::format("nests its nodes more than {} deep; export the mesh without groups", most_nested_nodes));
  }
  const aiMatrix4x4 to_world = to_parent * node.mTransformation;
  const bool is_mirrored = aiMatrix3x3(to_world).Determinant() < 0;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D position = to_world * mesh.mVertices[v];
      builder.add_vertex(Vec3(position.x, position.y, position.z));
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
    add_node(scene, *node.mChildren[c], to_world, builder, vertices, location, depth + 1);
  }
}

PolygonMesh read_through_assimp(const std::filesystem::path& path, std::uintmax_t bytes, const std::string& location) {
  Assimp::Importer importer;
  if (!importer.IsExtensionSupported(path.extension().string())) {
    throw InputError(location, "has an ending of no known mesh format; write it as PLY, OBJ, STL or OFF");
  }
  require_memory(static_cast<std::size_t>(bytes), location, "name a smaller file");  // which assimp reads at once
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    std::string reason = importer.GetErrorString();
    std::replace_if(
        reason.begin(), reason.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, ' ');
    throw InputError(location, fmt::format("assimp can't read it ({}); write it as PLY", reason.substr(0, 200)));
  }
  PolygonMeshBuilder builder(location);
  unsigned vertices = 0;
  add_node(*scene, *scene->mRootNode, aiMatrix4x4(), builder, vertices, location);
  return builder.finish();
}

PolygonMesh read_polygons(const std::filesystem::path& path, const std::string& location) {
  struct Format {
    std::string_view ending;
    void (*require_head)(const FileHead& head, const std::string& location);
    PolygonMesh (*parse)(std::string_view text, const std::string& location);
  };
  constexpr std::array<Format, 4> formats = {{{".ply", require_ply_head, parse_ply},
                                              {".obj", require_obj_head, parse_obj},
                                              {".off", require_off_head, parse_off},
                                              {".stl", require_stl_head, parse_stl}}};
  const std::string ending = lower_case(path.extension().string());
  InputFile file(path);
  if (file.bytes() == 0) {
    throw InputError(location, "is empty; copy or export it anew");
  }
  const auto format = std::find_if(formats.begin(), formats.end(), [&](const auto& f) { return f.ending == ending; });
  if (format == formats.end()) {
    return read_through_assimp(path, file.bytes(), location);
  }
  if (file.bytes() > head_bytes) {
    format->require_head({file.head(head_bytes), file.bytes()}, location);
  }
  return format->parse(file.text(), location);
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& path) {
  const std::string location = path.string();
  PolygonMesh polygons = read_polygons(path, location);
  TriangleMesh mesh;
  mesh.triangles = split_into_triangles(polygons);
  mesh.vertices = std::move(polygons.vertices);
  if (mesh.triangles.empty()) {
    throw InputError(location, "holds no triangles; export the surface of the mesh");
  }
  if (std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) { return is_flat(mesh, t); })) {
    throw InputError(location, "holds only triangles without area; export the mesh anew");
  }
  return mesh;
}

void write_ply(const TriangleMesh& mesh, const std::filesystem::path& path) {
  write_atomically(path, [&](std::ostream& out) {
    out << fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
        "property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.size(), mesh.triangles.size());
    for (const Vec3& vertex : mesh.vertices) {
      out.write(reinterpret_cast<const char*>(vertex.data()), 3 * sizeof(double));
    }
    for (const Triangle& triangle : mesh.triangles) {
      out.put(3);
      out.write(reinterpret_cast<const char*>(triangle.data()), sizeof(triangle));
    }
  });
}

}  // namespace musclebench

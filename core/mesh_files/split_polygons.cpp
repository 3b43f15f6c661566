#include <algorithm>
#include <cstdint>
#include <cstring>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "core/mesh_files/polygon_mesh.hpp"

namespace musclebench {

namespace {

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// The polygons of more than three corners as a PLY file for assimp. Each has vertices of its own, which tell whose the
/// triangles are, at its own centre and size, because assimp's floats have no digits for small faces far from the
/// origin.
std::string large_polygons_as_ply(const PolygonMesh& mesh, const std::vector<int>& large) {
  constexpr double size = 1000;
  std::string vertices;
  std::string faces;
  std::int32_t next = 0;
  for (const int polygon : large) {
    const int begin = mesh.first_corner[polygon];
    const int end = mesh.end_corner(polygon);
    Vec3 lower = mesh.vertices[mesh.corners[begin]];
    Vec3 upper = lower;
    for (int corner = begin; corner < end; ++corner) {
      lower = lower.cwiseMin(mesh.vertices[mesh.corners[corner]]);
      upper = upper.cwiseMax(mesh.vertices[mesh.corners[corner]]);
    }
    const double extent = (upper - lower).maxCoeff();
    const double scale = extent > 0 ? size / extent : 0;
    append(faces, static_cast<std::int32_t>(end - begin));
    for (int corner = begin; corner < end; ++corner) {
      const Eigen::Vector3f vertex = ((mesh.vertices[mesh.corners[corner]] - lower) * scale).cast<float>();
      vertices.append(reinterpret_cast<const char*>(vertex.data()), 3 * sizeof(float));
      append(faces, next++);
    }
  }
  return fmt::format(
             "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
             "property float z\nelement face {}\nproperty list int int vertex_indices\nend_header\n",
             next, large.size()) +
         vertices + faces;
}

/// For each of the large polygons its triangles, as corners of the polygon; empty where assimp gave something else.
std::vector<std::vector<Triangle>> cut(const PolygonMesh& mesh, const std::vector<int>& large) {
  std::vector<std::vector<Triangle>> triangles(large.size());
  std::vector<int> owner;
  std::vector<int> first;
  for (std::size_t i = 0; i < large.size(); ++i) {
    first.push_back(static_cast<int>(owner.size()));
    owner.insert(owner.end(), mesh.end_corner(large[i]) - mesh.first_corner[large[i]], static_cast<int>(i));
  }
  const std::string ply = large_polygons_as_ply(mesh, large);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(ply.data(), ply.size(), aiProcess_Triangulate, "ply");
  if (scene == nullptr || scene->mNumMeshes != 1 || scene->mMeshes[0]->mNumVertices != owner.size()) {
    return triangles;
  }
  const aiMesh& result = *scene->mMeshes[0];
  for (unsigned f = 0; f < result.mNumFaces; ++f) {
    const aiFace& face = result.mFaces[f];
    if (face.mNumIndices != 3 || *std::max_element(face.mIndices, face.mIndices + 3) >= owner.size()) {
      continue;
    }
    const int polygon = owner[face.mIndices[0]];
    Triangle triangle{};
    for (int k = 0; k < 3; ++k) {
      triangle[k] = static_cast<int>(face.mIndices[k]) - first[polygon];
    }
    triangles[polygon].push_back(triangle);
  }
  return triangles;
}

void add_fan(const PolygonMesh& mesh, int polygon, std::vector<Triangle>& triangles) {
  const int* corners = mesh.corners.data() + mesh.first_corner[polygon];
  const int count = mesh.end_corner(polygon) - mesh.first_corner[polygon];
  for (int k = 1; k + 1 < count; ++k) {
    triangles.push_back({corners[0], corners[k], corners[k + 1]});
  }
}

}  // namespace

std::vector<Triangle> split_into_triangles(const PolygonMesh& mesh) {
  std::vector<int> large;
  for (int polygon = 0; polygon < mesh.polygons(); ++polygon) {
    if (mesh.end_corner(polygon) - mesh.first_corner[polygon] > 3) {
      large.push_back(polygon);
    }
  }
  std::vector<std::vector<Triangle>> pieces;
  if (!large.empty()) {
    pieces = cut(mesh, large);
  }
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.polygons());
  std::size_t next_large = 0;
  for (int polygon = 0; polygon < mesh.polygons(); ++polygon) {
    const int* corners = mesh.corners.data() + mesh.first_corner[polygon];
    const std::size_t count = mesh.end_corner(polygon) - mesh.first_corner[polygon];
    const std::vector<Triangle>* cut_up = count > 3 ? &pieces[next_large++] : nullptr;
    if (cut_up == nullptr || cut_up->size() != count - 2) {
      add_fan(mesh, polygon, triangles);
      continue;
    }
    for (const Triangle& piece : *cut_up) {
      triangles.push_back({corners[piece[0]], corners[piece[1]], corners[piece[2]]});
    }
  }
  return triangles;
}

}  // namespace musclebench

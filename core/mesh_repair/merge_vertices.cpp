#include "core/mesh_repair/merge_vertices.hpp"

#include <cstddef>

namespace musclebench {

int merge_vertices(TriangleMesh& mesh, const std::vector<int>& first) {
  std::vector<char> is_used(mesh.vertices.size(), 0);
  for (Triangle& triangle : mesh.triangles) {
    for (int& vertex : triangle) {
      is_used[vertex] = 1;
      vertex = first[vertex];
    }
  }
  int merged = 0;
  for (std::size_t vertex = 0; vertex < first.size(); ++vertex) {
    merged += is_used[vertex] != 0 && first[vertex] != static_cast<int>(vertex) ? 1 : 0;
  }
  return merged;
}

int drop_collapsed_triangles(TriangleMesh& mesh) {
  return static_cast<int>(std::erase_if(mesh.triangles, [](const Triangle& triangle) {
    return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
  }));
}

int drop_marked_triangles(TriangleMesh& mesh, const std::vector<char>& is_dropped) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (is_dropped[t] == 0) {
      mesh.triangles[kept++] = mesh.triangles[t];
    }
  }
  const int dropped = static_cast<int>(mesh.triangles.size() - kept);
  mesh.triangles.resize(kept);
  return dropped;
}

std::vector<int> drop_unreferenced_vertices(TriangleMesh& mesh) {
  std::vector<int> new_index(mesh.vertices.size(), -1);
  for (const Triangle& triangle : mesh.triangles) {
    for (const int vertex : triangle) {
      new_index[vertex] = 0;
    }
  }
  int kept = 0;
  for (std::size_t vertex = 0; vertex < new_index.size(); ++vertex) {
    if (new_index[vertex] == 0) {
      mesh.vertices[kept] = mesh.vertices[vertex];
      new_index[vertex] = kept++;
    }
  }
  mesh.vertices.resize(kept);
  for (Triangle& triangle : mesh.triangles) {
    for (int& vertex : triangle) {
      vertex = new_index[vertex];
    }
  }
  return new_index;
}

}  // namespace musclebench

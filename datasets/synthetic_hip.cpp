#include "datasets/synthetic_hip.hpp"

#include <algorithm>

#include "core/base/input_error.hpp"
#include "datasets/synthetic/mesh_pack.hpp"

// What CMake makes of the file of write_synthetic_hip.
extern "C" {
extern const char musclebench_synthetic_hip_begin[];
extern const char musclebench_synthetic_hip_end[];
}

namespace musclebench {

namespace {

std::vector<PackedMesh> all_meshes() {
  return packed_meshes(std::span<const char>(musclebench_synthetic_hip_begin, musclebench_synthetic_hip_end));
}

}  // namespace

std::vector<std::string> synthetic_hip_names() {
  std::vector<std::string> names;
  for (const PackedMesh& each : all_meshes()) names.emplace_back(each.name);
  return names;
}

TriangleMesh synthetic_hip_mesh(std::string_view name) {
  const std::vector<PackedMesh> meshes = all_meshes();
  const auto found = std::ranges::find(meshes, name, &PackedMesh::name);
  if (found != meshes.end()) return found->mesh();
  throw InputError("synthetic:" + std::string(name),
                   "is unknown; did you mean '" + nearest_word(std::string(name), synthetic_hip_names()) + "'?");
}

}  // namespace musclebench

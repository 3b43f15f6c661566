#pragma once

#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// Meshes by name, one after the other in memory, in the byte order of the machine that built the program.
struct PackedMesh {
  std::string_view name;
  std::span<const char> vertices;   ///< of Vec3
  std::span<const char> triangles;  ///< of Triangle

  [[nodiscard]] TriangleMesh mesh() const;
};

/// Of names shorter than 32 letters.
void append_to_pack(std::string_view name, const TriangleMesh& mesh, std::ostream& out);

/// They point into `bytes`, which `append_to_pack` wrote.
std::vector<PackedMesh> packed_meshes(std::span<const char> bytes);

}  // namespace musclebench

#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace musclebench {

/// Simbody's contact mesh behind types of the standard library alone: Simbody's own headers do not compile as C++20.
/// Positions are in metres. Queries are safe from several threads.
class SimbodyMesh {
 public:
  struct Nearest {
    std::array<double, 3> point;
    bool inside;
  };

  /// Throws std::runtime_error with Simbody's words where it refuses the mesh.
  SimbodyMesh(const std::vector<std::array<double, 3>>& vertices, const std::vector<int>& corners);
  SimbodyMesh(const SimbodyMesh&) = delete;
  SimbodyMesh& operator=(const SimbodyMesh&) = delete;
  ~SimbodyMesh();

  [[nodiscard]] Nearest nearest(const std::array<double, 3>& point) const;
  /// By the sizes of what it keeps: corners, edges and normals, and a tree with a box a node.
  [[nodiscard]] std::size_t bytes() const;
  /// Its version, such as "3.7.0".
  [[nodiscard]] static std::string version();

 private:
  struct Mesh;
  std::unique_ptr<Mesh> m_mesh;
};

}  // namespace musclebench

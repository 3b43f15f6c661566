#pragma once

#include <string>
#include <vector>

#include "core/mesh_repair/orient_surfaces.hpp"

namespace musclebench {

/// Says what was changed in a mesh, one line each, in the same words wherever meshes are mended.
class ChangeLog {
 public:
  explicit ChangeLog(std::vector<std::string>& lines) : m_lines(lines) {}

  /// "dropped 3 vertices that ...", nothing where `count` is 0.
  void note(int count, const char* change, const char* singular, const char* plural, const char* rest = "");
  void note_merged(int vertices);
  void note_doubled(int triangles);
  void note_unreferenced(int vertices);
  void note_turned(const OrientationChange& turned);

 private:
  std::vector<std::string>& m_lines;
};

}  // namespace musclebench

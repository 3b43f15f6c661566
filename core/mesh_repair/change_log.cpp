#include "core/mesh_repair/change_log.hpp"

#include <fmt/format.h>

namespace musclebench {

void ChangeLog::note(int count, const char* change, const char* singular, const char* plural, const char* rest) {
  if (count > 0) {
    m_lines.push_back(fmt::format("{} {} {}{}", change, count, count == 1 ? singular : plural, rest));
  }
}

void ChangeLog::note_merged(int vertices) {
  note(vertices, "merged", "vertex", "vertices", " into an earlier one at the same position");
}

void ChangeLog::note_doubled(int triangles) { note(triangles, "dropped", "doubled triangle", "doubled triangles"); }

void ChangeLog::note_unreferenced(int vertices) {
  note(vertices, "dropped", "vertex", "vertices", " that no triangle uses");
}

void ChangeLog::note_turned(const OrientationChange& turned) {
  note(turned.triangles_turned, "turned", "triangle", "triangles", " wound against the rest of the surface");
  note(turned.surfaces_turned, "turned", "surface", "surfaces", " from inwards to outwards");
}

}  // namespace musclebench

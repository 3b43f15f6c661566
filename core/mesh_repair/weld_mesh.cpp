#include "core/mesh_repair/weld_mesh.hpp"

#include "core/base/input_error.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh_repair/change_log.hpp"
#include "core/mesh_repair/doubled_triangles.hpp"
#include "core/mesh_repair/merge_vertices.hpp"
#include "core/mesh_repair/orient_surfaces.hpp"

namespace musclebench {

WeldedMesh weld_mesh(const TriangleMesh& mesh, const std::string& name) {
  WeldedMesh welded;
  welded.mesh = mesh;
  ChangeLog log(welded.changes);
  const std::vector<int> first = first_at_position(mesh.vertices);
  const int merged = merge_vertices(welded.mesh, first);
  log.note_merged(merged);
  log.note(drop_collapsed_triangles(welded.mesh), "dropped", "triangle", "triangles", " of fewer than three corners");
  MeshEdges edges(welded.mesh);
  const int doubled = drop_doubled_triangles(welded.mesh, edges);
  log.note_doubled(doubled);
  if (welded.mesh.triangles.empty()) {
    throw InputError(name, "no triangle has three corners, so there is no surface; check the mesh file");
  }
  const std::vector<int> kept = drop_unreferenced_vertices(welded.mesh);
  const auto dropped = static_cast<int>(mesh.vertices.size() - welded.mesh.vertices.size());
  if (doubled + dropped > 0) edges = MeshEdges(welded.mesh);
  log.note_unreferenced(dropped - merged);
  for (const int vertex : first) {
    welded.welded_vertex.push_back(kept[static_cast<std::size_t>(vertex)]);
  }
  log.note_turned(orient_surfaces(welded.mesh, edges));
  return welded;
}

}  // namespace musclebench

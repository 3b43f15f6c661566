#include "core/mesh_repair/repair_mesh.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh_repair/change_log.hpp"
#include "core/mesh_repair/close_holes.hpp"
#include "core/mesh_repair/doubled_triangles.hpp"
#include "core/mesh_repair/merge_vertices.hpp"
#include "core/mesh_repair/orient_surfaces.hpp"

namespace musclebench {

namespace {

/// The side of a flat triangle that the opposite corner lies on.
int longest_side(const TriangleMesh& mesh, const Triangle& triangle) {
  int longest = 0;
  double longest_squared = -1;
  for (int k = 0; k < 3; ++k) {
    const double squared = (mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]]).squaredNorm();
    if (squared > longest_squared) {
      longest = k;
      longest_squared = squared;
    }
  }
  return longest;
}

/// Dropping a triangle whose three corners lie on a line would make its long side a boundary. Instead the triangle
/// across the long side is split at its middle corner. Returns how many were merged in this way.
int take_in_flat_triangles_once(TriangleMesh& mesh) {
  const MeshEdges edges(mesh);
  const std::vector<int> edge_of_side = edge_of_sides(mesh, edges);
  std::vector<char> is_touched(mesh.triangles.size(), 0);
  int taken_in = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (is_touched[t] != 0 || !is_flat(mesh, mesh.triangles[t])) {
      continue;
    }
    const int side = longest_side(mesh, mesh.triangles[t]);
    const auto uses = edges.uses(edge_of_side[3 * t + side]);
    if (uses.size() != 2) {
      continue;
    }
    const EdgeUse& across = uses[0].corner / 3 == static_cast<int>(t) ? uses[1] : uses[0];
    Triangle& neighbour = mesh.triangles[across.corner / 3];
    const int middle = mesh.triangles[t][(side + 2) % 3];
    const int from = neighbour[across.corner % 3];
    const int to = neighbour[(across.corner + 1) % 3];
    const int apex = neighbour[(across.corner + 2) % 3];
    if (is_touched[across.corner / 3] != 0 || apex == middle) {
      continue;
    }
    neighbour = {from, middle, apex};
    mesh.triangles[t] = {middle, to, apex};
    is_touched[t] = is_touched[across.corner / 3] = 1;
    ++taken_in;
  }
  return taken_in;
}

int count_flat(const TriangleMesh& mesh) {
  return static_cast<int>(std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                                        [&](const Triangle& triangle) { return is_flat(mesh, triangle); }));
}

/// Flat triangles that share at most one side with the surface.
int drop_loose_flat_triangles(TriangleMesh& mesh) {
  const MeshEdges edges(mesh);
  const std::vector<int> edge_of_side = edge_of_sides(mesh, edges);
  std::vector<char> is_dropped(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    int loose_sides = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      loose_sides += edges.uses(edge_of_side[3 * t + k]).size() % 2 == 1 ? 1 : 0;
    }
    is_dropped[t] = static_cast<char>(loose_sides >= 2 && is_flat(mesh, mesh.triangles[t]));
  }
  return drop_marked_triangles(mesh, is_dropped);
}

struct FlatTriangles {
  int removed = 0;
  int left = 0;
};

FlatTriangles remove_flat_triangles(TriangleMesh& mesh) {
  const int before = count_flat(mesh);
  if (before == 0) {
    return {};
  }
  // A chain of flat triangles along one line shortens by at least one in a round; longer ones than this are left.
  constexpr int most_rounds = 20;
  for (int round = 0; round < most_rounds && take_in_flat_triangles_once(mesh) > 0; ++round) {
  }
  drop_loose_flat_triangles(mesh);
  const int left = count_flat(mesh);
  return {before - left, left};
}

struct Openness {
  int boundary_edges = 0;
  double hole_share = 0;  ///< area of the holes, each closed by a fan about its centre, over that of the surface
};

Openness measure_openness(const TriangleMesh& mesh, const MeshEdges& edges) {
  Openness openness;
  DisjointSets rims(static_cast<int>(mesh.vertices.size()));
  std::vector<std::pair<int, int>> boundary;
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    if (uses.size() == 1) {
      boundary.emplace_back(uses[0].low, uses[0].high);
      rims.unite(uses[0].low, uses[0].high);
    }
  }
  openness.boundary_edges = static_cast<int>(boundary.size());
  if (boundary.empty()) {
    return openness;
  }
  std::vector<Vec3> sum(mesh.vertices.size(), Vec3::Zero());
  std::vector<int> count(mesh.vertices.size(), 0);
  for (const auto& [a, b] : boundary) {
    sum[rims.find(a)] += mesh.vertices[a] + mesh.vertices[b];
    count[rims.find(a)] += 2;
  }
  double hole_area_m2 = 0;
  for (const auto& [a, b] : boundary) {
    const Vec3 centre = sum[rims.find(a)] / count[rims.find(a)];
    hole_area_m2 += (mesh.vertices[a] - centre).cross(mesh.vertices[b] - centre).norm() / 2;
  }
  const double area_m2 = surface_area_m2(mesh);
  openness.hole_share = area_m2 > 0 ? hole_area_m2 / area_m2 : 1;
  return openness;
}

void refuse_wide_open(const Openness& openness, int edges, const std::string& name) {
  // Small holes are closed; what is wide open has no inside.
  constexpr double most_open = 0.01;
  if (openness.boundary_edges >= most_open * edges && openness.boundary_edges > 0) {
    throw InputError(name,
                     fmt::format("{} of {} edges are boundary edges, so the surface has no inside; close its holes",
                                 openness.boundary_edges, edges));
  }
  if (openness.hole_share >= most_open) {
    throw InputError(name, fmt::format("its holes ({} boundary edges) are {:.2g} % of its area, so the surface has no "
                                       "certain inside; close them",
                                       openness.boundary_edges, 100 * openness.hole_share));
  }
}

struct RemainingDefects {
  int non_manifold_edges = 0;
  int inconsistent_edges = 0;
  int unbalanced_edges = 0;
};

RemainingDefects count_remaining(const MeshEdges& edges) {
  RemainingDefects defects;
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    defects.non_manifold_edges += uses.size() > 2 ? 1 : 0;
    const auto forward = std::ranges::count_if(uses, &EdgeUse::forward);
    defects.unbalanced_edges += 2 * forward != std::ssize(uses) ? 1 : 0;
    defects.inconsistent_edges += uses.size() == 2 && uses[0].forward == uses[1].forward ? 1 : 0;
  }
  return defects;
}

}  // namespace

RepairedMesh repair_mesh(const TriangleMesh& mesh, const std::string& name) {
  RepairedMesh repaired;
  repaired.mesh = mesh;
  TriangleMesh& surface = repaired.mesh;
  ChangeLog log(repaired.changes);
  const int merged = merge_vertices(surface, first_at_position(surface.vertices));
  log.note_merged(merged);
  const int collapsed = drop_collapsed_triangles(surface);
  const FlatTriangles flat = remove_flat_triangles(surface);
  log.note(collapsed + flat.removed, "dropped", "zero-area triangle", "zero-area triangles");
  const std::size_t vertices = surface.vertices.size();
  (void)drop_unreferenced_vertices(surface);
  MeshEdges edges(surface);
  const int doubled = drop_doubled_triangles(surface, edges);
  log.note_doubled(doubled);
  int flat_left = flat.left > 0 ? count_flat(surface) : 0;
  if (flat_left == static_cast<int>(surface.triangles.size())) {
    throw InputError(name, "no triangle has an area, so there is no surface; check the mesh file");
  }
  if (doubled > 0) {
    (void)drop_unreferenced_vertices(surface);
    edges = MeshEdges(surface);
  }
  log.note_unreferenced(static_cast<int>(vertices - surface.vertices.size()) - merged);
  const Openness openness = measure_openness(surface, edges);
  refuse_wide_open(openness, edges.count(), name);
  const OrientationChange turned = orient_surfaces(surface, edges);
  log.note_turned(turned);
  if (turned.triangles_turned > 0 || turned.surfaces_turned > 0) {
    edges = MeshEdges(surface);
  }
  const ClosedHoles closed = close_holes(surface, edges);
  if (closed.holes > 0) {
    edges = MeshEdges(surface);
    flat_left = count_flat(surface);  // a slit is closed by triangles without area
  }
  const int open_edges = openness.boundary_edges - closed.boundary_edges;
  const RemainingDefects left = count_remaining(edges);
  const int pinched = count_non_manifold_vertices(surface, edges);
  log.note(closed.holes, "closed", "hole", "holes", fmt::format(" ({} boundary edges)", closed.boundary_edges).c_str());
  log.note(open_edges, "left open: the surface has", "boundary edge", "boundary edges");
  log.note(left.non_manifold_edges, "left", "non-manifold edge", "non-manifold edges");
  log.note(left.inconsistent_edges, "left", "inconsistently wound edge", "inconsistently wound edges");
  log.note(pinched, "left", "non-manifold vertex", "non-manifold vertices");
  log.note(flat_left, "left", "zero-area triangle", "zero-area triangles", " that holds the surface together");
  repaired.clean = open_edges == 0 && left.non_manifold_edges == 0 && left.inconsistent_edges == 0 && pinched == 0 &&
                   flat_left == 0 && turned.surfaces == 1;
  repaired.known_closed = left.unbalanced_edges == 0;
  return repaired;
}

bool is_clean(const TriangleMesh& mesh) {
  try {
    const RepairedMesh repaired = repair_mesh(mesh, "");
    return repaired.clean && repaired.changes.empty();
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace musclebench

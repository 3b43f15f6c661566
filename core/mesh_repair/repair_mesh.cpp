#include "core/mesh_repair/repair_mesh.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh_repair/orient_surfaces.hpp"

namespace musclebench {

namespace {

/// Edge index of each side (3 * triangle + k), -1 for a side that is no edge.
std::vector<int> edge_of_sides(const TriangleMesh& mesh, const MeshEdges& edges) {
  std::vector<int> edge_of_side(3 * mesh.triangles.size(), -1);
  for (int edge = 0; edge < edges.count(); ++edge) {
    for (const EdgeUse& use : edges.uses(edge)) {
      edge_of_side[use.corner] = edge;
    }
  }
  return edge_of_side;
}

int drop_marked(TriangleMesh& mesh, const std::vector<char>& is_dropped) {
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

int merge_equal_vertices(TriangleMesh& mesh) {
  const std::vector<int> first = first_at_position(mesh.vertices);
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

int drop_triangles_of_two_vertices(TriangleMesh& mesh) {
  return static_cast<int>(std::erase_if(mesh.triangles, [](const Triangle& triangle) {
    return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
  }));
}

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

/// A triangle whose three corners lie on a line can't simply go: its long side would become a boundary. Instead its
/// middle corner is put into the triangle across the long side, which is split there. Returns how many were taken in
/// so.
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

/// Flat triangles that hang on the surface by no more than one side.
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
  return drop_marked(mesh, is_dropped);
}

/// Returns how many flat triangles went.
int remove_flat_triangles(TriangleMesh& mesh) {
  const int before = count_flat(mesh);
  if (before == 0) {
    return 0;
  }
  // A chain of flat triangles along one line shortens by at least one in a round; longer ones than this are left.
  constexpr int most_rounds = 20;
  for (int round = 0; round < most_rounds && take_in_flat_triangles_once(mesh) > 0; ++round) {
  }
  drop_loose_flat_triangles(mesh);
  return before - count_flat(mesh);
}

bool is_same_winding(const Triangle& a, const Triangle& b) {
  const auto start = std::find(b.begin(), b.end(), a[0]) - b.begin();
  return b[(start + 1) % 3] == a[1];
}

/// Triangles of the same three vertices, as lists of their indices in rising order.
std::vector<std::vector<int>> coincident_triangles(const TriangleMesh& mesh) {
  std::vector<std::pair<Triangle, int>> keyed(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    keyed[t] = {mesh.triangles[t], static_cast<int>(t)};
    std::sort(keyed[t].first.begin(), keyed[t].first.end());
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::vector<int>> groups;
  for (std::size_t i = 1; i < keyed.size(); ++i) {
    if (keyed[i].first != keyed[i - 1].first) {
      continue;
    }
    if (groups.empty() || groups.back().back() != keyed[i - 1].second) {
      groups.push_back({keyed[i - 1].second});
    }
    groups.back().push_back(keyed[i].second);
  }
  return groups;
}

/// Drops triangles that are there twice. Two coincident triangles may also be a fin, a fold of the surface without
/// thickness, which closes the surface and must stay. What tells them apart is the number of triangles at their edges:
/// in a fin it is even and 2 at its rim, a triangle too many makes it odd.
class DoubledTriangles {
 public:
  explicit DoubledTriangles(TriangleMesh& mesh)
      : m_mesh(mesh),
        m_edges(mesh),
        m_edge_of_side(edge_of_sides(mesh, m_edges)),
        m_uses(m_edges.count()),
        m_is_dropped(mesh.triangles.size(), 0),
        m_partner(mesh.triangles.size(), -1) {
    for (int edge = 0; edge < m_edges.count(); ++edge) {
      m_uses[edge] = static_cast<int>(m_edges.uses(edge).size());
    }
  }

  int drop() {
    std::vector<int> waiting;
    for (std::vector<int>& group : coincident_triangles(m_mesh)) {
      reduce_to_one_or_two(group);
      if (group.size() == 2) {
        m_partner[group[0]] = group[1];
        m_partner[group[1]] = group[0];
        waiting.push_back(group[0]);
      }
    }
    std::reverse(waiting.begin(), waiting.end());
    // A drop makes the edges of a doubled neighbour odd: the whole of a doubled patch follows from its rim.
    while (!waiting.empty()) {
      const int first = waiting.back();
      waiting.pop_back();
      if (m_partner[first] >= 0 && is_one_too_many(first)) {
        const int second = m_partner[first];
        m_partner[first] = m_partner[second] = -1;
        mark(second);
        for (int k = 0; k < 3; ++k) {
          for (const EdgeUse& use : m_edges.uses(m_edge_of_side[3 * second + k])) {
            const int other = use.corner / 3;
            if (m_partner[other] >= 0) {
              waiting.push_back(std::min(other, m_partner[other]));
            }
          }
        }
      }
    }
    return drop_marked(m_mesh, m_is_dropped);
  }

 private:
  void mark(int triangle) {
    m_is_dropped[triangle] = 1;
    for (int k = 0; k < 3; ++k) {
      --m_uses[m_edge_of_side[3 * triangle + k]];
    }
  }

  /// Two at a time, which leaves odd and even as they are.
  void reduce_to_one_or_two(std::vector<int>& group) {
    if (group.size() > 2 && group.size() % 2 == 0) {
      const auto opposite = std::find_if(group.begin() + 1, group.end(), [&](int triangle) {
        return !is_same_winding(m_mesh.triangles[group[0]], m_mesh.triangles[triangle]);
      });
      if (opposite != group.end()) {
        std::iter_swap(group.begin() + 1, opposite);
      }
    }
    const std::size_t kept = group.size() % 2 == 0 ? 2 : 1;
    std::for_each(group.begin() + static_cast<long>(kept), group.end(), [&](int triangle) { mark(triangle); });
    group.resize(kept);
  }

  [[nodiscard]] bool is_one_too_many(int first) const {
    bool any_odd = false;
    for (int k = 0; k < 3; ++k) {
      const int uses = m_uses[m_edge_of_side[3 * first + k]];
      if (uses <= 2) {
        return false;
      }
      any_odd = any_odd || uses % 2 == 1;
    }
    return any_odd || is_same_winding(m_mesh.triangles[first], m_mesh.triangles[m_partner[first]]);
  }

  TriangleMesh& m_mesh;
  MeshEdges m_edges;
  std::vector<int> m_edge_of_side;
  std::vector<int> m_uses;  ///< of each edge, the triangles that are left at it
  std::vector<char> m_is_dropped;
  std::vector<int> m_partner;  ///< the triangle that coincides with this one, -1 for none
};

int drop_unreferenced_vertices(TriangleMesh& mesh) {
  std::vector<int> place(mesh.vertices.size(), -1);
  for (const Triangle& triangle : mesh.triangles) {
    for (const int vertex : triangle) {
      place[vertex] = 0;
    }
  }
  int kept = 0;
  for (std::size_t vertex = 0; vertex < place.size(); ++vertex) {
    if (place[vertex] == 0) {
      mesh.vertices[kept] = mesh.vertices[vertex];
      place[vertex] = kept++;
    }
  }
  const int dropped = static_cast<int>(mesh.vertices.size()) - kept;
  mesh.vertices.resize(kept);
  for (Triangle& triangle : mesh.triangles) {
    for (int& vertex : triangle) {
      vertex = place[vertex];
    }
  }
  return dropped;
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
  double area_m2 = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    area_m2 += (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm() / 2;
  }
  openness.hole_share = area_m2 > 0 ? hole_area_m2 / area_m2 : 1;
  return openness;
}

void refuse_wide_open(const Openness& openness, int edges, const std::string& name) {
  // The winding number closes small holes by itself; what is wide open has no inside.
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
};

RemainingDefects count_remaining(const MeshEdges& edges) {
  RemainingDefects defects;
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    defects.non_manifold_edges += uses.size() > 2 ? 1 : 0;
    defects.inconsistent_edges += uses.size() == 2 && uses[0].forward == uses[1].forward ? 1 : 0;
  }
  return defects;
}

}  // namespace

RepairedMesh repair_mesh(const TriangleMesh& mesh, const std::string& name) {
  RepairedMesh repaired;
  repaired.mesh = mesh;
  TriangleMesh& surface = repaired.mesh;
  const auto note = [&](int count, const char* change, const char* singular, const char* plural,
                        const char* rest = "") {
    if (count > 0) {
      repaired.changes.push_back(fmt::format("{} {} {}{}", change, count, count == 1 ? singular : plural, rest));
    }
  };
  const int merged = merge_equal_vertices(surface);
  note(merged, "merged", "vertex", "vertices", " into an earlier one at the same position");
  int flat = drop_triangles_of_two_vertices(surface);
  flat += remove_flat_triangles(surface);
  note(flat, "dropped", "zero-area triangle", "zero-area triangles");
  note(DoubledTriangles(surface).drop(), "dropped", "doubled triangle", "doubled triangles");
  const int flat_left = count_flat(surface);
  if (flat_left == static_cast<int>(surface.triangles.size())) {
    throw InputError(name, "no triangle has an area, so there is no surface; check the mesh file");
  }
  note(drop_unreferenced_vertices(surface) - merged, "dropped", "vertex", "vertices", " that no triangle uses");

  const MeshEdges edges(surface);
  const Openness openness = measure_openness(surface, edges);
  refuse_wide_open(openness, edges.count(), name);
  const OrientationChange turned = orient_surfaces(surface, edges);
  note(turned.triangles_turned, "turned", "triangle", "triangles", " wound against the rest of the surface");
  note(turned.surfaces_turned, "turned", "surface", "surfaces", " from inwards to outwards");

  const MeshEdges final_edges(surface);
  const RemainingDefects left = count_remaining(final_edges);
  const int pinched = count_non_manifold_vertices(surface, final_edges);
  const int surfaces = find_winding(surface, final_edges).surfaces;
  note(openness.boundary_edges, "left open: the surface has", "boundary edge", "boundary edges");
  note(left.non_manifold_edges, "left", "non-manifold edge", "non-manifold edges");
  note(left.inconsistent_edges, "left", "inconsistently wound edge", "inconsistently wound edges");
  note(pinched, "left", "non-manifold vertex", "non-manifold vertices");
  note(flat_left, "left", "zero-area triangle", "zero-area triangles", " that holds the surface together");
  repaired.clean = openness.boundary_edges == 0 && left.non_manifold_edges == 0 && left.inconsistent_edges == 0 &&
                   pinched == 0 && flat_left == 0 && surfaces == 1;
  return repaired;
}

}  // namespace musclebench

#include "core/mesh_repair/orient_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "core/bvh/triangle_bvh.hpp"
#include "core/distance/solid_angle_sum.hpp"

namespace musclebench {

namespace {

/// Triangles that are turned together.
struct Surface {
  std::vector<int> triangles;
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
  double volume_m3 = 0;
  bool is_inward = false;
  int outermost = -1;  ///< the surface around it that lies in no other one; -1 where it is itself the outermost
};

void turn(Triangle& triangle) { std::swap(triangle[1], triangle[2]); }

/// For each winding surface the one it is judged with: surfaces that bound each other at a non-manifold edge are one.
std::vector<int> join_at_non_manifold_edges(const TriangleMesh& mesh, const MeshEdges& edges, const Winding& winding) {
  DisjointSets joined(winding.surfaces);
  std::vector<std::pair<int, int>> net;  // surface, uses forward minus backward
  for (int edge = 0; edge < edges.count(); ++edge) {
    const auto uses = edges.uses(edge);
    if (uses.size() < 3) {
      continue;
    }
    net.clear();
    for (const EdgeUse& use : uses) {
      const int surface = winding.surface[use.corner / 3];
      const Triangle& triangle = mesh.triangles[use.corner / 3];
      // The triangle may have been turned since the edges were listed, so its direction is looked up anew.
      const auto low = std::find(triangle.begin(), triangle.end(), use.low) - triangle.begin();
      const int sense = triangle[(low + 1) % 3] == use.high ? 1 : -1;
      const auto known =
          std::find_if(net.begin(), net.end(), [&](const auto& entry) { return entry.first == surface; });
      if (known == net.end()) {
        net.emplace_back(surface, sense);
      } else {
        known->second += sense;
      }
    }
    std::erase_if(net, [](const auto& entry) { return entry.second == 0; });
    for (const auto& entry : net) {
      joined.unite(net.front().first, entry.first);
    }
  }
  std::vector<int> representative(winding.surfaces);
  for (int surface = 0; surface < winding.surfaces; ++surface) {
    representative[surface] = joined.find(surface);
  }
  return representative;
}

std::vector<Surface> list_surfaces(const TriangleMesh& mesh, const Winding& winding,
                                   const std::vector<int>& representative) {
  std::vector<int> new_index(representative.size(), -1);
  std::vector<Surface> surfaces;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    int& index = new_index[representative[winding.surface[t]]];
    if (index < 0) {
      index = static_cast<int>(surfaces.size());
      Surface& added = surfaces.emplace_back();
      added.lower = added.upper = mesh.vertices[mesh.triangles[t][0]];
    }
    Surface& surface = surfaces[index];
    surface.triangles.push_back(static_cast<int>(t));
    for (const int vertex : mesh.triangles[t]) {
      surface.lower = surface.lower.cwiseMin(mesh.vertices[vertex]);
      surface.upper = surface.upper.cwiseMax(mesh.vertices[vertex]);
    }
  }
  return surfaces;
}

void measure_volume(const TriangleMesh& mesh, Surface& surface) {
  const Vec3 origin = (surface.lower + surface.upper) / 2;
  double area_m2 = 0;
  for (const int t : surface.triangles) {
    const Vec3 a = mesh.vertices[mesh.triangles[t][0]] - origin;
    const Vec3 b = mesh.vertices[mesh.triangles[t][1]] - origin;
    const Vec3 c = mesh.vertices[mesh.triangles[t][2]] - origin;
    surface.volume_m3 += a.dot(b.cross(c)) / 6;
    area_m2 += (b - a).cross(c - a).norm() / 2;
  }
  // A fin without thickness has no volume but rounding; it has no inside that could be out.
  constexpr double rounding = 1e-12;
  surface.is_inward = surface.volume_m3 < -rounding * area_m2 * std::sqrt(area_m2);
}

/// Whether `inner` lies inside `outer`, told by a few of its vertices: all of them must be, so that surfaces that
/// merely overlap (sacrum and hip bones) are not taken for nested.
class NestingTest {
 public:
  NestingTest(const TriangleMesh& mesh, const Surface& outer) : m_mesh(mesh), m_outer(outer) {}

  [[nodiscard]] bool contains(const Surface& inner) {
    const bool fits = (inner.lower.array() > m_outer.lower.array()).all() &&
                      (inner.upper.array() < m_outer.upper.array()).all() &&
                      std::abs(inner.volume_m3) < std::abs(m_outer.volume_m3);
    if (!fits) {
      return false;
    }
    constexpr std::size_t samples = 16;
    const std::size_t step = std::max<std::size_t>(1, inner.triangles.size() / samples);
    for (std::size_t i = 0; i < inner.triangles.size(); i += step) {
      if (winding_number(m_mesh.vertices[m_mesh.triangles[inner.triangles[i]][0]]) <= 0.5) {
        return false;
      }
    }
    return true;
  }

 private:
  /// The first few queries go without a tree: most surfaces are told from nested ones by one sample, which does not pay
  /// for building it.
  [[nodiscard]] double winding_number(const Vec3& point) {
    constexpr int asked_without_tree = 4;
    return ++m_asked > asked_without_tree ? tree().winding_number(point) : winding_without_tree(point);
  }

  [[nodiscard]] double winding_without_tree(const Vec3& point) const {
    SolidAngleSum angles(point);
    for (const int t : m_outer.triangles) {
      const auto& [a, b, c] = m_mesh.triangles[t];
      angles.add(m_mesh.vertices[a], m_mesh.vertices[b], m_mesh.vertices[c]);
    }
    return m_outer.is_inward ? -angles.winding_number() : angles.winding_number();
  }

  [[nodiscard]] const TriangleBvh& tree() {
    if (!m_tree) {
      TriangleMesh outward;
      outward.vertices = m_mesh.vertices;
      for (const int t : m_outer.triangles) {
        outward.triangles.push_back(m_mesh.triangles[t]);
        if (m_outer.is_inward) {
          turn(outward.triangles.back());
        }
      }
      m_tree.emplace(outward);
    }
    return *m_tree;
  }

  const TriangleMesh& m_mesh;
  const Surface& m_outer;
  std::optional<TriangleBvh> m_tree;
  int m_asked = 0;
};

/// Larger surfaces first, so that the first one found around a surface is the outermost.
void find_outermost(const TriangleMesh& mesh, std::vector<Surface>& surfaces) {
  std::stable_sort(surfaces.begin(), surfaces.end(),
                   [](const Surface& a, const Surface& b) { return std::abs(a.volume_m3) > std::abs(b.volume_m3); });
  for (std::size_t outer = 0; outer < surfaces.size(); ++outer) {
    if (surfaces[outer].outermost >= 0) {
      continue;
    }
    NestingTest test(mesh, surfaces[outer]);
    for (std::size_t inner = outer + 1; inner < surfaces.size(); ++inner) {
      if (surfaces[inner].outermost < 0 && test.contains(surfaces[inner])) {
        surfaces[inner].outermost = static_cast<int>(outer);
      }
    }
  }
}

}  // namespace

OrientationChange orient_surfaces(TriangleMesh& mesh, const MeshEdges& edges) {
  OrientationChange change;
  const Winding winding = find_winding(mesh, edges);
  change.surfaces = winding.surfaces;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (winding.flipped[t] != 0) {
      turn(mesh.triangles[t]);
      ++change.triangles_turned;
    }
  }
  std::vector<Surface> surfaces = list_surfaces(mesh, winding, join_at_non_manifold_edges(mesh, edges, winding));
  for (Surface& surface : surfaces) {
    measure_volume(mesh, surface);
  }
  find_outermost(mesh, surfaces);
  for (const Surface& surface : surfaces) {
    if (surface.outermost < 0 ? surface.is_inward : surfaces[surface.outermost].is_inward) {
      ++change.surfaces_turned;
      for (const int t : surface.triangles) {
        turn(mesh.triangles[t]);
      }
    }
  }
  return change;
}

}  // namespace musclebench

#include "core/fibres/surface_flow.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include <Eigen/Geometry>

#include "core/fibres/surface_laplace.hpp"
#include "core/mesh/mesh_edges.hpp"

namespace musclebench {

namespace {

/// Of a triangle that something flows through, over its longest side.
constexpr double least_height = 1e-5;

bool is_thin(const TriangleMesh& mesh, const Triangle& triangle) {
  double longest2_m2 = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 side = mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]];
    longest2_m2 = std::max(longest2_m2, side.squaredNorm());
  }
  const Vec3& a = mesh.vertices[triangle[0]];
  const double twice_area_m2 = (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a).norm();
  return !(twice_area_m2 > least_height * longest2_m2);
}

/// A third of the triangles about each vertex, m2.
std::vector<double> areas_of_vertices(const TriangleMesh& mesh) {
  std::vector<double> areas_m2(mesh.vertices.size(), 0.0);
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3& a = mesh.vertices[triangle[0]];
    const double third_m2 = (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a).norm() / 6;
    for (const int corner : triangle) areas_m2[corner] += third_m2;
  }
  return areas_m2;
}

/// What flows in at each vertex, 1 for all; empty where no component has both ends.
std::vector<double> inflows(const TriangleMesh& mesh, const EndNodes& ends, std::span<const int> component) {
  const std::vector<double> areas_m2 = areas_of_vertices(mesh);
  std::vector<double> origin_m2(mesh.vertices.size(), 0.0);  // by component
  std::vector<double> insertion_m2(mesh.vertices.size(), 0.0);
  for (const int node : ends.origin) origin_m2[component[node]] += areas_m2[node];
  for (const int node : ends.insertion) insertion_m2[component[node]] += areas_m2[node];
  double joined_m2 = 0;
  for (std::size_t i = 0; i < origin_m2.size(); ++i) {
    if (insertion_m2[i] > 0) joined_m2 += origin_m2[i];
  }
  if (!(joined_m2 > 0)) return {};
  std::vector<double> in(mesh.vertices.size(), 0.0);
  for (const int node : ends.origin) {
    if (insertion_m2[component[node]] > 0) in[node] += areas_m2[node] / joined_m2;
  }
  for (const int node : ends.insertion) {
    const double passes = origin_m2[component[node]] / joined_m2;
    if (passes > 0) in[node] -= passes * areas_m2[node] / insertion_m2[component[node]];
  }
  return in;
}

}  // namespace

std::array<Vec3, 3> barycentric_gradients(const TriangleMesh& mesh, const Triangle& triangle) {
  const auto at = [&](int corner) -> const Vec3& { return mesh.vertices[triangle[corner % 3]]; };
  const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0));
  const double squared = normal.squaredNorm();
  if (!(squared > 0)) return {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::array<Vec3, 3> gradients;
  for (int k = 0; k < 3; ++k) gradients[k] = normal.cross(at(k + 2) - at(k + 1)) / squared;
  return gradients;
}

std::vector<Vec3> surface_flow(const TriangleMesh& muscle, const EndNodes& ends) {
  TriangleMesh surface = muscle;  // that something can flow through
  std::erase_if(surface.triangles, [&](const Triangle& triangle) { return is_thin(muscle, triangle); });
  const std::vector<int> component = first_of_component(surface);
  std::vector<double> in = inflows(surface, ends, component);
  if (in.empty()) return {};
  // The potential is known but for a constant: it is 0 at one node of each component, and in those that join nothing.
  std::vector<double> potential(muscle.vertices.size(), 0.0);
  std::vector<char> has_flow(muscle.vertices.size(), 0);  // by component
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (in[i] != 0) has_flow[component[i]] = 1;
  }
  for (std::size_t i = 0; i < potential.size(); ++i) {
    const auto first = static_cast<std::size_t>(component[i]);
    if (has_flow[first] != 0 && first != i) potential[i] = std::numeric_limits<double>::quiet_NaN();
  }
  for (double& flow : in) flow *= 2;  // see solve_on_surface
  potential = solve_on_surface(surface, std::move(potential), in, {-2 / least_height, 2 / least_height});
  if (potential.empty()) return {};
  std::vector<Vec3> flow;
  flow.reserve(muscle.triangles.size());
  for (const Triangle& triangle : muscle.triangles) {
    if (is_thin(muscle, triangle)) {
      flow.push_back(Vec3::Zero());
      continue;
    }
    const std::array<Vec3, 3> gradients = barycentric_gradients(muscle, triangle);
    Vec3 down = Vec3::Zero();
    for (int k = 0; k < 3; ++k) down -= potential[triangle[k]] * gradients[k];
    flow.push_back(down);
  }
  return flow;
}

}  // namespace musclebench

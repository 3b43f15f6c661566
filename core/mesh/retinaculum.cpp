#include "core/mesh/retinaculum.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace musclebench {

namespace {

/// In which a tendon is looked for at rest: one that is wider than its ring is found, too.
constexpr double search_radii = 2;

/// By node of `body`, from 0: its neighbours and how far they are.
std::vector<std::vector<std::pair<int, double>>> neighbours_of(const TriangleMesh& mesh, const Body& body) {
  std::vector<std::vector<std::pair<int, double>>> neighbours(
      static_cast<std::size_t>(body.last_node - body.first_node));
  for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = mesh.triangles[t][k];
      const int to = mesh.triangles[t][(k + 1) % 3];
      const double length_m =
          (mesh.vertices[static_cast<std::size_t>(to)] - mesh.vertices[static_cast<std::size_t>(from)]).norm();
      neighbours[static_cast<std::size_t>(from - body.first_node)].emplace_back(to - body.first_node, length_m);
      neighbours[static_cast<std::size_t>(to - body.first_node)].emplace_back(from - body.first_node, length_m);
    }
  }
  return neighbours;
}

}  // namespace

PlaceInRing place_in_ring(const Retinaculum& ring, const Vec3& point_m) {
  const Vec3 from_centre_m = point_m - ring.centre_m;
  const double along_m = ring.axis.dot(from_centre_m);
  const Vec3 outwards_m = from_centre_m - along_m * ring.axis;
  const double distance_m = outwards_m.norm();
  return {along_m, distance_m, distance_m > 0 ? Vec3(outwards_m / distance_m) : Vec3::Zero()};
}

std::optional<PlaceInRing> crossing_of(const Retinaculum& ring, const Vec3& from, const Vec3& to) {
  const double from_m = ring.axis.dot(from - ring.centre_m);
  const double to_m = ring.axis.dot(to - ring.centre_m);
  if ((from_m < 0) == (to_m < 0)) return std::nullopt;
  return place_in_ring(ring, from + from_m / (from_m - to_m) * (to - from));
}

std::vector<int> nodes_through_ring(const TriangleMesh& mesh, const Body& body, const Retinaculum& ring,
                                    double slide_m) {
  const auto neighbours = neighbours_of(mesh, body);
  std::vector<double> slides_m(neighbours.size(), std::numeric_limits<double>::infinity());
  std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>> open;
  const auto reach = [&](double at_m, int node) {
    if (!(at_m < slides_m[static_cast<std::size_t>(node)])) return;
    slides_m[static_cast<std::size_t>(node)] = at_m;
    open.emplace(at_m, node);
  };
  for (int node = 0; node < std::ssize(slides_m); ++node) {
    for (const auto& [next, length_m] : neighbours[static_cast<std::size_t>(node)]) {
      const Vec3& from = mesh.vertices[static_cast<std::size_t>(node + body.first_node)];
      const auto crossing = crossing_of(ring, from, mesh.vertices[static_cast<std::size_t>(next + body.first_node)]);
      if (crossing && crossing->outwards_m <= search_radii * ring.radius_m) reach(0, node);
    }
  }
  while (!open.empty()) {
    const auto [at_m, node] = open.top();
    open.pop();
    if (at_m > slides_m[static_cast<std::size_t>(node)]) continue;
    for (const auto& [next, length_m] : neighbours[static_cast<std::size_t>(node)]) {
      if (at_m + length_m <= slide_m) reach(at_m + length_m, next);
    }
  }
  std::vector<int> nodes;
  for (int node = 0; node < std::ssize(slides_m); ++node) {
    if (std::isfinite(slides_m[static_cast<std::size_t>(node)])) nodes.push_back(node + body.first_node);
  }
  return nodes;
}

}  // namespace musclebench

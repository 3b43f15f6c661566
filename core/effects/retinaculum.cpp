#include "core/effects/retinaculum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace musclebench {

namespace {

/// In which a tendon is looked for at rest: one that is wider than its ring is found, too.
constexpr double search_radii = 2;

double opening_m(const Retinaculum& ring, double along_m) {
  return ring.radius_m + along_m * along_m / (2 * ring.half_width_m);
}

class Rings final : public Effect {
 public:
  explicit Rings(const EffectInput& input) : m_rings(input.retinacula.begin(), input.retinacula.end()) {
    for (std::size_t ring = 0; ring < m_rings.size(); ++ring) {
      for (const int node : m_rings[ring].nodes) {
        m_held.push_back({static_cast<std::size_t>(input.order.row_of(node)), ring});
      }
    }
    std::ranges::sort(m_held, {}, [](const Held& held) { return std::pair(held.row, held.ring); });
  }

  [[nodiscard]] std::string_view name() const override { return "retinaculum"; }

  void project(NodeRows& rows, const SubstepInput& input, const Team& team) override {
    const auto [first, last] =
        team.share_by_row(m_held.size(), rows.size(), [&](std::size_t i) { return m_held[i].row; });
    for (std::size_t i = first; i < last; ++i) {
      const auto& [row, index] = m_held[i];
      if (!(rows[row].inverse_mass > 0)) continue;
      const Retinaculum& ring = m_rings[index];
      const RigidMotion& pose = input.bone_poses[static_cast<std::size_t>(ring.bone)];
      const PlaceInRing place = place_in_ring(ring, pose.apply_inverse(rows[row].position()));
      if (!(std::abs(place.along_m) < ring.half_width_m)) continue;
      const double outside_m = place.outwards_m - opening_m(ring, place.along_m);
      if (!(outside_m > 0)) continue;
      // C = outwards - opening; |gradient C|^2 = 1 + slope^2.
      const double slope = place.along_m / ring.half_width_m;
      const Vec3 gradient = place.outwards - slope * ring.axis;
      const Vec3 correction = pose.apply_to_direction(-outside_m / (1 + slope * slope) * gradient);
      rows[row].set_position(rows[row].position() + correction);
      if (NodeRow* impulses = rows.impulses()) {
        impulses[row].set_position(impulses[row].position() + correction / rows[row].inverse_mass);
      }
    }
  }

 private:
  struct Held {
    std::size_t row;
    std::size_t ring;
  };

  std::vector<Retinaculum> m_rings;
  std::vector<Held> m_held;
};

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

std::unique_ptr<Effect> make_retinaculum(const EffectInput& input, const Parameters& /*parameters*/) {
  return std::make_unique<Rings>(input);
}

std::vector<ParameterSpec> retinaculum_parameters() { return {}; }

}  // namespace musclebench

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

/// Of each node, m2: a third of the triangles about it.
std::vector<double> areas_of_nodes(const TriangleMesh& mesh) {
  std::vector<double> areas_m2(mesh.vertices.size(), 0.0);
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto at = [&](int node) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(node)]; };
    const double third_m2 = (at(b) - at(a)).cross(at(c) - at(a)).norm() / 6;
    for (const int node : {a, b, c}) areas_m2[static_cast<std::size_t>(node)] += third_m2;
  }
  return areas_m2;
}

class Rings final : public Effect {
 public:
  explicit Rings(const EffectInput& input) {
    const std::vector<double> areas_m2 = areas_of_nodes(input.mesh);
    for (const Retinaculum& ring : input.retinacula) {
      Held& held = m_rings.emplace_back(Held{ring, {}, {}});
      for (const int node : ring.nodes) {
        held.nodes.push_back(
            {static_cast<std::size_t>(input.order.row_of(node)), areas_m2[static_cast<std::size_t>(node)]});
      }
      std::ranges::sort(held.nodes, {}, &Node::row);
      held.inside.reserve(held.nodes.size());
    }
    std::ranges::stable_sort(m_rings, {}, [](const Held& held) { return held.ring.muscle; });
  }

  [[nodiscard]] std::string_view name() const override { return "retinaculum"; }

  /// Rings of one muscle may share nodes, and so a thread.
  void project(NodeRows& rows, const SubstepInput& input, const Team& team) override {
    const auto [first, last] = team.share(m_rings.empty() ? 0 : m_rings.back().ring.muscle + 1);
    for (Held& held : m_rings) {
      if (held.ring.muscle < first || held.ring.muscle >= last) continue;
      hold(held, input.bone_poses[static_cast<std::size_t>(held.ring.bone)], rows);
    }
  }

 private:
  struct Node {
    std::size_t row;
    double area_m2;
  };
  struct Inside {
    std::size_t row;
    double weight;
  };
  struct Held {
    Retinaculum ring;
    std::vector<Node> nodes;     ///< by row
    std::vector<Inside> inside;  ///< scratch memory
  };

  static void hold(Held& held, const RigidMotion& pose, NodeRows& rows) {
    const Retinaculum& ring = held.ring;
    held.inside.clear();
    double sum = 0;
    double sum_of_squares = 0;
    Vec3 middle_m = Vec3::Zero();
    for (const Node& node : held.nodes) {
      const NodeRow& row = rows[node.row];
      const PlaceInRing place = place_in_ring(ring, pose.apply_inverse(row.position()));
      const double weight = node.area_m2 * (1 - std::abs(place.along_m) / ring.half_width_m);
      if (!(weight > 0)) continue;
      sum += weight;
      middle_m += weight * place.outwards_m * place.outwards;
      if (!(row.inverse_mass > 0)) continue;  // its bone holds it, and it has a part in the middle all the same
      held.inside.push_back({node.row, weight});
      sum_of_squares += weight * weight;
    }
    if (!(sum_of_squares > 0)) return;
    middle_m /= sum;
    const double off_m = middle_m.norm();
    if (!(off_m > ring.clearance_m)) return;
    // C = |sum w p / W| - clearance: a node moves by C (w / W) / sum (w / W)^2.
    const Vec3 push_m = pose.apply_to_direction((ring.clearance_m - off_m) / off_m * sum / sum_of_squares * middle_m);
    for (const auto& [index, weight] : held.inside) {
      NodeRow& row = rows[index];
      const Vec3 correction_m = weight * push_m;
      row.set_position(row.position() + correction_m);
      if (NodeRow* impulses = rows.impulses()) {
        impulses[index].set_position(impulses[index].position() + correction_m / row.inverse_mass);
      }
    }
  }

  std::vector<Held> m_rings;  ///< by muscle
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

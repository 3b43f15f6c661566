#include "core/mesh/retinaculum.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

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

std::unique_ptr<Effect> make_retinaculum(const EffectInput& input, const Parameters& /*parameters*/) {
  return std::make_unique<Rings>(input);
}

std::vector<ParameterSpec> retinaculum_parameters() { return {}; }

}  // namespace

/// The middle of a tendon stays within the clearance of the axis of its ring. The middle is the mean of the nodes that
/// are nearer than w = half_width_m to the ring's plane, each by its area at rest and by 1 - |z| / w. A correction
/// moves nodes by the same weight, so that it does not flatten the tendon. A hard one-sided constraint without
/// friction; the bone bears the push.
EffectEntry retinaculum_entry() {
  return {.name = "retinaculum",
          .help = "rings that bones carry hold tendons, which slide through them",
          .parameters = retinaculum_parameters(),
          .make = make_retinaculum,
          .colour = "#56B4E9"};
}

}  // namespace musclebench

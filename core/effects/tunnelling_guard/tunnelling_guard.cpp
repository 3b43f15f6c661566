#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "core/base/portable_math.hpp"
#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/stage_surface.hpp"
#include "core/contact/contact_impulses.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

/// A node farther from the surface than this, relative to its coordinates, is not on it by rounding.
constexpr double off_surface = 1e-12;

/// Straight path of a node in a step, in a bone's rest frame, m.
struct PathSegment {
  Vec3 from;
  Vec3 to;
};

/// Keeps nodes from passing through one bone.
class BoneGuard {
 public:
  /// Nodes are put back to `margin_m` from the surface.
  BoneGuard(const Bone& bone, bool untouched, std::size_t nodes, double margin_m)
      : m_surface(exact_stage_surface(bone, untouched)), m_states(nodes), m_margin_m(margin_m) {}

  /// Radius of a sphere about the end of the path without any of the surface, where the distance to the bone's box is
  /// enough to tell that the path does not meet it; else 0.
  [[nodiscard]] double clearance_by_box_m(const PathSegment& path) const {
    const double distance_m = m_surface.box_distance_m(path.to);
    return distance_m > (path.to - path.from).norm() ? distance_m : 0;
  }

  /// The position that rule `crossing` puts the node back to, rest frame; none where it may stay. `clearance_m` becomes
  /// the radius of a sphere about the end of the path that has no surface in it; 0: unknown.
  std::optional<Vec3> hold_by_crossing(int node, const PathSegment& path, double& clearance_m) {
    NodeState& state = m_states[static_cast<std::size_t>(node)];
    if (!state.is_seen || state.is_inside) {  // something else may have moved it since
      state.is_seen = true;
      const Side side = locate(path.from, state.triangle);
      state.is_inside = state.is_inside && side.is_inside;
      if (!state.is_inside) state.follow(side);
    }
    // Rounding can't have put it on the other side, so that no crossing means no change.
    const bool is_off_surface = !state.is_inside && state.clearance_m > off_surface * path.from.lpNorm<1>();
    Clearance clearance;
    if (is_off_surface) {
      clearance = m_surface.get().tree().clearance_from(path.to, state.triangle);
      if (clearance.distance_m > (path.to - path.from).norm()) {
        clearance_m = state.stay_outside(clearance);
        return std::nullopt;
      }
    }
    m_surface.get().tree().find_crossings(path.from, path.to, m_crossings);
    if (is_off_surface && m_crossings.empty() && clearance.distance_m > 0) {
      clearance_m = state.stay_outside(clearance);
      return std::nullopt;
    }
    if (!state.is_inside && !m_crossings.empty() && !m_crossings.front().entering) {
      state.enter(locate(path.from, state.triangle));  // it begins on the surface
    }
    int layers = state.is_inside ? 1 : 0;  // where components of the surface overlap, the outermost counts
    for (const PathCrossing& crossing : m_crossings) {
      const Vec3 normal = m_surface.get().tree().area_normal(crossing.triangle);
      if (crossing.entering) {
        if (layers++ == 0) state.enter(path.from + crossing.share * (path.to - path.from), normal);
      } else if (layers > 0 && --layers == 0) {
        state.is_inside = false;
        if (state.normal.dot(normal) < 0) return state.put_back(m_margin_m);
      }
    }
    const Side side = locate(path.to, state.triangle);
    if (!state.is_inside && (side.is_inside || goes_inside_unseen(path, state, side))) {
      state.enter(locate(path.from, state.triangle));
    }
    if (state.is_inside && state.normal.dot(side.normal) < 0) {
      return state.put_back(m_margin_m);
    }
    state.follow(side);
    if (!side.is_inside) clearance_m = side.distance_m;
    return std::nullopt;
  }

  /// The same by rule `angle`.
  std::optional<Vec3> hold_by_angle(int node, const PathSegment& path, double least_cosine, double& clearance_m) {
    NodeState& state = m_states[static_cast<std::size_t>(node)];
    const Side from = locate(path.from, state.triangle);
    const Side to = locate(path.to, from.triangle);
    state.triangle = to.triangle;
    if (from.normal.dot(to.normal) < least_cosine) {
      m_surface.get().tree().find_crossings(path.from, path.to, m_crossings);
      if (!m_crossings.empty()) {
        return path.from + m_crossings.front().share * (path.to - path.from) + m_margin_m * from.normal;
      }
    }
    if (!to.is_inside) clearance_m = to.distance_m;
    return std::nullopt;
  }

 private:
  struct Side {
    Vec3 point;   ///< the closest of the surface
    Vec3 normal;  ///< unit gradient of the signed distance
    double distance_m;
    int triangle;
    bool is_inside;
  };

  struct NodeState {
    Vec3 point = Vec3::Zero();   ///< inside: point of the surface on the side where the node entered
    Vec3 normal = Vec3::Zero();  ///< outward normal there
    double clearance_m = 0;      ///< outside: lower bound of the distance to the surface
    int triangle = 0;            ///< near the node
    bool is_inside = false;
    bool is_seen = false;

    void enter(const Vec3& at, const Vec3& outward) {
      is_inside = true;
      point = at;
      normal = outward;
    }
    void enter(const Side& side) { enter(side.point, side.normal); }
    void follow(const Side& side) {
      enter(side);
      is_inside = side.is_inside;
      clearance_m = is_inside ? 0 : side.distance_m;
      triangle = side.triangle;
    }
    /// No crossing: only the clearance changes.
    double stay_outside(const Clearance& clearance) {
      triangle = clearance.triangle;
      return clearance_m = clearance.distance_m;
    }
    /// Returns to the surface where the node entered.
    Vec3 put_back(double margin_m) {
      is_inside = false;
      clearance_m = 0;
      return point + margin_m * normal.stableNormalized();
    }
  };

  /// From one side of the bone onto another, and no crossing was found because both ends lie on the surface.
  [[nodiscard]] bool goes_inside_unseen(const PathSegment& path, const NodeState& state, const Side& end) {
    return m_crossings.empty() && state.normal.dot(end.normal) < 0 &&
           locate(0.5 * (path.from + path.to), state.triangle).is_inside;
  }

  /// `triangle`: one that may be near.
  [[nodiscard]] Side locate(const Vec3& point, int triangle) {
    const SignedPoint located = m_surface.get().locate_from(point, triangle);
    const ClosestPoint& closest = located.closest;
    return {closest.point, m_surface.get().outward(point, located), closest.distance_m, closest.triangle,
            located.inside};
  }

  ExactStageSurface m_surface;
  std::vector<NodeState> m_states;
  double m_margin_m;
  std::vector<PathCrossing> m_crossings;  // scratch memory
};

class TunnellingGuard final : public ContactStage {
 public:
  /// Without `least_cosine` by rule `crossing`.
  TunnellingGuard(const StageInput& input, std::optional<double> least_cosine) : m_least_cosine(least_cosine) {
    m_clearances.reset(input.bones, input.nodes);
    for (std::size_t bone = 0; bone < input.bones.size(); ++bone) {
      m_bones.emplace_back(input.bones[bone], input.is_untouched(bone), input.nodes, input.contacts.margin_m);
    }
    m_held.reserve(input.nodes);
    m_again.reserve(input.nodes);
  }

  [[nodiscard]] std::string_view name() const override { return "tunnelling_guard"; }

  std::span<const int> after_bones(const ContactStageInput& input) override {
    m_held.clear();
    std::span<const int> nodes = input.free_nodes;
    // A node that one bone has put back may thereby pass through another.
    for (std::size_t pass = 0; pass < m_bones.size() && !nodes.empty(); ++pass) {
      const auto first_held = static_cast<std::ptrdiff_t>(m_held.size());
      m_clearances.collect_expired(input.bone_poses, input.predicted, nodes);
      for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
        for (const int node : m_clearances.expired(static_cast<int>(bone))) guard(bone, node, input);
      }
      m_again.assign(m_held.begin() + first_held, m_held.end());
      std::ranges::sort(m_again);
      m_again.erase(std::unique(m_again.begin(), m_again.end()), m_again.end());
      nodes = m_again;
    }
    return m_held;
  }

  [[nodiscard]] int contact_count() const override { return static_cast<int>(m_held.size()); }

 private:
  void guard(std::size_t bone, int node, const ContactStageInput& input) {
    Vec3& predicted = input.predicted[static_cast<std::size_t>(node)];
    const RigidMotion& pose = input.bone_poses[bone];
    const PathSegment path{input.previous_bone_poses[bone].apply_inverse(input.start[static_cast<std::size_t>(node)]),
                           pose.apply_inverse(predicted)};
    if (!path.from.allFinite() || !path.to.allFinite()) {
      return;  // the run ends as diverged after this frame
    }
    double clearance_m = m_bones[bone].clearance_by_box_m(path);
    if (clearance_m > 0) {
      m_clearances.store(static_cast<int>(bone), node, path.to, clearance_m);
      return;
    }
    const std::optional<Vec3> held = m_least_cosine
                                         ? m_bones[bone].hold_by_angle(node, path, *m_least_cosine, clearance_m)
                                         : m_bones[bone].hold_by_crossing(node, path, clearance_m);
    if (held) {
      const Vec3 back = pose.apply(*held);
      if (input.impulses != nullptr) {
        const Vec3 moved_kg_m = (back - predicted) / input.impulses->inverse_mass(node);
        input.impulses->add(node, bone, moved_kg_m, moved_kg_m);
      }
      predicted = back;
      m_held.push_back(node);
    } else if (clearance_m > 0) {
      m_clearances.store(static_cast<int>(bone), node, path.to, clearance_m);
    }
  }

  std::optional<double> m_least_cosine;
  ClearanceCache m_clearances;
  std::vector<BoneGuard> m_bones;
  std::vector<int> m_held;
  std::vector<int> m_again;
};

std::unique_ptr<ContactStage> make_tunnelling_guard(const StageInput& input, const Parameters& parameters) {
  std::optional<double> least_cosine;
  if (parameters.word("rule") == "angle") {
    least_cosine = portable::cos(parameters.number("angle_deg") * std::numbers::pi / 180);
  }
  return std::make_unique<TunnellingGuard>(input, least_cosine);
}

std::vector<ParameterSpec> tunnelling_guard_parameters() {
  return {
      parameter::choice({.name = "rule",
                         .choices = {"crossing", "angle"},
                         .help = "crossing: by the node's path through the surface; angle: by the directions to the "
                                 "surface at start and end of a step (the paper's proposal)"}),
      parameter::number({.name = "angle_deg",
                         .unit = "deg",
                         .default_value = 135,
                         .minimum = 0,
                         .maximum = 175,
                         .help = "directions that differ by more mean another side (rule `angle`)"})};
}

}  // namespace

/// Keeps nodes from passing through a bone: a node that would end a step on its far side is put back to where it
/// entered. Works after the response, whatever backend and response there are, on the exact surface. A node is tested
/// only where its path may have met the surface (ClearanceCache).
///
/// Rule `crossing` follows each node's path in the bone's moving frame, from step to step (continuous collision
/// detection of a point and a moving triangle: Provot 1997, "Collision and self-collision handling in cloth model
/// dedicated to design garments"; here against a rigid surface, so that a path is a line). A path that enters the
/// surface and leaves it where the surface has an opposed normal (outward normals n_in . n_out < 0) is cut where it
/// entered. While a node is inside, the point of the surface closest to it is tracked from where it entered; the node
/// may neither leave through nor come closer to a surface with an opposed normal. Rule `angle` is the paper's (section
/// VI-A): where the directions to the surface at the start and at the end of a step differ by more than `angle_deg`,
/// the node is put to where its path meets the surface.
///
/// The Referee's count of tunnelled nodes takes a path as straight from frame to frame (TunnellingTracker): it may
/// count a node that went around an edge in several substeps, which is no fault here. Through a hole of an open surface
/// nodes pass unseen: there is nothing to cross.
EffectEntry tunnelling_guard_entry() {
  return {.name = "tunnelling_guard",
          .help = "no node ends a step on the far side of a bone",
          .parameters = tunnelling_guard_parameters(),
          .make_stage = make_tunnelling_guard,
          .remedies = {{Requirement::bone_passage}, {Requirement::bone_depth}},
          .colour = "#8C2D04"};
}

}  // namespace musclebench

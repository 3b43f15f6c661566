#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/contact/contact_rows.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/effects/no_passage/left_out.hpp"
#include "core/effects/no_passage/passage_overlaps.hpp"
#include "core/effects/no_passage/passage_paths.hpp"
#include "core/effects/no_passage/passage_zones.hpp"
#include "core/effects/no_passage/triangle_axes.hpp"

namespace musclebench {

namespace {

/// Features end a substep no closer than this share of what they had, or of the gap where that is less.
constexpr double least_share = 0.2;
/// Sine of the angle by which surfaces that touch have to face each other: less than half of a needle's.
constexpr double least_facing = 0.01;
/// Sine of the least angle between edges that touch.
constexpr double least_angle = 1e-3;
/// Of an edge: what is closer to its end is at its end.
constexpr double on_border = 1e-3;
/// Corrections of all rows in a round.
constexpr int row_steps = 10;

using Corners = PassagePaths::Corners;

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

/// Two features that come too close on their paths.
struct Hit {
  PassageStencil stencil;
  std::array<double, 4> weights = {};  ///< of StencilGap, just before they touch
  Vec3 normal = Vec3::Zero();          ///< unit, from the second side to the first, in the frame of the paths; or 0
  StencilCorners at = {};              ///< the corners then
  double target_m = 0;                 ///< that they are to keep
};

Vec3 area_normal(const Corners& corners) { return (corners[1] - corners[0]).cross(corners[2] - corners[0]); }

class NoPassage final : public ContactStage {
 public:
  NoPassage(const StageInput& input, double gap_m, int rounds, bool with_itself)
      : m_paths(*input.mesh, input.bodies, input.bones, input.bound_nodes, with_itself, input.threads),
        m_bones(input.bones),
        m_bodies(input.bodies.begin(), input.bodies.end()),
        m_left_out(m_paths, input.bones, m_bodies, touching_share * gap_m),
        m_gap_m(gap_m),
        m_rounds(rounds),
        m_inverse_masses(input.inverse_masses.begin(), input.inverse_masses.end()),
        m_solver(m_inverse_masses, input.contacts.friction_coefficient),
        m_is_moved(input.nodes, 1),
        m_zones(m_paths) {}

  [[nodiscard]] std::string_view name() const override { return "no_passage"; }

  std::span<const int> before_bones(const ContactStageInput& input) override {
    if (m_safe.empty()) {
      m_safe.assign(input.start.begin(), input.start.end());
      m_left_out.begin(m_safe, input.previous_bone_poses);
    }
    return {};
  }

  std::span<const int> end_substep(const ContactStageInput& input) override {
    m_changed.clear();
    m_hit_count = 0;
    // A run that has diverged is told by others.
    if (!std::ranges::all_of(input.predicted, [](const Vec3& node) { return node.allFinite(); })) return m_changed;
    m_proposed.assign(input.predicted.begin(), input.predicted.end());
    m_paths.set(m_safe, m_proposed, input.previous_bone_poses, input.bone_poses);
    std::ranges::fill(m_is_moved, 1);
    m_rows.clear();
    m_row_of.clear();
    // All paths are new here, so that this meets all that goes through where they start.
    find_near();
    if (m_left_out.is_any()) m_left_out.update(through(), m_safe, input.previous_bone_poses);
    join_hits();
    for (int round = 0; !m_hits.empty() && round < m_rounds; ++round) {
      m_hit_count = std::max(m_hit_count, static_cast<int>(m_hits.size()));
      for (const Hit& hit : m_hits) add_row(hit, input);
      m_solver.solve(m_rows, input.start, m_proposed, input.impulses);
      std::ranges::fill(m_is_moved, 0);
      for (const int node : m_solver.moved_nodes()) m_is_moved[at_index(node)] = 1;
      for (const Hit& hit : m_hits) look_again_at(hit.stencil);
      change_moved();
      find_hits();
    }
    if (!m_hits.empty()) move_in_zones(input);
    m_paths.move_on();
    if (m_hit_count > 0) {
      for (std::size_t node = 0; node < m_proposed.size(); ++node) {
        if (m_proposed[node] == input.predicted[node]) continue;
        input.predicted[node] = m_proposed[node];
        m_changed.push_back(static_cast<int>(node));
      }
    }
    m_safe.swap(m_proposed);
    return m_changed;
  }

  /// Pairs of features that came too close in the round that had most.
  [[nodiscard]] int contact_count() const override { return m_hit_count; }
  [[nodiscard]] std::string gave_up() const override { return m_gave_up; }

 private:
  [[nodiscard]] const Triangle& triangle(std::size_t t) const { return m_paths.mesh().triangles[t]; }

  /// What a thread finds.
  struct Found {
    std::vector<Hit> hits;
    std::vector<TrianglePair> undecided;  ///< pairs that may go through each other, and are not followed yet
  };

  /// Features that come too close on their paths to `m_proposed`, of triangles with a node that moved.
  void find_hits() {
    find_near();
    join_hits();
  }

  void find_near() {
    for (auto& [hits, undecided] : m_found) {
      hits.clear();
      undecided.clear();
    }
    m_paths.for_each_near(watched_m(), m_found,
                          [&](Found& found, int bone, std::size_t t, std::size_t other, double enough_m) {
                            return follow_pair({bone, t, other}, enough_m, found);
                          });
  }

  /// Of all threads; follows what was undecided.
  void join_hits() {
    m_hits.clear();
    for (const auto& [hits, undecided] : m_found) {
      m_hits.insert(m_hits.end(), hits.begin(), hits.end());
      for (const TrianglePair& pair : undecided) follow_stencils(pair, m_hits);
    }
    // The order in which pairs are found is that of single-precision bounds, which is the processor's.
    std::ranges::sort(m_hits, {}, &Hit::stencil);
  }

  void change_moved() {
    m_moved.clear();
    for (std::size_t node = 0; node < m_is_moved.size(); ++node) {
      if (m_is_moved[node] != 0) m_moved.push_back(static_cast<int>(node));
    }
    m_paths.change(m_moved);
  }

  [[nodiscard]] bool is_moved(std::size_t t) const {
    return std::ranges::any_of(triangle(t), [&](int node) { return m_is_moved[at_index(node)] != 0; });
  }

  /// Follows what a pair of triangles owns. How far apart that is at least where the paths start; 0 where it was not
  /// looked at, or may go through.
  double follow_pair(const TrianglePair& pair, double enough_m, Found& found) const {
    const auto& [bone, t, other] = pair;
    if (!is_moved(t) && (bone >= 0 || !is_moved(other))) return 0;
    if (bone >= 0 || !share_a_vertex(triangle(t), triangle(other))) {
      const ApartAlongAxes apart =
          apart_along_axes(m_paths.path_of(bone, t), m_paths.path_of_other(bone, other), watched_m());
      if (apart.stay_apart || apart.start_m > enough_m) return apart.start_m;
    }
    if (m_left_out.concerns(pair)) {
      // What goes through each other has features that are apart, too: its distance has to be asked for again. Whether
      // it is still left out has to be found out before it is followed.
      found.undecided.push_back(pair);
      return 0;
    }
    double left_m = nowhere_m;
    m_paths.for_each_stencil_of(bone, t, other, [&](const PassageStencil& stencil) {
      left_m = std::min(left_m, distance_of(stencil.kind, m_paths.starts_of(stencil)));
    });
    if (left_m <= enough_m) follow_stencils(pair, found.hits);
    return left_m;
  }

  void follow_stencils(const TrianglePair& pair, std::vector<Hit>& hits) const {
    m_paths.for_each_stencil_of(pair.bone, pair.triangle, pair.other, [&](const PassageStencil& stencil) {
      if (m_left_out.has(stencil)) return;
      const StencilCorners start = m_paths.starts_of(stencil);
      follow(stencil, start, gap_of(stencil.kind, start), hits);
    });
  }

  /// Of the pairs that are not followed, those that go through each other where the paths start.
  [[nodiscard]] std::vector<TrianglePair> through() const {
    std::vector<TrianglePair> pairs;
    for (const Found& part : m_found) {
      std::ranges::copy_if(part.undecided, std::back_inserter(pairs), [&](const TrianglePair& pair) {
        return go_through_each_other(m_paths, pair, touching_m());
      });
    }
    return pairs;
  }

  void follow(const PassageStencil& stencil, const StencilCorners& start, const StencilGap& before,
              std::vector<Hit>& hits) const {
    const double distance_m = before.distance_m;
    const StencilCorners end = m_paths.ends_of(stencil);
    Hit hit{stencil, before.weights, Vec3::Zero(), start, m_gap_m};
    if (stencil.bone < 0 && m_paths.body_of_node(stencil.corners[0]) == m_paths.body_of_node(stencil.corners[3])) {
      // Neighbours in the mesh may be closer by nature.
      StencilCorners rest;
      for (std::size_t k = 0; k < 4; ++k) rest[k] = m_paths.mesh().vertices[at_index(stencil.corners[k])];
      const double rest_m = distance_of(stencil.kind, rest);
      hit.target_m = std::min(m_gap_m, std::max(distance_m, 0.5 * rest_m));
    }
    if (distance_m < touching_m()) {
      if (!comes_in(hit, end)) return;
    } else {
      // What is apart never gets so close that its side is in doubt.
      const double least_m = std::max(least_share * std::min(m_gap_m, distance_m), 2 * touching_m());
      const double share = safe_share(stencil.kind, start, end, least_m);
      if (!(share < 1)) return;
      for (std::size_t k = 0; k < 4; ++k) hit.at[k] = start[k] + share * (end[k] - start[k]);
      const StencilGap gap = gap_of(stencil.kind, hit.at);
      hit.weights = gap.weights;
      hit.normal = gap.apart.stableNormalized();
    }
    hits.push_back(hit);
  }

  /// Whether features that touch at `hit.at` end in each other, where surfaces at them face each other; and the normal
  /// that they have then.
  [[nodiscard]] bool comes_in(Hit& hit, const StencilCorners& end) const {
    const PassageStencil& stencil = hit.stencil;
    const StencilCorners& start = hit.at;
    const bool is_node = stencil.kind == StencilKind::node_face;
    std::array<Vec3, 2> candidates;
    if (is_node) {
      candidates[0] = area_normal({start[1], start[2], start[3]}).stableNormalized();
      // On a ridge both faces are steep, and their edge looks to the node.
      candidates[1] = Vec3::Zero();
      for (std::size_t k = 1; k < 4; ++k) candidates[1] -= hit.weights[k] * m_paths.normal_of(stencil, k);
      candidates[1] = candidates[1].stableNormalized();
    } else {
      // Where an edge touches with an end, its node does.
      if (std::ranges::any_of(hit.weights, [](double w) { return std::abs(w) < on_border; })) return false;
      const Vec3 first = (start[1] - start[0]).stableNormalized();
      Vec3 across = first.cross((start[3] - start[2]).stableNormalized());
      if (across.norm() < least_angle) return false;
      across = across.stableNormalized();
      const Vec3 away = m_paths.normal_of(stencil, 2) + m_paths.normal_of(stencil, 3) - m_paths.normal_of(stencil, 0) -
                        m_paths.normal_of(stencil, 1);
      if (across.dot(away) < 0) across = -across;
      candidates = {across, -across};
    }
    double facing = least_facing;
    for (const Vec3& normal : candidates) {
      // A corner's mean normal says little: at the rim of a plate the large faces outweigh what meets a wall.
      const double both =
          std::min(m_paths.most_facing(stencil, true, -normal), m_paths.most_facing(stencil, false, normal));
      if (!(both > facing)) continue;
      hit.normal = normal;
      if (is_node) break;
      facing = both;
    }
    if (hit.normal.isZero()) return false;
    Vec3 apart = Vec3::Zero();
    for (std::size_t k = 0; k < 4; ++k) apart += hit.weights[k] * end[k];
    return hit.normal.dot(apart) < least_share * hit.target_m - touching_share * touching_m();
  }

  /// Bounds in single precision leave out only what the search on exact paths would leave out, too, so that the result
  /// does not depend on their rounding.
  [[nodiscard]] double watched_m() const { return (1 + 5 * enough_share) * least_share * m_gap_m; }
  [[nodiscard]] double touching_m() const { return touching_share * m_gap_m; }

  void add_row(const Hit& hit, const ContactStageInput& input) {
    if (hit.normal.isZero()) return;
    const Vec3& normal = hit.normal;
    ContactRow row{.normal = normal,
                   .offset_m = hit.target_m,
                   .start_normal = normal,
                   .start_offset_m = hit.target_m,
                   .steps = row_steps,
                   .bone = hit.stencil.bone};
    const PassageStencil& stencil = hit.stencil;
    Vec3 on_bone = Vec3::Zero();  // minus the bone's point, or the point itself, by the side that it is on
    for (std::size_t k = 0; k < 4; ++k) {
      if (stencil.is_of_bone(k)) {
        on_bone += hit.weights[k] * hit.at[k];
      } else {
        row.nodes[k] = stencil.corners[k];
        row.weights[k] = hit.weights[k];
      }
    }
    if (stencil.bone >= 0) {
      const RigidMotion& pose = input.bone_poses[at_index(stencil.bone)];
      const RigidMotion& previous = input.previous_bone_poses[at_index(stencil.bone)];
      const double side = stencil.bone_is_first ? -1 : 1;  // so that the weights of the muscle's side are positive
      const Vec3 point = -side * on_bone;
      for (double& weight : row.weights) weight *= side;
      row.normal = side * pose.apply_to_direction(normal);
      row.start_normal = side * previous.apply_to_direction(normal);
      row.offset_m += row.normal.dot(pose.apply(point));
      row.start_offset_m += row.start_normal.dot(previous.apply(point));
      row.carried_m = pose.apply(point) - previous.apply(point);
    }
    const auto [known, is_new] = m_row_of.try_emplace(stencil, m_rows.size());
    if (is_new) {
      m_rows.push_back(row);
    } else {
      m_rows[known->second] = row;
    }
  }

  void look_again_at(const PassageStencil& stencil) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (!stencil.is_of_bone(k)) m_is_moved[at_index(stencil.corners[k])] = 1;
    }
  }

  /// Joins what still comes too close, with all that this brings too close in turn.
  void move_in_zones(const ContactStageInput& input) {
    m_zones.begin(m_safe, m_proposed);
    while (!m_hits.empty()) {
      bool has_grown = false;
      for (const Hit& hit : m_hits) has_grown = m_zones.join(hit.stencil, input) || has_grown;
      if (!has_grown) {
        note_what_closes();
        return;
      }
      m_zones.place(input, m_inverse_masses, m_proposed, m_is_moved);
      change_moved();
      find_hits();
    }
  }

  /// Of the hits that are left, one whose features come closer: what moves as is prescribed brings them together.
  /// Features that touch are hits also where they move as one.
  void note_what_closes() {
    if (!m_gave_up.empty()) return;
    const auto hit = std::ranges::find_if(m_hits, [&](const Hit& each) {
      const PassageStencil& stencil = each.stencil;
      const double change_m =
          distance_of(stencil.kind, m_paths.ends_of(stencil)) - distance_of(stencil.kind, m_paths.starts_of(stencil));
      return std::abs(change_m) > touching_m();
    });
    if (hit == m_hits.end()) return;
    std::size_t corner = 0;
    while (hit->stencil.is_of_bone(corner)) ++corner;
    const int node = hit->stencil.corners[corner];
    m_gave_up = fmt::format("{} is between {}, which come together", m_bodies[m_paths.body_of_node(node)].name,
                            m_zones.prescribed_in_zone_of(node, m_bones));
  }

  PassagePaths m_paths;
  std::span<const Bone> m_bones;
  std::vector<Body> m_bodies;
  LeftOut m_left_out;
  double m_gap_m;
  int m_rounds;
  std::vector<double> m_inverse_masses;
  ContactRowSolver m_solver;
  // Positions of all nodes, world frame.
  std::vector<Vec3> m_safe;      ///< where the last substep ended
  std::vector<Vec3> m_proposed;  ///< where this one is to end
  std::vector<char> m_is_moved;  ///< by node: its path is not the one that was last looked at
  std::vector<int> m_moved;      ///< the same, ascending
  std::vector<Found> m_found;
  std::vector<Hit> m_hits;
  std::vector<ContactRow> m_rows;
  std::map<PassageStencil, std::size_t> m_row_of;
  PassageZones m_zones;
  std::vector<int> m_changed;
  int m_hit_count = 0;
  std::string m_gave_up;
};

std::unique_ptr<ContactStage> make_no_passage(const StageInput& input, const Parameters& parameters) {
  return std::make_unique<NoPassage>(input, parameters.number("gap_m"), static_cast<int>(parameters.integer("rounds")),
                                     parameters.flag("itself"));
}

std::vector<ParameterSpec> no_passage_parameters() {
  return {parameter::number({.name = "gap_m",
                             .unit = "m",
                             .default_value = 1e-4,
                             .minimum = 1e-9,
                             .maximum = 0.1,
                             .help = "distance that surfaces are brought back to where they came too close"}),
          parameter::integer({.name = "rounds",
                              .default_value = 8,
                              .minimum = 1,
                              .maximum = 1000,
                              .help = "times that paths are corrected as contacts before what is left moves as one"}),
          parameter::flag(
              {.name = "itself",
               .default_value = true,
               .help = "keeps each muscle apart from itself, too: most of the cost where little else is near"})};
}

}  // namespace

/// Lets no node, edge or face of a muscle pass through a bone, another muscle or the muscle itself, at any speed: what
/// does not intersect when a substep begins does not intersect when it ends.
///
/// After everything else has moved the nodes, each pair of features whose paths come close is followed by additive
/// conservative advancement (`safe_share`), against a bone in the bone's frame. Pairs that would come too close become
/// rows of ContactRowSolver, with the normal that they have just before they touch, and the new paths are followed in
/// turn. What rows don't settle is joined to zones, which move as a whole (PassageZones; rigid impact zones, as
/// Bridson, Fedkiw and Anderson 2002 use them), so that this ends.
///
/// What a step has to look at, `NearPairs` tells from the distances that earlier steps measured.
///
/// Left out, as no choice of positions can prevent them: faces of which a node is bound to the bone, and features that
/// only bones move. What intersects a collider as the run begins, or lies inside it, is left out until it is free of it
/// (`LeftOut`). Where bones close on a zone from two sides, it follows the first of them.
EffectEntry no_passage_entry() {
  return {.name = "no_passage",
          .help = "no node, edge or face passes through a bone, another muscle or its own muscle",
          .parameters = no_passage_parameters(),
          .make_stage = make_no_passage,
          .remedies = {{Requirement::bone_passage},
                       {Requirement::muscle_passage},
                       {Requirement::self_passage},
                       {Requirement::bone_depth},
                       {Requirement::muscle_depth}},
          .colour = "#662506"};
}

}  // namespace musclebench

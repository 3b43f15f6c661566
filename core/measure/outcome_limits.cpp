#include "core/measure/outcome_limits.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/base/quantity_words.hpp"
#include "core/measure/outcome.hpp"

namespace musclebench {
namespace {

// Measured on four muscles of the LHDL hip with exact contacts of nodes: the surface is 0.24 mm deep in a bone
// (iliacus) to 2.6 mm (gluteus maximus), which surface_contact holds below 0.1 mm; 99 of 100 edges are at most 2.3
// times as long as at rest.
constexpr std::array<OutcomeLimit, 13> limits{{
    {{"volume_error", "", "largest departure of the volume from its target, over the target"},
     0.05,
     "muscle is nearly incompressible: a larger change is lost or gained tissue"},
    {{"turned_inside_out", "", "whether the volume may have the other sign than at rest"},
     0,
     "inside and outside are exchanged, and contact pushes the wrong way"},
    {{"edge_stretch_p99", "", "99th percentile over the edges of length over length at rest, largest over the frames"},
     3,
     "beyond it the surface is torn, not stretched; a single longer edge is a note"},
    {{"crossing_share", "",
      "triangles of a muscle that pass through the muscle itself, through a muscle whose contact with it is not asked "
      "for, or through a bone that encloses no volume; without those at rest and beside these, over all of the muscle"},
     0.01,
     "there is no depth to judge by: the surface is folded through itself, or nothing keeps the two apart"},
    {{"tunnelled_nodes", "", "nodes on the wrong side of a bone"}, 0, "they went through it and stay there"},
    {{"passed_nodes", "", "nodes that went through another muscle between two judged frames"},
     0,
     "the two changed sides and touched in no frame"},
    {{"stuck_share", "", "nodes that false contacts held in one frame, over the free nodes"},
     0.01,
     "a node that nothing touches is held in place"},
    {{"ring_share", "of the radius of a retinaculum", "how far a tendon is out of it"},
     0.25,
     "faces between nodes reach out a little; what is farther out is not held"},
    {{"depth_edges", "mean edges at rest", "how deep a muscle is in a bone or in another muscle"},
     1,
     "contact sees nodes only: what is a whole edge deep has entered between them"},
    {{"depth_share", "of the muscle's diagonal", "the same depth"},
     0.005,
     "about a millimetre for a muscle of the hip, whatever the mesh: what moment arms and volumes feel"},
    {{"thickness_share", "of the bone's thickness (2 volume / area)", "the same depth in a bone"},
     0.25,
     "a thin bone is never deep in anything: a needle passes whole through a muscle"},
    {{"shared_face_share", "", "triangles that two muscles have in common before the first frame, over those of one"},
     0.01,
     "one lies exactly in the other, and which of them is outside is undecided"},
    {{"missed_share", "",
      "contacts that the backend missed and that are deeper than it declares, over the true ones of the run"},
     0.01,
     "the backend does not hold what it declares; one that declares nothing may miss none"},
}};

/// Above this the longest edge is worth a note.
constexpr double noted_stretch = 4;

std::string words_of(const Moment& when) {
  return when.angle_deg == 0 ? fmt::format("in frame {}", when.frame)
                             : fmt::format("at {:.0f} degrees (frame {})", when.angle_deg, when.frame);
}

template <typename Value>
std::optional<double> ratio(const std::optional<Value>& value, double whole) {
  if (!value || !(whole > 0)) return std::nullopt;
  return static_cast<double>(*value) / whole;
}

/// Says what is beyond a limit, by names.
class Suspicions {
 public:
  Suspicions(const Outcome& outcome, const MuscleAtRest& rest) : m_outcome(outcome), m_rest(rest) {}

  std::vector<std::string> take() && {
    check_shape();
    check_crossings();
    check_nodes();
    check_depths();
    check_rest();
    check_misses();
    return std::move(m_found);
  }

 private:
  /// Adds the words that `tell` makes of the value and the limit `name` where the value is beyond it.
  template <typename Tell>
  void check(std::string_view name, std::optional<double> value, const Tell& tell) {
    const double limit = outcome_limit(name);
    if (value && !(*value <= limit)) m_found.push_back(tell(*value, limit));
  }
  [[nodiscard]] bool has(std::string_view effect) const {
    return std::find(m_rest.effects.begin(), m_rest.effects.end(), effect) != m_rest.effects.end();
  }
  /// " of NAME" where there are several.
  [[nodiscard]] std::string of_muscle(int muscle) const {
    return m_rest.muscles.size() > 1 ? " of " + muscle_name(muscle) : "";
  }
  [[nodiscard]] const std::string& muscle_name(int muscle) const {
    return m_rest.muscles[static_cast<std::size_t>(muscle)].name;
  }
  [[nodiscard]] const std::string& bone_name(int bone) const {
    return m_rest.bones[static_cast<std::size_t>(bone)].name;
  }

  void check_shape() {
    check("volume_error", m_outcome.max_volume_error, [&](double error, double limit) {
      const bool is_held = has("volume") || has("local_volume");
      return fmt::format("the volume{} is off its target by {} {} (limit {}): {}", of_muscle(m_outcome.volume_muscle),
                         in_percent(error), words_of(m_outcome.when_volume), in_percent(limit),
                         is_held ? "take more substeps" : "add volume");
    });
    check("turned_inside_out", m_outcome.turned_inside_out,
          [](double, double) { return std::string("the muscle is turned inside out: take more substeps"); });
    check("edge_stretch_p99", m_outcome.p99_edge_stretch, [&](double stretch, double limit) {
      return fmt::format(
          "one edge of a hundred is {:.3g} times as long as at rest, or longer, {} (limit {:g}): {}", stretch,
          words_of(m_outcome.when_p99_stretch), limit,
          has("edge_length") ? "take more substeps or a smaller compliance of edge_length" : "add edge_length");
    });
  }

  void check_crossings() {
    for (std::size_t i = 0; i < m_outcome.beyond_rest.size() && i < m_rest.crossing_pairs.size(); ++i) {
      const CrossingPair& pair = m_rest.crossing_pairs[i];
      if (pair.muscle >= std::ssize(m_rest.muscles)) continue;
      const MostCrossings& most = m_outcome.crossings[i];
      const MostCrossings& beyond_rest = m_outcome.beyond_rest[i];
      const auto share =
          ratio(std::optional(beyond_rest.triangles), m_rest.muscles[static_cast<std::size_t>(pair.muscle)].triangles);
      if (has("no_passage") && most.triangles > 0) {
        m_found.push_back(fmt::format(
            "{} triangles of {} pass through {} {}, and no_passage only keeps apart what is apart before the first "
            "frame "
            "and not brought together by bones alone: take settle_substeps or place the meshes apart",
            most.triangles, muscle_name(pair.muscle), name_of_other(pair), words_of({most.frame, most.angle_deg})));
        continue;
      }
      const std::string what = through_what(pair);
      if (what.empty()) continue;
      check("crossing_share", share, [&](double value, double limit) {
        return fmt::format("{} of the triangles of {} pass through {} {} (limit {}){}", in_percent(value),
                           muscle_name(pair.muscle), what, words_of({beyond_rest.frame, beyond_rest.angle_deg}),
                           in_percent(limit), cure_of(pair));
      });
    }
  }

  [[nodiscard]] std::string name_of_other(const CrossingPair& pair) const {
    if (pair.kind == CrossedSurface::itself) return "the muscle itself";
    return pair.kind == CrossedSurface::muscle ? muscle_name(pair.other) : "the " + bone_name(pair.other);
  }
  /// Empty where depths are judged.
  [[nodiscard]] std::string through_what(const CrossingPair& pair) const {
    if (pair.kind == CrossedSurface::itself) return name_of_other(pair);
    if (pair.kind == CrossedSurface::muscle) return m_rest.touch(pair.muscle, pair.other) ? "" : name_of_other(pair);
    const bool is_open =
        pair.other < std::ssize(m_rest.bones) && m_rest.bones[static_cast<std::size_t>(pair.other)].thickness_m == 0;
    return is_open ? name_of_other(pair) + ", which encloses no volume" : "";
  }
  [[nodiscard]] std::string cure_of(const CrossingPair& pair) const {
    if (pair.kind == CrossedSurface::itself) return has("self_contact") ? "" : ": add self_contact";
    if (pair.kind == CrossedSurface::muscle) return ", as no contact between them is asked for: add muscle_contact";
    return ": close its surface";
  }

  [[nodiscard]] std::string cure_of_escape() const {
    if (!has("retinaculum")) return "add retinaculum";
    return m_outcome.ring_escape.has_left ? "it slid farther than slide_m; give a larger one" : "take more substeps";
  }

  void check_nodes() {
    check("tunnelled_nodes", m_outcome.tunnelled_nodes, [&](double nodes, double) {
      return fmt::format("{} nodes went through a bone and are on its wrong side {}: {}", nodes,
                         words_of(m_outcome.when_tunnelled),
                         has("tunnelling_guard") ? "take more substeps" : "add tunnelling_guard");
    });
    check("passed_nodes", m_outcome.passed_nodes, [&](double nodes, double) {
      return fmt::format(
          "{} nodes went through another muscle between two frames {}: take more substeps or a smaller step", nodes,
          words_of(m_outcome.when_passed));
    });
    check("ring_share", m_outcome.ring_escape.share, [&](double, double limit) {
      const auto ring = static_cast<std::size_t>(std::max(m_outcome.ring_escape.ring, 0));
      return fmt::format("the tendon in {} is {} out of it {} (limit {} of its radius): {}", m_rest.rings.at(ring),
                         in_millimetres(m_outcome.ring_escape.outside_m), words_of(m_outcome.when_out_of_ring),
                         in_percent(limit), cure_of_escape());
    });
    check("stuck_share", ratio(m_outcome.stuck_nodes, m_rest.free_nodes), [&](double share, double limit) {
      return fmt::format(
          "{} of the free nodes are held by contacts that are none {} (limit {}): take a finer or an exact "
          "backend",
          in_percent(share), words_of(m_outcome.when_stuck), in_percent(limit));
    });
  }

  void check_depths() {
    const std::optional<WorstDepth>& worst = m_outcome.worst_depth;
    const bool is_deep = worst && worst->is_beyond();
    if (is_deep) m_found.push_back(depth_in_bone(*worst));
    if (!is_deep) check_open_judgements();
    const std::optional<WorstDepth>& in_muscle = m_outcome.worst_muscle_depth;
    if (!in_muscle || !in_muscle->is_beyond()) return;
    const bool nodes_are_out = in_muscle->node_depth_m < 0.5 * in_muscle->depth_m;
    m_found.push_back(fmt::format(
        "{} is {} deep in {} {} (limit {}, {}){}", muscle_name(in_muscle->bodies.muscle),
        in_millimetres(in_muscle->depth_m), muscle_name(in_muscle->bodies.other), words_of(in_muscle->when),
        in_millimetres(in_muscle->limit.depth_m), in_muscle->limit.because,
        nodes_are_out ? ", because contact between muscles acts at nodes: take finer meshes" : ": take more substeps"));
  }

  [[nodiscard]] std::string depth_in_bone(const WorstDepth& worst) const {
    const std::string where = fmt::format("{} (limit {}, {})", words_of(worst.when),
                                          in_millimetres(worst.limit.depth_m), worst.limit.because);
    const std::string& bone = bone_name(worst.bodies.other);
    const std::string depth =
        worst.is_bone_vertex
            ? fmt::format("a vertex of the {} is {} deep in {} {}", bone, in_millimetres(worst.depth_m),
                          m_rest.muscles.size() > 1 ? muscle_name(worst.bodies.muscle) : "the muscle", where)
            : fmt::format("the surface{} is {} deep in the {} {}", of_muscle(worst.bodies.muscle),
                          in_millimetres(worst.depth_m), bone, where);
    const bool nodes_are_out = worst.node_depth_m < 0.5 * worst.depth_m;
    if (nodes_are_out && !has("surface_contact")) return depth + ", because contact acts at nodes: add surface_contact";
    if (misses_contacts())
      return depth + fmt::format(", because {} misses contacts: take another backend or a finer one", m_rest.backend);
    return depth + ": take more substeps";
  }

  /// Where the Referee's budget did not suffice, the bound that is left counts as the depth: it cannot be excluded.
  void check_open_judgements() {
    if (m_outcome.open_judgements == 0 || !m_outcome.max_surface_depth_bound_m) return;
    std::optional<DepthLimit> smallest;
    for (const MuscleSize& muscle : m_rest.muscles) {
      for (const BoneSize& bone : m_rest.bones) {
        const DepthLimit limit = depth_limit(muscle, bone);
        if (!smallest || limit.depth_m < smallest->depth_m) smallest = limit;
      }
    }
    if (!smallest || *m_outcome.max_surface_depth_bound_m <= smallest->depth_m) return;
    m_found.push_back(fmt::format(
        "the surface may be {} deep in a bone (limit {}, {}), as the Referee's budget did not suffice for {} frame{}: "
        "take more substeps, which pay for it",
        in_millimetres(*m_outcome.max_surface_depth_bound_m), in_millimetres(smallest->depth_m), smallest->because,
        m_outcome.open_judgements, m_outcome.open_judgements == 1 ? "" : "s"));
  }

  void check_rest() {
    const auto is_beyond = [](const DepthStatistics& depth, const DepthLimit& limit) {
      return !(depth.max_depth_m <= limit.depth_m);
    };
    const auto muscle_of = [&](const DeepBodies& bodies) -> const MuscleSize& {
      return m_rest.muscles[static_cast<std::size_t>(bodies.muscle)];
    };
    if (const DeepBodies& bodies = m_rest.depth_bodies; m_rest.depth && bodies.other >= 0) {
      const DepthLimit limit = depth_limit(muscle_of(bodies), m_rest.bones[static_cast<std::size_t>(bodies.other)]);
      if (is_beyond(*m_rest.depth, limit)) {
        m_found.push_back(fmt::format(
            "{} free nodes were inside bones before the first frame, up to {} deep in the {} (limit {}, {}): move the "
            "two apart, or set settle_substeps",
            m_rest.depth->nodes_inside, in_millimetres(m_rest.depth->max_depth_m), bone_name(bodies.other),
            in_millimetres(limit.depth_m), limit.because));
      }
    }
    if (const DeepBodies& bodies = m_rest.in_muscles_bodies; m_rest.in_muscles && bodies.other >= 0) {
      const DepthLimit limit = depth_limit(muscle_of(bodies), m_rest.muscles[static_cast<std::size_t>(bodies.other)]);
      if (is_beyond(*m_rest.in_muscles, limit)) {
        m_found.push_back(fmt::format(
            "{} was {} deep in {} before the first frame (limit {}, {}): move the two apart, or set settle_substeps",
            muscle_name(bodies.muscle), in_millimetres(m_rest.in_muscles->max_depth_m), muscle_name(bodies.other),
            in_millimetres(limit.depth_m), limit.because));
      }
    }
    for (const SharedFaces& shared : m_rest.shared_faces) {
      const int triangles = m_rest.muscles[static_cast<std::size_t>(shared.muscle)].triangles;
      check("shared_face_share", ratio(std::optional(shared.triangles), triangles), [&](double share, double limit) {
        return fmt::format(
            "{} of the triangles of {} are those of {} before the first frame (limit {}): is one mesh named "
            "twice?",
            in_percent(share), muscle_name(shared.muscle), muscle_name(shared.other), in_percent(limit));
      });
    }
  }

  [[nodiscard]] std::optional<double> missed_share() const {
    return ratio(m_outcome.missed_beyond, static_cast<double>(m_outcome.true_contacts.value_or(0)));
  }
  [[nodiscard]] bool misses_contacts() const { return missed_share().value_or(0) > outcome_limit("missed_share"); }

  void check_misses() {
    check("missed_share", missed_share(), [&](double share, double limit) {
      return fmt::format(
          "{} missed {} of {} contacts ({}, limit {}) by more than it declares, up to {} deep: take another "
          "backend or a finer one",
          m_rest.backend.empty() ? "the backend" : m_rest.backend, *m_outcome.missed_beyond, *m_outcome.true_contacts,
          in_percent(share), in_percent(limit), in_millimetres(m_outcome.max_missed_m));
    });
  }

  const Outcome& m_outcome;
  const MuscleAtRest& m_rest;
  std::vector<std::string> m_found;
};

}  // namespace

std::span<const OutcomeLimit> outcome_limits() { return limits; }

double outcome_limit(std::string_view name) {
  const auto found = std::ranges::find(limits, name, [](const OutcomeLimit& limit) { return limit.info.name; });
  assert(found != limits.end());
  return found->limit;
}

std::vector<std::string> suspicions(const Outcome& outcome, const MuscleAtRest& rest) {
  return Suspicions(outcome, rest).take();
}

std::vector<std::string> outcome_notes(const Outcome& outcome) {
  std::vector<std::string> notes;
  if (outcome.max_edge_stretch.value_or(0) > noted_stretch) {
    notes.push_back(fmt::format(
        "the longest edge is {:.3g} times as long as at rest {}; 99 of 100 are at most {:.3g} times",
        *outcome.max_edge_stretch, words_of(outcome.when_max_stretch), outcome.p99_edge_stretch.value_or(0)));
  }
  return notes;
}

}  // namespace musclebench

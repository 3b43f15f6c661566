#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/cases/verification.hpp"
#include "bench/hard/moved_scene.hpp"
#include "core/base/random_numbers.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/shapes.hpp"
#include "core/referee/referee.hpp"
#include "datasets/hard/hard_shapes.hpp"

// Cases of the loop, its effects and its stages, which are the same for every backend.
namespace musclebench {

namespace {

/// The largest distance of a node from where the muscle has it at rest, besides the mean of all, after `frame`, in
/// diagonals; NaN of a run that diverged.
double off_rest_in_diagonals(const MovedScene& run, std::size_t frame) {
  if (run.result.status == "diverged" || frame >= run.result.snapshots.size()) return std::nan("");
  const std::vector<Vec3>& rest = run.scene.muscle_mesh.vertices;
  std::vector<Vec3> centred = run.positions(frame);
  Vec3 mean = Vec3::Zero();
  for (std::size_t node = 0; node < rest.size(); ++node) mean += centred[node] - rest[node];
  mean /= static_cast<double>(rest.size());
  for (Vec3& position : centred) position -= mean;
  return largest_gap_m(rest, centred) / run.diagonal_m();
}

double off_rest_at_end(const MovedScene& run) {
  return off_rest_in_diagonals(run, static_cast<std::size_t>(run.scene.loop.frames));
}

/// The largest of all frames.
double farthest_in_diagonals(const MovedScene& run) {
  double farthest = 0;
  for (int frame = 1; frame <= run.scene.loop.frames; ++frame) {
    const double off = off_rest_in_diagonals(run, static_cast<std::size_t>(frame));
    if (!(off <= farthest)) farthest = off;  // not std::max: it passes over NaN
  }
  return farthest;
}

HardFigure volume_error(const MovedScene& run, const std::string& words, double bar) {
  return {words + ": volume error at the end", run.result.outcome.final_volume_error.value_or(std::nan("")), bar};
}

/// How far a node of the shaken ball may go, in diagonals of its box: seven times the noise, and with a pressure p as
/// far as a ball of p times the volume is larger or smaller, and a quarter more.
double most_of_extreme(std::string_view parameter, double value) {
  constexpr double of_noise = 0.1;
  if (parameter != "pressure") return of_noise;
  const double radius = 0.5 / std::sqrt(3);  // of a ball, over the diagonal of its box
  return of_noise + 1.25 * radius * std::abs(std::cbrt(value) - 1);
}

HardCell extremes(const HardRequest& request) {
  return watched(request, false, [&] {
    std::vector<HardFigure> figures;
    for (const char* preset : {"paper", "standard"}) {
      SceneChoice usual = scene_of("hard/extremes");
      usual.preset = preset;
      const auto moved_with = [&](const std::string& effect, const std::string& parameter, double value) {
        SceneChoice choice = usual;
        choice.effect_overrides.push_back({.location = "extremes", .name = effect, .values = {{parameter, value}}});
        return moved(request, choice);
      };
      const auto words = [&](const std::string& effect, const std::string& parameter, double value) {
        return fmt::format("{}, {}.{} = {:g}", preset, effect, parameter, value);
      };
      for (const SceneEffect& effect : load_scene(usual).effects) {
        for (const ParameterSpec& spec : find_effect(effect.name)->parameters) {
          if (spec.kind != ParameterKind::number) continue;
          for (const double value : {spec.minimum, spec.maximum}) {
            figures.push_back({words(effect.name, spec.name, value) + ": farthest node from rest, in diagonals",
                               farthest_in_diagonals(moved_with(effect.name, spec.name, value)),
                               most_of_extreme(spec.name, value)});
          }
        }
      }
      // Of pressures that are of use. The paper's public code projects a sixth of the error.
      if (std::string(preset) == "paper") continue;
      for (const double value : {0.5, 2.0}) {
        figures.push_back(
            volume_error(moved_with("volume", "pressure", value), words("volume", "pressure", value), 0.01));
      }
    }
    return judged(std::move(figures), request, "", MayRefuse::nobody);
  });
}

HardCell blow_up(const HardRequest& request) {
  return watched(request, false, [&] {
    SceneChoice choice = scene_of("hard/time_step");
    choice.effect_overrides.push_back(
        {.location = "non-finite", .name = "gravity", .values = {{"z_m_per_s2", -1000.0}}});
    // Whose rate times the step would stop the fall.
    choice.effect_overrides.push_back({.location = "non-finite", .name = "damping", .is_removed = true});
    choice.loop_overrides["time_step_s"] = 1e3;
    const MovedScene run = moved(request, choice);
    int not_finite = 0;
    for (const StepRecord& record : run.result.records) {
      for (const double volume_m3 : record.volumes_m3) not_finite += std::isfinite(volume_m3) ? 0 : 1;
    }
    return judged(
        {{"runs that blow up and don't say in which frame",
          run.result.status == "diverged" && run.result.status_detail.find("frame") != std::string::npos ? 0.0 : 1.0,
          0},
         {"rows with numbers that are none", static_cast<double>(not_finite), 0, "rows"}},
        request, "", MayRefuse::nobody);
  });
}

/// Bars of `time-step`. A ball that comes to rest is off by the turn that the noise of its n nodes gives it, noise over
/// sqrt(n): 6e-4 diagonals here. One that still swings goes as far as with 1 ms and 100 iterations, where it has
/// converged (0.034 diagonals), within a factor of five for what coarse steps add.
constexpr double most_at_rest = 2e-3;
constexpr double most_swinging = 0.172;
constexpr double most_at_end_swinging = 0.05;

HardCell time_step(const HardRequest& request) {
  return watched(request, false, [&] {
    std::vector<HardFigure> figures;
    const auto add = [&](const MovedScene& run, const std::string& words, bool has_come_to_rest) {
      figures.push_back({words + ": farthest node from rest, in diagonals", farthest_in_diagonals(run), most_swinging});
      figures.push_back({words + ": the same at the end", off_rest_at_end(run),
                         has_come_to_rest ? most_at_rest : most_at_end_swinging});
      figures.push_back(volume_error(run, words, 1e-3));
    };
    for (const double factor : {1.0, 10.0, 100.0, 1000.0}) {
      for (const std::int64_t iterations :
           request.whole ? std::vector<std::int64_t>{1, 10, 100} : std::vector<std::int64_t>{1, 100}) {
        SceneChoice choice = scene_of("hard/time_step");
        choice.loop_overrides["iterations"] = iterations;
        const std::string setting = fmt::format("{:g} ms, {} iterations", factor, iterations);
        const auto with_steps = [&](double step_s, const std::vector<TimeStepChange>& changes) {
          choice.loop_overrides["time_step_s"] = step_s;
          return moved(request, choice, 1, [&](Scene& scene) { scene.loop.time_step_changes = changes; });
        };
        add(with_steps(1e-3 * factor, {}), setting, factor > 1.0);
        if (factor == 1.0) continue;
        add(with_steps(1e-3, {{21, 1e-3 * factor}, {41, 1e-3}}), setting + " from frame 21 to 40 only", false);
      }
    }
    return judged(std::move(figures), request, "", MayRefuse::nobody);
  });
}

/// A shaken ball that effects pull back, every second node of it heavy or fixed.
class ShakenBall {
 public:
  ShakenBall(const Scene& scene, double light_over_heavy)
      : m_scene(scene), m_bodies(scene.bodies()), m_order(scene.muscle_mesh.vertices, m_bodies) {
    RandomNumbers random(7);
    for (const Vec3& vertex : scene.muscle_mesh.vertices) {
      m_inverse_masses.push_back(m_inverse_masses.size() % 2 == 0 ? 1 : light_over_heavy);
      const auto noise_m = [&] { return 5e-4 * (2 * random.share() - 1); };
      m_start.push_back(vertex + Vec3(noise_m(), noise_m(), noise_m()));
    }
    m_rows = NodeRows(m_order, m_start, m_inverse_masses);
  }

  void project(const std::vector<std::string>& effects) {
    std::vector<BoundNode> fixed;
    for (std::size_t node = 0; node < m_start.size(); ++node) {
      if (m_inverse_masses[node] == 0) fixed.push_back({static_cast<int>(node), 0});
    }
    const std::vector<std::vector<FibreSegment>> no_fibres(m_bodies.size());
    const std::vector<RigidMotion> poses(m_scene.bones.size());
    const EffectInput input{m_scene.muscle_mesh, m_bodies, m_order, no_fibres, fixed, poses};
    const SubstepInput substep{.time_step_s = 1e-3, .bone_poses = poses};
    std::vector<NodeRow> velocities(m_order.size());
    std::vector<std::unique_ptr<Effect>> made;
    for (const std::string& name : effects) {
      const EffectEntry* entry = find_effect(name);
      made.push_back(entry->make(input, Parameters(entry->parameters, {}, name)));
      made.back()->apply_force(m_rows, velocities, substep, Team());
    }
    for (int pass = 0; pass < 10; ++pass) {
      for (const auto& effect : made) effect->project(m_rows, substep, Team());
    }
  }

  [[nodiscard]] double largest_move_m() const {
    return largest_move_of([](double) { return true; });
  }
  [[nodiscard]] double largest_move_of_fixed_m() const {
    return largest_move_of([](double inverse_mass) { return inverse_mass == 0; });
  }
  /// Of the nodes that can move.
  [[nodiscard]] double drift_of_centre_m() const {
    Vec3 moment = Vec3::Zero();
    double mass_kg = 0;
    for (std::size_t node = 0; node < m_start.size(); ++node) {
      if (m_inverse_masses[node] == 0) continue;
      moment += move_of(node) / m_inverse_masses[node];
      mass_kg += 1 / m_inverse_masses[node];
    }
    return moment.norm() / mass_kg;
  }

 private:
  [[nodiscard]] Vec3 move_of(std::size_t node) const {
    return m_rows[m_order.row_of(static_cast<int>(node))].position() - m_start[node];
  }
  template <typename Select>
  [[nodiscard]] double largest_move_of(const Select& select) const {
    double largest_m = 0;
    for (std::size_t node = 0; node < m_start.size(); ++node) {
      const double move_m = move_of(node).norm();
      // Not std::max: it passes over NaN.
      if (select(m_inverse_masses[node]) && !(move_m <= largest_m)) largest_m = move_m;
    }
    return largest_m;
  }

  const Scene& m_scene;
  std::vector<Body> m_bodies;
  NodeOrder m_order;
  std::vector<double> m_inverse_masses;
  std::vector<Vec3> m_start;
  NodeRows m_rows;
};

/// Constraints move heavy nodes and light ones by so much that their centre of mass stays, and fixed ones not at all.
HardCell mass_ratio(const HardRequest& request) {
  return watched(request, false, [&] {
    std::vector<HardFigure> figures;
    Scene scene = load_scene(scene_of("hard/time_step"));
    if (request.spoil) request.spoil(scene);
    const double diagonal_m = bounding_box(scene.muscle_mesh.vertices).diagonal().norm();
    // All of them last: alone, what is bent has nothing to keep its edges' lengths.
    for (const std::vector<std::string>& effects : std::vector<std::vector<std::string>>{
             {"edge_length"}, {"volume"}, {"bending"}, {"edge_length", "volume", "bending"}}) {
      const std::string words = effects.size() > 1 ? "all of them" : effects.front();
      ShakenBall heavy(scene, 1e-6);
      heavy.project(effects);
      figures.push_back({words + ", masses 1 : 1e6: drift of the centre of mass, over the diagonal",
                         heavy.drift_of_centre_m() / diagonal_m, 1e-12});
      ShakenBall fixed(scene, 0);
      fixed.project(effects);
      figures.push_back({words + ": largest move of a fixed node", fixed.largest_move_of_fixed_m(), 0, "m"});
      for (const auto& [ball, which] : {std::pair(&heavy, "masses 1 : 1e6"), std::pair(&fixed, "fixed nodes")}) {
        figures.push_back({fmt::format("{}, {}: correction that moves nothing", words, which),
                           ball->largest_move_m() > 1e-5 * diagonal_m ? 0.0 : 1.0, 0});
        if (effects.size() == 1) continue;
        figures.push_back({fmt::format("{}, {}: largest move of a node, in diagonals", words, which),
                           ball->largest_move_m() / diagonal_m, 0.1});
      }
    }
    return judged(std::move(figures), request, "", MayRefuse::nobody);
  });
}

/// A straight path of one step, in the bone's frame, m, that begins outside.
struct StepPath {
  Vec3 from;
  Vec3 to;
};

/// Whether it goes into the bone and comes out where the surface faces the other way: by all triangles of the mesh, one
/// by one (Moeller and Trumbore 1997), with no tree.
bool passes_through(const TriangleMesh& mesh, const StepPath& path) {
  const Vec3 along = path.to - path.from;
  std::vector<std::pair<double, Vec3>> crossings;  // share of the path, outward normal
  for (const auto& [ia, ib, ic] : mesh.triangles) {
    const Vec3& a = mesh.vertices[static_cast<std::size_t>(ia)];
    const Vec3 ab = mesh.vertices[static_cast<std::size_t>(ib)] - a;
    const Vec3 ac = mesh.vertices[static_cast<std::size_t>(ic)] - a;
    const Vec3 across = along.cross(ac);
    const double determinant = ab.dot(across);
    if (determinant == 0) continue;
    const Vec3 to_start = path.from - a;
    const double u = to_start.dot(across) / determinant;
    const Vec3 other = to_start.cross(ab);
    const double v = along.dot(other) / determinant;
    const double share = ac.dot(other) / determinant;
    if (u < 0 || v < 0 || u + v > 1 || share < 0 || share > 1) continue;
    crossings.emplace_back(share, ab.cross(ac).normalized());
  }
  std::ranges::sort(crossings, {}, &std::pair<double, Vec3>::first);
  for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
    if (crossings[i].second.dot(crossings[i + 1].second) < 0) return true;
  }
  return false;
}

/// Which of the paths a guard with this rule ends early, each as the first step of a node of its own.
std::vector<bool> held_by_guard(const Bone& bone, const std::vector<StepPath>& paths, const std::string& rule) {
  const EffectEntry* entry = find_effect("tunnelling_guard");
  const std::vector<Bone> bones{bone};
  const std::unique_ptr<ContactStage> guard =
      entry->make_stage({bones, paths.size()}, Parameters(entry->parameters, {{"rule", rule}}, "angle-rule"));
  std::vector<Vec3> start;
  std::vector<Vec3> predicted;
  std::vector<int> nodes;
  for (const StepPath& path : paths) {
    nodes.push_back(static_cast<int>(start.size()));
    start.push_back(path.from);
    predicted.push_back(path.to);
  }
  const std::vector<RigidMotion> poses(1);
  const std::span<const int> held = guard->after_bones({start, predicted, nodes, poses, poses, {}});
  std::vector<bool> is_held(paths.size());
  for (const int node : held) is_held[static_cast<std::size_t>(node)] = true;
  return is_held;
}

HardCell angle_rule(const HardRequest& request) {
  return watched(request, false, [&] {
    std::vector<HardFigure> figures;
    const auto add_figures = [&](const std::string& words, TriangleMesh mesh) {
      const Bone bone{words, {std::move(mesh), true, {}}};
      const TriangleMesh& surface = bone.surface.mesh;
      const std::vector<Bone> bones{bone};
      const Referee referee(bones, 1);
      const double diagonal_m = bounding_box(surface.vertices).diagonal().norm();
      const std::vector<Vec3> points = points_about(surface, 20000, 11);
      RandomNumbers random(12);
      std::vector<StepPath> paths;
      for (const Vec3& from : points) {
        const auto part = [&] { return 2 * random.share() - 1; };
        const Vec3 to = from + 0.5 * diagonal_m * random.share() * Vec3(part(), part(), part());
        if (referee.signed_distance(0, from) > 1e-9 * diagonal_m) paths.push_back({from, to});
      }
      const std::vector<bool> crossing = held_by_guard(bone, paths, "crossing");
      const std::vector<bool> angle = held_by_guard(bone, paths, "angle");
      int through = 0, let_pass = 0, missed = 0, held = 0, held_wrongly = 0;
      for (std::size_t i = 0; i < paths.size(); ++i) {
        const bool is_through = passes_through(surface, paths[i]);
        through += is_through;
        let_pass += is_through && !crossing[i];
        missed += is_through && !angle[i];
        held += angle[i];
        held_wrongly += angle[i] && !is_through;
      }
      const auto share = [](int part, int whole) {
        return whole > 0 ? static_cast<double>(part) / whole : std::nan("");
      };
      figures.push_back({fmt::format("{}: of {} paths through, those that the guard as shipped (by crossing) lets pass",
                                     words, through),
                         share(let_pass, through), 0});
      figures.push_back({words + ": share of them that the rule of 135 degrees misses (1 less its recall)",
                         share(missed, through), 1});
      figures.push_back({words + ": share of what it holds that does not pass through (1 less its precision)",
                         share(held_wrongly, held), 1});
    };
    add_figures("plate", make_plate(0.004));
    add_figures("bumpy ball", make_bumpy_ball(3));
    add_figures("spike", make_spike());
    return judged(std::move(figures), request, "", MayRefuse::nobody);
  });
}

constexpr std::array cases_of_the_loop = {
    HardCase{.id = "time-step",
             .what = "A ball whose nodes start up to 1 mm off springs back, with steps of 1 ms to 1 s and 1 to 100 "
                     "iterations; once more with the long step in a third of the frames only.",
             .why = "Explicit forces blow up with the step; constraints must not (IPC sweeps dt).",
             .bar =
                 "no node farther from its rest than 5 times what it is with 1 ms and 100 iterations (0.17 "
                 "diagonals); at the end within 0.002 diagonals, or 0.05 where the last steps are of 1 ms and it still "
                 "swings; volume within 0.1 % at the end",
             .scene = "hard/time_step",
             .left_out_because = "nothing touches it, and the shape at the end is known",
             .asks_backend = false,
             .run = time_step},
    HardCase{
        .id = "extremes",
        .what = "A ball shaken by 1 mm, in the presets paper and standard, with each number of each effect at both "
                "ends of its range, one at a time.",
        .why = "Divisions without a guard show at the ends: no stiffness, all pressure, no compliance.",
        .bar = "no node farther than 0.1 diagonals from its rest within 20 frames; for a pressure p, no farther than a "
               "ball of p times the volume and a quarter more; volume within 1 % for pressures of 0.5 and 2",
        .scene = "hard/extremes",
        .left_out_because = "nothing touches it, and without stiffness or with all pressure its edges are to be longer",
        .asks_backend = false,
        .run = extremes},
    HardCase{.id = "non-finite",
             .what = "A ball thrown by a gravity of 1000 m/s2 with steps of 1000 s.",
             .why = "A run that has blown up goes on for hours, and its rows look like results.",
             .bar = "ends as diverged and names the frame; no row holds what is no number",
             .scene = "hard/time_step",
             .left_out_because = "it has to diverge",
             .asks_backend = false,
             .run = blow_up},
    HardCase{.id = "mass-ratio",
             .what =
                 "Each of edge lengths, volume and bending pulls back a shaken ball of which every second node is a "
                 "million times as heavy, or fixed.",
             .why = "A correction that is not shared by inverse mass makes momentum out of nothing.",
             .bar = "centre of mass within 1e-12 of the diagonal, fixed nodes to the bit",
             .scene = "hard/time_step",
             .left_out_because = "single corrections are made, and nothing runs",
             .asks_backend = false,
             .run = mass_ratio},
    HardCase{.id = "angle-rule",
             .what = "Random steps near a plate, a bumpy ball and a spike: which pass through, by all triangles one by "
                     "one; which the tunnelling guard ends, and which the paper's rule of 135 degrees.",
             .why = "Directions to the nearest surface differ by less where a step passes a corner. They differ by "
                    "more where it passes by a spike (paper VI-A, proposed and not tested).",
             .bar = "the guard as shipped lets none pass; recall and precision of the rule are reported",
             .scene = "",
             .asks_backend = false,
             .run = angle_rule},
};

}  // namespace

std::span<const HardCase> loop_cases() { return cases_of_the_loop; }

}  // namespace musclebench

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/hard/courses.hpp"
#include "bench/hard/loaded_scene.hpp"
#include "bench/hard/run_figures.hpp"

// Muscles under load against other muscles and against themselves.
namespace musclebench {

namespace {

/// What the loop conserves, of one frame that is one substep long.
struct Momenta {
  Vec3 linear = Vec3::Zero();   ///< kg m/s
  Vec3 angular = Vec3::Zero();  ///< about the origin, kg m2/s
  double kinetic_j = 0;
};

Momenta momenta_of_frame(const MovedScene& run, std::size_t frame) {
  const std::vector<double> masses_kg = node_masses_kg(run.scene);
  Momenta sum;
  for (std::size_t node = 0; node < masses_kg.size(); ++node) {
    const Vec3& position = run.positions(frame)[node];
    const Vec3 velocity = (position - run.positions(frame - 1)[node]) / frame_s(run.scene);
    sum.linear += masses_kg[node] * velocity;
    sum.angular += masses_kg[node] * position.cross(velocity);
    sum.kinetic_j += 0.5 * masses_kg[node] * velocity.squaredNorm();
  }
  return sum;
}

HardCell muscle_on_muscle(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    for (const std::string place : {"crossed_bars", "pressed_ball"}) {
      const Scene scene = load({"hard/" + place});
      Scene other = scene;
      swap_muscles(other);
      const MovedScene run = moved_in_time(request, scene, 4);
      const MovedScene swapped = moved_in_time(request, std::move(other), 4);
      if (figures.add_if_diverged(run, place) || figures.add_if_diverged(swapped, place)) continue;
      std::vector<HardFigure> of_run{{"difference by the order of the muscles, over the diagonal",
                                      gap_of_swapped_m(run, swapped) / run.diagonal_m(), 1e-6}};
      if (place == "crossed_bars") {
        // The bars meet with opposite momenta of the same size: what one loses the other has to gain.
        double mass_kg = 0;
        for (const double node_kg : node_masses_kg(run.scene)) mass_kg += node_kg;
        double most = 0;
        for (std::size_t frame = 1; frame < run.result.snapshots.size(); ++frame) {
          most = std::max(most, momenta_of_frame(run, frame).linear.norm());
        }
        constexpr double speed_m_per_s = 0.1;
        of_run.push_back({"momentum of both, over that of one", most / (0.5 * mass_kg * speed_m_per_s), 1e-9});
      }
      figures.add_tight_run(run, place, std::move(of_run));
    }
  });
}

HardCell thrown_at_muscle(const HardRequest& request) {
  return watched_runs(request, false, MayRefuse::everybody, [&](RunFigures& figures) {
    for (const double speed_m_per_s : {1.0, 10.0, 100.0}) {
      Scene scene = load({"hard/thrown_at_muscle"});
      scene.muscles[0].velocity_m_per_s = Vec3(0.5 * speed_m_per_s, 0, 0);
      scene.muscles[1].velocity_m_per_s = Vec3(-0.5 * speed_m_per_s, 0, 0);
      const MovedScene run = moved(request, std::move(scene));
      if (figures.add_if_diverged(run, fmt::format("{:g} m/s", speed_m_per_s))) continue;
      figures.add_run(run, fmt::format("{:g} m/s", speed_m_per_s),
                      {{"nodes that went through the other muscle",
                        static_cast<double>(run.result.outcome.passed_nodes.value_or(0)), 0, "nodes"}});
    }
  });
}

HardCell thrown_at_itself(const HardRequest& request) {
  return watched_runs(request, true, MayRefuse::everybody, [&](RunFigures& figures) {
    for (const double speed_m_per_s : {1.0, 10.0, 100.0}) {
      Scene scene = load({"hard/thrown_at_itself"});
      scene.muscles.front().velocity_m_per_s = Vec3(-speed_m_per_s, 0, 0);
      const MovedScene run = moved_in_time(request, std::move(scene), 3);
      if (figures.add_if_diverged(run, fmt::format("{:g} m/s", speed_m_per_s))) continue;
      figures.add_run(run, fmt::format("{:g} m/s", speed_m_per_s), {});
    }
  });
}

HardCell press_shut(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    // 14 mm in 30 frames of 20 substeps, in 2 of 20, in 2 of 2.
    struct Course {
      const char* words;
      std::int64_t moving;
      std::int64_t substeps;
    };
    for (const Course& course : {Course{"slowly", 30, 20}, Course{"fast", 2, 20}, Course{"in four steps", 2, 2}}) {
      const MovedScene run = moved_in_time(
          request,
          load({"hard/press_shut",
                {{"frames", course.moving + 6}, {"rest_frames", std::int64_t{6}}, {"substeps", course.substeps}}}),
          3);
      if (figures.add_if_diverged(run, course.words)) continue;
      figures.add_tight_run(run, course.words, {});
    }
  });
}

HardCell momentum(const HardRequest& request) {
  return watched_runs(request, false, [&](RunFigures& figures) {
    const std::int64_t frames = request.whole ? 1000 : 60;
    const auto add = [&](const char* words, Scene scene, bool may_give_energy) {
      const MovedScene run = moved(request, std::move(scene));
      if (figures.add_if_diverged(run, words)) return;
      const Momenta first = momenta_of_frame(run, 1);
      double mass_kg = 0;
      for (const double node_kg : node_masses_kg(run.scene)) mass_kg += node_kg;
      const double size_of_linear = std::sqrt(2 * mass_kg * first.kinetic_j);
      const double size_of_angular = size_of_linear * run.diagonal_m();
      double linear = 0;
      double angular = 0;
      double energy = 0;
      for (std::size_t frame = 2; frame < run.result.snapshots.size(); ++frame) {
        const Momenta now = momenta_of_frame(run, frame);
        linear = std::max(linear, (now.linear - first.linear).norm() / size_of_linear);
        angular = std::max(angular, (now.angular - first.angular).norm() / size_of_angular);
        energy = std::max(energy, now.kinetic_j / first.kinetic_j - 1);
      }
      std::vector<HardFigure> of_run{{"change of the linear momentum, over its size", linear, 1e-9},
                                     {"change of the angular momentum, over its size", angular, 1e-9}};
      // Edges off their length hold energy that the loop can't be blamed for.
      if (!may_give_energy) of_run.push_back({"growth of the kinetic energy", energy, 1e-9});
      figures.add_run(run, words, std::move(of_run));
    };
    const auto scene = [&](double noise_m) {
      Scene balls =
          load({"hard/thrown_at_muscle", {{"frames", frames}, {"time_step_s", 5e-4}, {"start_noise_m", noise_m}}});
      for (Muscle& muscle : balls.muscles) muscle.velocity_m_per_s *= 0.1;
      return balls;
    };
    add("collision", scene(0), false);
    Scene apart = scene(1e-3);
    for (Muscle& muscle : apart.muscles) muscle.velocity_m_per_s *= -1;
    add("free flight of shaken balls", std::move(apart), true);
  });
}

constexpr std::array cases_of_loaded_muscles = {
    HardCase{.id = "muscle-on-muscle",
             .what = "Two square bars meet edge on edge between nodes at 0.2 m/s; a bone presses a ball of muscle 6 mm "
                     "into a slab of muscle.",
             .why = "Contact that knows nodes against faces only lets edges through (review 3).",
             .bar = "no triangle through another muscle; both bars' momentum is none within 1e-9; the same within 1e-6 "
                    "diagonals for either order of muscles",
             .scene = "hard/crossed_bars",
             .left_out_because = depth_says_it,
             .effects = "muscle_contact attachment contact edge_length",
             .run = muscle_on_muscle},
    HardCase{.id = "thrown-at-muscle",
             .what = "Two balls of muscle fly into each other off centre, at 1, 10 and 100 m/s, with steps of 1 ms.",
             .why = "At 100 m/s a step is more than twice a ball's diameter, and they may never touch (review 3).",
             .bar = "no node and no triangle through the other muscle, or a status that says so",
             .scene = "hard/thrown_at_muscle",
             .effects = "muscle_contact",
             .asks_backend = false,
             .run = thrown_at_muscle},
    HardCase{.id = "thrown-at-itself",
             .what = "One wall of a channel is bound, the other flies towards it at 1, 10 and 100 m/s, with steps of "
                     "1 ms.",
             .why = "Self-contact sees what moves by less than its thickness in a step.",
             .bar = "no triangle through its own muscle, or a status that says so",
             .scene = "hard/thrown_at_itself",
             .effects = "self_contact attachment",
             .run = thrown_at_itself},
    HardCase{.id = "press-shut",
             .what = "Two bones press a channel of muscle shut, in 30 frames, in 2, and in four steps.",
             .why = "Folds that close are met at any speed, and nothing but self-contact holds them (review 7).",
             .bar = "no triangle through its own muscle, or through a bone by more than 0.1 mm",
             .scene = "hard/press_shut",
             .left_out_because = depth_says_it,
             .effects = "self_contact contact volume edge_length",
             .run = press_shut},
    HardCase{.id = "momentum",
             .what = "Two balls of muscle collide off centre at 1 m/s, and two shaken ones fly apart, without damping: "
                     "60 steps of 0.5 ms (1000 in the long run).",
             .why = "A correction that is not equal and opposite, or off the line between two nodes, makes momentum.",
             .bar = "linear and angular momentum within 1e-9 of their size; the kinetic energy of the collision never "
                    "grows",
             .scene = "hard/thrown_at_muscle",
             .effects = "muscle_contact",
             .asks_backend = false,
             .run = momentum},
};

}  // namespace

std::span<const HardCase> muscle_load_cases() { return cases_of_loaded_muscles; }

}  // namespace musclebench

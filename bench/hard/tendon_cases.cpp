#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/hard/loaded_scene.hpp"
#include "bench/hard/run_figures.hpp"

// Muscles that pull, and tendons that slide.
namespace musclebench {

namespace {

/// The tube of effects/fibre_force at the end: from the middles of slices of 5 mm.
struct TautTube {
  double off_axis_m = 0;  ///< the farthest from the line between its ends
  double uneven_m = 0;    ///< along it, from where an even shortening takes it
};

TautTube taut_tube(const MovedScene& run, double shortened_m) {
  struct Slice {
    Vec3 sum_m = Vec3::Zero();
    int nodes = 0;
  };
  std::map<int, Slice> slices;
  TautTube found;
  const std::vector<Vec3>& rest = run.positions(0);
  const std::vector<Vec3>& end = run.result.snapshots.back().positions;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    auto& [sum_m, nodes] = slices[static_cast<int>(std::lround(rest[i].x() / 0.005))];
    sum_m += end[i];
    ++nodes;
  }
  for (const auto& [slice, of] : slices) {
    const Vec3 middle = of.sum_m / of.nodes;
    found.off_axis_m = std::max(found.off_axis_m, std::hypot(middle.y(), middle.z() - 0.01));
    const double rest_x_m = 0.005 * slice;
    if (std::abs(rest_x_m) > 0.04) continue;  // near the ends bones carry a part of a slice
    const double even_x_m = rest_x_m - shortened_m * (0.5 + rest_x_m / 0.1);
    found.uneven_m = std::max(found.uneven_m, std::abs(middle.x() - even_x_m));
  }
  return found;
}

constexpr double tube_shortening_m = 0.02;

HardCell taut(const HardRequest& request) {
  return watched_runs(request, false, MayRefuse::nobody, [&](RunFigures& figures) {
    const MovedScene run = moved(request, load({"effects/fibre_force"}));
    figures.add_run(run, "",
                    {{"middle of a slice, off the line between the ends, over the diagonal",
                      taut_tube(run, tube_shortening_m).off_axis_m / run.diagonal_m(), 0.005},
                     bound_figure(run)});
  });
}

HardCell full_pull(const HardRequest& request) {
  return watched_runs(request, false, MayRefuse::nobody, [&](RunFigures& figures) {
    const MovedScene run = moved(request, load({"effects/fibre_force",
                                                {{"start_noise_m", 2e-4},
                                                 {"frames", std::int64_t{20}},
                                                 {"rest_frames", std::int64_t{4}},
                                                 {"substeps", std::int64_t{400}},
                                                 {"time_step_s", 5e-5}},
                                                {{"fibre_force", {{"level", 1.0}, {"rise_s", 0.1}}}}}));
    const TautTube tube = taut_tube(run, tube_shortening_m);
    figures.add_run(run, "",
                    {{"middle of a slice, off the line between the ends, over the diagonal",
                      tube.off_axis_m / run.diagonal_m(), 0.005},
                     {"middle of a slice, off where an even shortening takes it, over the diagonal",
                      tube.uneven_m / run.diagonal_m(), 0.01},
                     bound_figure(run)});
  });
}

/// Of the 50 frames in which bones move; then they stand still.
void move_within(BoneMotion& motion, int frames) {
  BoneRotation& rotation = motion.rotations.front();
  rotation.times = {0, frames / 51.0, 1};
  rotation.angles_rad.push_back(rotation.angles_rad.back());
}

void add_held(RunFigures& figures, const MovedScene& run, int frames) {
  figures.add_run(
      run, fmt::format("in {} frames", frames),
      {{"tendon out of its ring, over the radius", run.result.outcome.ring_escape.share, 0.25}, bound_figure(run)},
      {.edge_stretch = 3});  // it is 1.2 times as long, and its end went there within 20 ms
}

HardCell held_tendon(const HardRequest& request) {
  return watched_runs(request, false, MayRefuse::nobody, [&](RunFigures& figures) {
    for (const int frames : {50, 5, 1}) {
      Scene scene = load({"effects/retinaculum"});
      move_within(scene.motions[1], frames);
      add_held(figures, moved(request, std::move(scene)), frames);
    }
  });
}

HardCell moved_ring(const HardRequest& request) {
  return watched_runs(request, false, MayRefuse::nobody, [&](RunFigures& figures) {
    for (const int frames : {50, 5}) {
      Scene scene = load({"effects/retinaculum"});
      std::swap(scene.motions[0], scene.motions[1]);
      move_within(scene.motions[0], frames);
      add_held(figures, moved(request, std::move(scene)), frames);
    }
  });
}

const std::vector<HardCase> cases_of_tendons = {
    HardCase{
        .id = "taut",
        .what =
            "The ends of a muscle come closer by a fifth, and its fibres pull with a twentieth of their peak stress.",
        .why = "A slack muscle folds up where its ends come closer.",
        .bar = "its middle line straight within 0.5 % of the diagonal",
        .scene = "effects/fibre_force",
        .effects = "fibre_force attachment",
        .asks_backend = false,
        .run = taut},
    HardCase{
        .id = "full-pull",
        .what = "The same from nodes displaced by 0.2 mm at random, fully active.",
        .why = "Nothing but their stiffness decides between parts of one fibre that pull alike: some run together.",
        .bar = "its middle line straight within 0.5 % of the diagonal; each slice within 1 % of it where an even "
               "shortening takes it",
        .scene = "effects/fibre_force",
        .effects = "fibre_force attachment",
        .asks_backend = false,
        .run = full_pull},
    HardCase{.id = "held-tendon",
             .what = "A ring holds a tendon down while its end goes up by a third of its length, in 50, 5 and 1 frames "
                     "of 20 ms.",
             .why = "A tendon that leaves its ring bows away, and its moment arm with it.",
             .bar = "out of its ring by at most a quarter of the radius, as in any run",
             .scene = "effects/retinaculum",
             .effects = "retinaculum attachment",
             .asks_backend = false,
             .run = held_tendon},
    HardCase{.id = "moved-ring",
             .what = "The same in 50 and 5 frames, and it is the bone with the ring that goes up.",
             .why = "The ring has to take the tendon along.",
             .bar = "out of its ring by at most a quarter of the radius, as in any run",
             .scene = "effects/retinaculum",
             .effects = "retinaculum attachment",
             .asks_backend = false,
             .run = moved_ring},
};

}  // namespace

std::span<const HardCase> tendon_cases() { return cases_of_tendons; }

}  // namespace musclebench

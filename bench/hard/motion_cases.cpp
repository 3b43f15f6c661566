#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/hard/hard_case.hpp"
#include "bench/hard/moved_scene.hpp"
#include "bench/hard/run_figures.hpp"
#include "bench/hard/sane_figures.hpp"
#include "core/referee/referee.hpp"

// Cases that move a muscle: embedded scenes `hard/...`, run as `musclebench run` does and judged by the Referee.
namespace musclebench {

namespace {

HardCell step_size(const HardRequest& request, bool with_guard) {
  return watched_runs(
      request, true, with_guard ? MayRefuse::approximate : MayRefuse::everybody, [&](RunFigures& figures) {
        SceneChoice choice = scene_of("hard/step_size");
        if (with_guard) choice.effect_overrides.push_back({.location = "step-size", .name = "tunnelling_guard"});
        // 100 mm in so many frames.
        for (const std::int64_t frames : request.whole ? std::vector<std::int64_t>{2, 4, 8, 16, 32, 64, 256, 1024}
                                                       : std::vector<std::int64_t>{4, 16}) {
          choice.loop_overrides["frames"] = frames;
          const MovedScene run = moved(request, choice);
          const std::string words = fmt::format("{:.3g} mm a frame", 100.0 / static_cast<double>(frames));
          if (with_guard) {
            figures.add_run(run, words, {});
          } else {
            figures.add_bare_run(run, words,
                                 {{"nodes on the wrong side of a bone", run.tunnelled_nodes(), 0, "nodes"}});
          }
        }
      });
}

HardCell step_size_guarded(const HardRequest& request) { return step_size(request, true); }
HardCell step_size_unguarded(const HardRequest& request) { return step_size(request, false); }

HardCell initial_overlap(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    for (const int depth_mm : {1, 5}) {
      const MovedScene run = moved(request, scene_of(fmt::format("hard/initial_overlap_{}mm", depth_mm)));
      const double depth_m = 1e-3 * depth_mm;
      const double slack_m = 1e-6 * run.diagonal_m() + declared_m(run, request);
      int risen = 0;
      double before_m = depth_m;  // as the mesh is, before the muscle is laid out of the bone
      for (const StepRecord& record : run.result.records) {
        if (record.depth.max_depth_m > before_m + slack_m) ++risen;
        before_m = record.depth.max_depth_m;
      }
      double fastest_m = 0;
      double farthest_m = 0;
      for (std::size_t frame = 1; frame < run.result.snapshots.size(); ++frame) {
        fastest_m = std::max(fastest_m, run.largest_move_m(frame - 1, frame));
      }
      for (const Snapshot& snapshot : run.result.snapshots) {
        farthest_m = std::max(farthest_m, largest_gap_m(run.scene.muscle_mesh.vertices, snapshot.positions));
      }
      figures.add_run(
          run, fmt::format("{} mm", depth_mm),
          {{"frames in which the depth grows", static_cast<double>(risen), 0, "frames"},
           {"largest move of a node in a frame", 1e3 * fastest_m, 1e3 * (1.05 * depth_m + slack_m), "mm"},
           {"largest move of a node in all", 1e3 * farthest_m, 1e3 * (1.5 * depth_m + slack_m), "mm"},
           {"depth after 10 frames", 1e3 * run.result.records.at(9).depth.max_depth_m, 1e3 * slack_m, "mm"}});
    }
  });
}

HardCell pinch(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = scene_of("hard/pinch");
    if (!request.whole) {
      choice.loop_overrides["frames"] = std::int64_t{90};
      choice.loop_overrides["rest_frames"] = std::int64_t{60};
    }
    const MovedScene run = moved(request, choice);
    const MovedScene other = moved(request, choice, 1, [](Scene& scene) { reverse_bones(scene); });
    if (run.result.status == "diverged") return HardCell{Verdict::breaks, run.said(), {}};
    const std::size_t last = run.result.snapshots.size() - 1;
    const double of_normals_m = 0.01 * declared_m(run, request);
    double jitter_m = 0;
    for (std::size_t frame = last - 9; frame < last; ++frame) jitter_m = std::max(jitter_m, run.jitter_m(frame));
    double order_m = 0;
    for (std::size_t i = 0; i < run.positions(last).size(); ++i) {
      order_m = std::max(order_m, (run.positions(last)[i] - other.positions(last)[i]).norm());
    }
    // Half of the overlap is the least depth that there is.
    const SaneBars bars{.depth_m = 0.5e-3 + 1e-4, .depth_share = 0, .passing = false};
    return judged(with_sane_figures(
                      {{"largest jitter of a node in one of the last 10 frames, in which bones stand still",
                        1e3 * jitter_m, 1e-3 + 1e3 * of_normals_m, "mm"},
                       {"difference by the order of the bones, over the diagonal", order_m / run.diagonal_m(), 1e-6}},
                      run, request, "", bars),
                  request, run.said());
  });
}

/// Whether the backend finds the muscle of `rest`, which touches nothing, once it is 20 mm lower and in the plate.
bool finds_it_in_the_plate(const HardRequest& request, const Scene& scene) {
  const auto backend = request.backend.make(request.parameters());
  std::vector<Vec3> positions = scene.muscle_mesh.vertices;
  std::vector<int> nodes;
  for (Vec3& position : positions) {
    position.z() -= 0.02;
    nodes.push_back(static_cast<int>(nodes.size()));
  }
  std::vector<Contact> found;
  backend->build(scene.bones, scene.muscle_mesh, request.threads);
  backend->update(std::vector<RigidMotion>(scene.bones.size()), positions);
  backend->detect(positions, nodes, found);
  return !found.empty();
}

HardCell rest(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = scene_of("hard/rest");
    if (!request.whole) choice.loop_overrides["frames"] = std::int64_t{100};
    const MovedScene run = moved(request, choice);
    const std::size_t last = run.result.snapshots.size() - 1;
    return judged(
        with_sane_figures(
            {{"largest move of a node, over the diagonal", run.largest_move_m(0, last) / run.diagonal_m(), 1e-9},
             {"contacts in the last frame", static_cast<double>(run.result.records.back().contacts), 0, "contacts"},
             {"muscles pushed into the plate that are not found", finds_it_in_the_plate(request, run.scene) ? 0.0 : 1.0,
              0}},
            run, request),
        request, run.said(), MayRefuse::nobody);
  });
}

HardCell resting_contact(const HardRequest& request) {
  return watched(request, true, [&] {
    const MovedScene run = moved(request, scene_of("hard/resting_contact"));
    const std::size_t last = run.result.snapshots.size() - 1;
    if (run.result.status == "diverged") return HardCell{Verdict::breaks, run.said(), {}};
    constexpr std::size_t settled = 60;
    double later_m = 0;
    for (std::size_t frame = settled + 1; frame <= last; ++frame)
      later_m = std::max(later_m, run.largest_move_m(frame - 1, frame));
    double contactless = 0;
    for (std::size_t frame = settled; frame < last; ++frame) contactless += run.result.records[frame].contacts == 0;
    // The block is 20 mm high and must stay where it lies: it may settle by its own softness.
    return judged(
        with_sane_figures(
            {{"largest move of a node in a frame after settling, over the diagonal", later_m / run.diagonal_m(), 1e-6},
             {"frames after settling in which nothing bears the block", contactless, 0, "frames"}},
            run, request),
        request, run.said());
  });
}

/// How deep the muscle's faces are in bones after any frame, by samples of each triangle, less what the judge says.
double depth_that_is_not_said_m(const MovedScene& run) {
  const Referee referee(run.scene.bones, 1);
  const TriangleMesh& muscle = run.scene.muscle_mesh;
  constexpr int parts = 12;
  double largest_m = 0;
  for (const StepRecord& record : run.result.records) {
    const std::vector<Vec3>& positions = run.positions(static_cast<std::size_t>(record.frame));
    const std::vector<RigidMotion>& poses = run.result.snapshots[static_cast<std::size_t>(record.frame)].bone_poses;
    double deepest_m = 0;
    for (const auto& [a, b, c] : muscle.triangles) {
      for (int i = 0; i <= parts; ++i) {
        for (int j = 0; i + j <= parts; ++j) {
          const Vec3 point = (i * positions[static_cast<std::size_t>(a)] + j * positions[static_cast<std::size_t>(b)] +
                              (parts - i - j) * positions[static_cast<std::size_t>(c)]) /
                             parts;
          for (std::size_t bone = 0; bone < poses.size(); ++bone) {
            const Vec3 at_rest = poses[bone].apply_inverse(point);
            deepest_m = std::max(deepest_m, -referee.signed_distance(static_cast<int>(bone), at_rest));
          }
        }
      }
    }
    largest_m = std::max(largest_m, deepest_m - std::max(record.surface_depth_m, record.bone_vertex_depth_m));
  }
  return largest_m;
}

HardCell face_over_edge(const HardRequest& request) {
  return watched(request, true, [&] {
    const MovedScene run = moved(request, scene_of("hard/face_over_edge"));
    if (!run.result.outcome.bone_crossings) return HardCell{Verdict::breaks, "no frame was tested for crossings", {}};
    if (*run.result.outcome.bone_crossings == 0) {
      return not_applicable("holds the ball off the ridge, so that no face is cut");
    }
    const double node_depth_m = run.result.outcome.max_depth_m.value_or(std::nan(""));
    return judged({{"depth of a face that the surface depth does not say", 1e3 * depth_that_is_not_said_m(run),
                    1e3 * 1e-3 * run.diagonal_m(), "mm"},
                   {"largest depth of a node", 1e3 * node_depth_m,
                    1e3 * (declared_m(run, request) + 1e-3 * run.diagonal_m()), "mm"}},
                  request, run.said());
  });
}

HardCell swallowed(const HardRequest& request) {
  return watched(request, false, [&] {
    const MovedScene in_bone = moved(request, scene_of("hard/swallowed"));
    const MovedScene about_bone = moved(request, scene_of("hard/bone_in_muscle"));
    const MovedScene inverted = moved(request, scene_of("hard/step_size"), 1, [](Scene& scene) {
      for (Triangle& triangle : scene.muscle_mesh.triangles) std::swap(triangle[0], triangle[1]);
    });
    const auto ends_ok = [](const MovedScene& run) { return run.said().empty() ? 1.0 : 0.0; };
    return judged({{"runs of a muscle in a bone that end with the status ok", ends_ok(in_bone), 0},
                   {"runs of a bone in a muscle that do", ends_ok(about_bone), 0},
                   {"runs of a muscle that is inside out that do", ends_ok(inverted), 0}},
                  request, in_bone.said(), MayRefuse::nobody);
  });
}

HardCell attached_inside(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = scene_of("hard/attached_inside");
    if (!request.whole) choice.loop_overrides["frames"] = std::int64_t{40};
    const MovedScene run = moved(request, choice);
    double drift_m = 0;
    for (const Snapshot& snapshot : run.result.snapshots) {
      for (const BoundNode& bound : run.result.bound_nodes) {
        const auto node = static_cast<std::size_t>(bound.node);
        const Vec3 in_place =
            snapshot.bone_poses[static_cast<std::size_t>(bound.bone)].apply(run.scene.muscle_mesh.vertices[node]);
        drift_m = std::max(drift_m, (snapshot.positions[node] - in_place).norm());
      }
    }
    const SaneBars bars{.depth_m = std::numeric_limits<double>::infinity(), .status = false};
    return judged(
        with_sane_figures(
            {{"largest drift of an attached node in its bone, over the diagonal", drift_m / run.diagonal_m(), 1e-12},
             {"attached nodes that there are none of", run.result.bound_nodes.size() > 5 ? 0.0 : 1.0, 0}},
            run, request, "", bars),
        request, "", MayRefuse::nobody);
  });
}

constexpr std::array sharp_pairs = {"spike_on_spike", "spike_on_wedge",     "wedge_on_wedge", "spike_in_crack",
                                    "wedge_in_crack", "sliding_spike",      "sliding_wedge",  "over_hole",
                                    "on_cliff",       "over_internal_edges"};

HardCell sharp_pairs_of_erleben(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    for (const char* pair : sharp_pairs)
      figures.add_run(moved(request, scene_of(fmt::format("hard/{}", pair))), pair, {});
  });
}

HardCell same_state_for_threads(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = scene_of("hard/step_size");
    const MovedScene alone = moved(request, choice, 1);
    const MovedScene together = moved(request, choice, 2);
    const MovedScene again = moved(request, choice, 1);
    const bool is_same = alone.result.state_hash == together.result.state_hash;
    const bool is_repeated = alone.result.state_hash == again.result.state_hash;
    return judged({{"runs on two threads that end in other bits", is_same ? 0.0 : 1.0, 0},
                   {"repetitions that end in other bits", is_repeated ? 0.0 : 1.0, 0},
                   without_contact(alone.result.records)},
                  request, "", MayRefuse::nobody);
  });
}

constexpr std::array cases_of_motion = {
    HardCase{.id = "step-size",
             .what = "A plate of 4 mm sweeps a ball along, 6 and 25 mm a frame (0.1 to 50 in the long run), with the "
                     "tunnelling guard.",
             .why = "A node that passes a bone within one step is found on the wrong side and pushed out there (paper, "
                    "III-A; rigid-ipc).",
             .bar = "the sane figures, of which no node is on the wrong side",
             .scene = "hard/step_size",
             .run = step_size_guarded},
    HardCase{
        .id = "step-size-unguarded",
        .what = "The same without the guard.",
        .why = "The same; here the program has to notice.",
        .bar = "no node on the wrong side, or a status that says so",
        .scene = "hard/step_size",
        .left_out_because = "without the guard nodes pass through, and all that is asked is that the status says so",
        .run = step_size_unguarded},
    HardCase{.id = "initial-overlap",
             .what = "A ball starts 1 mm and 5 mm deep in a plate; loop.settle_substeps lays it out before the first "
                     "frame.",
             .why = "All of the depth is undone in the first step, and the step makes it a velocity: the muscle pops "
                    "out (paper, III-B).",
             .bar = "depth never grows, no node moves by more than 1.05 depths a frame and, from where the mesh has "
                    "it, 1.5 in all, out within 10 frames (grids: to their declared bound); the sane figures",
             .scene = "hard/initial_overlap_5mm",
             .run = initial_overlap},
    HardCase{
        .id = "pinch",
        .what = "Two round bones close on the middle of a slab until they overlap by 1 mm, and stand still.",
        .why = "No place is outside of both: pushed out of one, a node is thrown back by the other (paper, Fig. "
               "4).",
        .bar =
            "no node is thrown to and fro by more than 1e-3 mm (grids: a hundredth of their declared bound more, as "
            "normals jump between cells); the same within 1e-6 diagonals for any order of bones; of the sane figures "
            "the depth is at most half of the overlap and 0.1 mm",
        .scene = "hard/pinch",
        .left_out_because = "between bones that overlap every triangle passes through one of them",
        .run = pinch},
    HardCase{.id = "rest",
             .what = "Nothing moves, for 1000 frames (100 in the short run).",
             .why = "A force out of nothing adds up.",
             .bar = "drift within 1e-9 of the diagonal, no contact there and one once the muscle is pushed into the "
                    "plate, the sane figures",
             .scene = "hard/rest",
             .run = rest},
    HardCase{.id = "resting-contact",
             .what = "A soft block with its weight lies on a plate, and nothing else moves.",
             .why =
                 "Its nodes are on the surface to the bit: within a grid's error they are inside, and what is pushed "
                 "out falls back.",
             .bar = "after 60 frames no node moves by more than 1e-6 diagonals a frame, and the plate bears the block; "
                    "the sane figures",
             .scene = "hard/resting_contact",
             .run = resting_contact},
    HardCase{.id = "face-over-edge",
             .what = "A coarse ball lies with its faces on a sharp ridge; only nodes are pushed out.",
             .why = "No node is inside, and a depth of nodes says that all is well (Macklin 2020).",
             .bar = "the surface depth says how deep the faces are cut, to 1e-3 diagonals of samples of each face",
             .scene = "hard/face_over_edge",
             .left_out_because = "the faces are cut on purpose, and the depth has to be told",
             .run = face_over_edge},
    HardCase{.id = "swallowed",
             .what = "A muscle wholly inside a bone, a bone wholly inside a muscle, a muscle that is inside out.",
             .why = "A backend that collides surfaces finds nothing, and a depth of 0 looks fine: the judge has to see "
                    "it by itself.",
             .bar = "the status names it",
             .scene = "hard/swallowed",
             .left_out_because = "nothing in it can be right, and all that is asked is that the status says so",
             .asks_backend = false,
             .run = swallowed},
    HardCase{.id = "attached-inside",
             .what = "A ball whose foot is 5 mm deep in the plate that it is attached to; the plate turns.",
             .why =
                 "Attached nodes overlap their bone in every anatomy. Pushed out they tear, counted as contacts they "
                 "spoil every statistic of depth.",
             .bar = "no drift in the bone's frame beyond 1e-12 of the diagonal, the sane figures",
             .scene = "hard/attached_inside",
             .left_out_because =
                 "the bone's vertices are in the muscle's foot on purpose, which is no depth to judge and no "
                 "reason for a status",
             .run = attached_inside},
    HardCase{
        .id = "erleben-ten",
        .what = "Ten pairs of a soft muscle on a hard bone, with the tunnelling guard: spike on spike, spike and "
                "wedge on wedge, spike and wedge in a crack, sliding spike and wedge, over a hole, on a cliff, over "
                "internal edges.",
        .why = "At sharp tips and edges the closest point jumps from side to side, and so does the way out (Erleben "
               "2018; the test set of IPC).",
        .bar = "no node through the bone, no triangle through the bone or its own muscle, the surface at most 0.1 mm "
               "or 1 % of "
               "the diagonal deep (grids: their declared bound more), the longest edge twice that at rest, volume "
               "within 5 %, status ok",
        .scene = "hard/spike_on_spike",
        .run = sharp_pairs_of_erleben},
    HardCase{.id = "determinism",
             .what = "The same run on one thread, on two, and again.",
             .why = "The loop amplifies rounding to millimetres: only the same bits can be compared.",
             .bar = "the same bits at the end",
             .scene = "hard/step_size",
             .left_out_because = "bits are compared, of runs that are judged in step-size-unguarded",
             .run = same_state_for_threads},
};

}  // namespace

std::span<const HardCase> motion_cases() { return cases_of_motion; }

}  // namespace musclebench

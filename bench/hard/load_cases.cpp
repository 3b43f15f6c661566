#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/hard/courses.hpp"
#include "bench/hard/loaded_scene.hpp"
#include "bench/hard/run_figures.hpp"

// Contact with bones under a load: weight, friction, speed, sharp bones, bound neighbours, a margin.
namespace musclebench {

namespace {

constexpr double gravity_m_per_s2 = 9.80665;

/// Of the inclines: they fall by 3 in 4.
constexpr double incline_sine = 0.6;
constexpr double incline_cosine = 0.8;
constexpr double critical_coefficient = incline_sine / incline_cosine;

void append(HardFigures& figures, const HardFigures& more) { figures.insert(figures.end(), more.begin(), more.end()); }

/// Acceleration of a block on the incline: m a = m g sin - coefficient m g cos (Coulomb).
double coulomb_m_per_s2(double coefficient) {
  return gravity_m_per_s2 * std::max(0.0, incline_sine - coefficient * incline_cosine);
}

/// The mean of the run, down the incline, from the paths of its first half and of all of it: the speed that a block
/// has kept since it settled under its weight, and was not yet borne whole, is not in it.
double acceleration_m_per_s2(const MovedScene& run) {
  const Body& block = run.scene.muscles.front().body;
  const std::size_t last = run.result.snapshots.size() - 1;
  const auto path_m = [&](std::size_t frame) {
    return (middle_of(run.positions(frame), block) - middle_of(run.positions(0), block))
        .dot(Vec3(incline_cosine, 0, -incline_sine));
  };
  const double half_s = frame_s(run.scene) * static_cast<double>(last / 2);
  return (path_m(last / 2 * 2) - 2 * path_m(last / 2)) / (half_s * half_s);
}

HardCell incline(const HardRequest& request, const std::string& name) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    const std::vector<double> coefficients = request.whole
                                                 ? std::vector<double>{0, 0.25, 0.5, 0.7, critical_coefficient, 0.8, 2}
                                                 : std::vector<double>{0.5, critical_coefficient, 1};
    for (const double coefficient : coefficients) {
      const bool is_held = coefficient > critical_coefficient;
      LoadedScene scene{name, {}, {{"friction", {{"coefficient", coefficient}}}}};
      // An elastic block that nothing damps goes on vibrating, and with it its nodes.
      if (is_held) scene.effects["damping"] = {{"rate_per_s", 200.0}};
      const MovedScene run = moved_in_time(request, load(scene), static_cast<int>(coefficients.size()));
      if (figures.add_if_diverged(run, fmt::format("coefficient {:g}", coefficient))) continue;
      const double expected = coulomb_m_per_s2(coefficient);
      const bool slides = coefficient < critical_coefficient;
      std::vector<HardFigure> of_run{
          {slides ? "acceleration down the incline, off Coulomb's by a share of it"
                  : "acceleration down the incline, over that without friction",
           std::abs(acceleration_m_per_s2(run) - expected) / (slides ? expected : coulomb_m_per_s2(0)), 0.01}};
      if (is_held) {
        of_run.push_back({"creep of a node in a late frame, over the diagonal", late_move(run, 5), 1e-6});
        append(of_run, late_force_figures(run, 5, {incline_cosine, incline_sine}));
      }
      figures.add_tight_run(run, fmt::format("coefficient {:g}", coefficient), std::move(of_run));
    }
  });
}

HardCell incline_on_nodes(const HardRequest& request) { return incline(request, "hard/incline_nodes"); }
HardCell incline_on_faces(const HardRequest& request) { return incline(request, "hard/incline_faces"); }
HardCell incline_on_edges(const HardRequest& request) { return incline(request, "hard/incline_edges"); }

HardCell loaded_rest(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    for (const char* place : {"plate", "two_plates", "bowl", "groove"}) {
      LoadedScene scene{fmt::format("hard/loaded_{}", place)};
      if (request.whole) scene.loop["frames"] = std::int64_t{1000};
      const MovedScene run = moved_in_time(request, load(scene));
      if (figures.add_if_diverged(run, place)) continue;
      HardFigures of_run{
          {"move of a node in a late frame, over the diagonal", late_move(run, 5), 1e-6},
          {"last frames in which no node is borne", run.result.records.back().contacts > 0 ? 0.0 : 1.0, 0}};
      append(of_run, late_force_figures(run, 5));
      figures.add_tight_run(run, place, std::move(of_run));
    }
  });
}

/// The run of a scene whose two bones are one and the same, against that with the second far away.
HardCell twice_and_once(const HardRequest& request, const std::function<Scene()>& load_both) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    const MovedScene twice = moved_in_time(request, load_both(), 2);
    Scene scene = load_both();
    place_bone(scene, 1, Vec3(0, 0, -0.2));
    const MovedScene once = moved_in_time(request, std::move(scene), 2);
    if (figures.add_if_diverged(twice, "") || figures.add_if_diverged(once, "one plate")) return;
    double gap_m = 0;
    for (std::size_t frame = 0; frame < once.result.snapshots.size(); ++frame) {
      gap_m = std::max(gap_m, largest_gap_m(once.positions(frame), twice.positions(frame)));
    }
    figures.add_run(
        twice, "",
        {{"difference of a node from the run with one plate, over the diagonal", gap_m / once.diagonal_m(), 1e-6},
         without_contact(twice.result.records)});
  });
}

HardCell overlapping_bones(const HardRequest& request) {
  return twice_and_once(request, [] { return load({"hard/overlapping_bones"}); });
}

HardCell lifted_by_two_bones(const HardRequest& request) {
  return twice_and_once(request, [] {
    Scene scene = load({"hard/overlapping_bones"});
    scene.muscles.front().velocity_m_per_s = Vec3::Zero();
    for (const std::size_t plate : {0U, 1U}) move_straight(scene, plate, {Vec3::UnitZ(), {0, 1}, {0, 0.04}});
    return scene;
  });
}

/// A block that flies into a sharp bone: 20 mm, or as far as a step of 10 m/s takes it in 20 frames.
HardCell onto_sharp_bone(const HardRequest& request, const std::string& name) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    for (const auto& [speed_m_per_s, substeps] : {std::pair(0.1, 40), {1.0, 4}, {10.0, 1}}) {
      Scene scene = load({name, {{"substeps", std::int64_t{substeps}}}});
      scene.muscles.front().velocity_m_per_s = Vec3(0, 0, -speed_m_per_s);
      const MovedScene run = moved_in_time(request, std::move(scene), 3);
      if (figures.add_if_diverged(run, fmt::format("{:g} m/s", speed_m_per_s))) continue;
      figures.add_tight_run(run, fmt::format("{:g} m/s", speed_m_per_s), {});
    }
  });
}

HardCell needle(const HardRequest& request) { return onto_sharp_bone(request, "hard/onto_needle"); }
HardCell steep_ridge(const HardRequest& request) { return onto_sharp_bone(request, "hard/onto_ridge"); }

HardCell poked_border(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    constexpr double cell_m = 0.04 / 6;  // of the block, between the bound nodes and the first free ones
    constexpr std::size_t ball = 1;
    for (const double weight : {1.0, 0.1, 0.01}) {
      Scene scene = load({"hard/poked_border"});
      place_bone(scene, ball, Vec3(weight * cell_m, 0, 0));
      const MovedScene run = moved_in_time(request, std::move(scene), 3);
      if (figures.add_if_diverged(run, fmt::format("free corners with weight {:g}", weight))) continue;
      const Outcome& outcome = run.result.outcome;
      std::vector<HardFigure> of_run{
          {"longest edge over its length at rest", outcome.max_edge_stretch.value_or(std::nan("")), 1.5},
          {"volume error", outcome.max_volume_error.value_or(std::nan("")), 0.01},
          {"nodes on the wrong side of a bone", run.tunnelled_nodes(), 0, "nodes"},
          {"triangles through the muscle itself",
           static_cast<double>(passing_triangles(run, declared_missed_m(run, request)).itself), 0, "triangles"}};
      // Only where all corners are free can the muscle give way.
      if (weight == 1) {
        of_run.push_back({"depth of the surface in bones", 1e3 * outcome.max_surface_depth_m.value_or(std::nan("")),
                          0.1 + 1e3 * declared_missed_m(run, request), "mm"});
      }
      figures.add_bare_run(run, fmt::format("free corners with weight {:g}", weight), std::move(of_run));
    }
  });
}

/// Kinetic energy of a frame, by the moves of its nodes, J.
double energy_of_frame_j(const MovedScene& run, std::size_t frame) {
  const std::vector<double> masses_kg = node_masses_kg(run.scene);
  double energy_j = 0;
  for (std::size_t node = 0; node < masses_kg.size(); ++node) {
    const double speed = (run.positions(frame)[node] - run.positions(frame - 1)[node]).norm() / frame_s(run.scene);
    energy_j += 0.5 * masses_kg[node] * speed * speed;
  }
  return energy_j;
}

/// Of a node, after frame 10.
double depth_in_skin_m(const MovedScene& run) {
  constexpr double thickness_m = 0.003;  // on a plate whose top is at z = 0
  double least_z_m = thickness_m;
  for (const Vec3& position : run.positions(10)) least_z_m = std::min(least_z_m, position.z());
  return thickness_m - least_z_m;
}
double depth_in_bone_m(const MovedScene& run) { return run.result.records.at(9).depth.max_depth_m; }
double depth_in_muscle_m(const MovedScene& run) {
  const std::optional<DepthStatistics>& depths = run.result.records.at(9).in_muscles;
  return depths ? depths->max_depth_m : std::nan("");
}

HardCell margin_start(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    const auto add = [&](const char* words, const LoadedScene& loaded, double overlap_m,
                         double (*depth_m)(const MovedScene&)) {
      const MovedScene run = moved_in_time(request, load(loaded), 3);
      if (figures.add_if_diverged(run, words)) return;
      double mass_kg = 0;
      for (const double node_kg : node_masses_kg(run.scene)) mass_kg += node_kg;
      // Nothing moves without the overlap. A rest may move by 1e-6 diagonals a frame.
      const double rest_m_per_s = 1e-6 * run.diagonal_m() / frame_s(run.scene);
      const double rest_j = 0.5 * mass_kg * rest_m_per_s * rest_m_per_s;
      double farthest_m = 0;
      for (std::size_t frame = 1; frame < run.result.snapshots.size(); ++frame) {
        farthest_m = std::max(farthest_m, run.largest_move_m(0, frame));
      }
      figures.add_run(run, words,
                      {{"kinetic energy in frame 10", energy_of_frame_j(run, 10), rest_j, "J"},
                       {"largest move of a node, over the overlap", farthest_m / overlap_m, 1.5},
                       {"depth of a node in it after frame 10", 1e3 * depth_m(run),
                        1e3 * (1e-6 * run.diagonal_m() + declared_m(run, request)), "mm"}},
                      {.depth_m = std::numeric_limits<double>::infinity(), .passing = false, .status = false});
    };
    add("in the margin", {"hard/inside_margin"}, 0.0025, depth_in_skin_m);
    add("in a bone",
        {"hard/initial_overlap_1mm",
         {{"settle_substeps", std::int64_t{0}}, {"substeps", std::int64_t{16}}, {"frames", std::int64_t{12}}},
         {{"damping", {{"rate_per_s", 50.0}}}}},
        0.001, depth_in_bone_m);
    add("in a muscle", {"hard/inside_muscle"}, 0.002, depth_in_muscle_m);
  });
}

HardCell margin_at_speed(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    constexpr double thickness_m = 0.002;
    for (const double speed_m_per_s : {1.0, 10.0}) {
      Scene scene = load({"hard/thrown_at_margin"});
      scene.muscles.front().velocity_m_per_s = Vec3(0, 0, -speed_m_per_s);
      const MovedScene run = moved_in_time(request, std::move(scene), 2);
      if (figures.add_if_diverged(run, fmt::format("{:g} m/s", speed_m_per_s))) continue;
      double deepest_m = 0;
      double most_j = 0;
      for (std::size_t frame = 1; frame < run.result.snapshots.size(); ++frame) {
        for (const Vec3& position : run.positions(frame)) {
          if (!(thickness_m - position.z() <= deepest_m)) deepest_m = thickness_m - position.z();
        }
        most_j = std::max(most_j, energy_of_frame_j(run, frame));
      }
      double at_start_j = 0;
      for (const double mass_kg : node_masses_kg(run.scene))
        at_start_j += 0.5 * mass_kg * speed_m_per_s * speed_m_per_s;
      figures.add_tight_run(
          run, fmt::format("{:g} m/s", speed_m_per_s),
          {{"deepest node in the margin", 1e3 * deepest_m, 1e3 * 1e-6 * run.diagonal_m(), "mm"},
           {"largest kinetic energy of a frame over that at the start", most_j / at_start_j, 1 + 1e-9}});
    }
  });
}

HardCell thrown_at_bone(const HardRequest& request) {
  return watched_runs(request, true, MayRefuse::everybody, [&](RunFigures& figures) {
    for (const double thickness_mm : {10.0, 1.0}) {
      for (const double speed_m_per_s : {1.0, 10.0, 100.0}) {
        Scene scene = load({"hard/thrown_at_bone"});
        place_bone(scene, 0, Vec3::Zero(), Vec3(1, 1, thickness_mm / 10));
        scene.muscles.front().velocity_m_per_s = Vec3(0, 0, -speed_m_per_s);
        const MovedScene run = moved_in_time(request, std::move(scene), 6);
        if (figures.add_if_diverged(run, fmt::format("{:g} mm thick, {:g} m/s", thickness_mm, speed_m_per_s))) continue;
        figures.add_run(run, fmt::format("{:g} mm thick, {:g} m/s", thickness_mm, speed_m_per_s),
                        {{"tunnelled nodes", run.tunnelled_nodes(), 0, "nodes"}});
      }
    }
  });
}

HardCell turned_fast(const HardRequest& request) {
  return watched_runs(request, true, MayRefuse::everybody, [&](RunFigures& figures) {
    const MovedScene run = moved_in_time(request, load({"hard/turned_fast"}));
    figures.add_run(run, "", {});
  });
}

constexpr std::array cases_of_loads = {
    HardCase{.id = "incline-nodes",
             .what =
                 "A block lies with its nodes on an incline that falls by 3 in 4, with friction below, at and above "
                 "what holds it.",
             .why = "Friction that is not Coulomb's slides too far, or lets a block that rests creep.",
             .bar = "acceleration within 1 % of g (sin - coefficient cos). Held by more than it needs, and damped: no "
                    "node moves by more than 1e-6 diagonals a frame; normal force and friction within 1 % of m g cos "
                    "and m g sin. Surface within 0.1 mm",
             .scene = "hard/incline_nodes",
             .left_out_because = depth_says_it,
             .effects = "friction gravity contact edge_length",
             .run = incline_on_nodes},
    HardCase{.id = "incline-faces",
             .what = "The same block on two rails that run between its rows of nodes, so that only faces touch.",
             .why = "Friction that acts at nodes alone does nothing here.",
             .bar = "as incline-nodes",
             .scene = "hard/incline_faces",
             .left_out_because = depth_says_it,
             .effects = "surface_contact friction edge_length",
             .run = incline_on_faces},
    HardCase{.id = "incline-edges",
             .what = "A block stands with two sharp edges across two sharp ridges of the incline, between nodes.",
             .why = "An edge meets an edge: neither nodes nor the corners of the bone are in contact.",
             .bar = "as incline-nodes",
             .scene = "hard/incline_edges",
             .left_out_because = depth_says_it,
             .effects = "surface_contact friction edge_length",
             .run = incline_on_edges},
    HardCase{.id = "loaded-rest",
             .what = "A soft block or ball lies under its weight on a plate, on two plates (apart, and overlapping), "
                     "in a bowl, in the groove of "
                     "two bones: 50 frames of 20 ms (1000 in the long run).",
             .why = "Weight pushes nodes into bones in every step, and each push may throw them.",
             .bar =
                 "no node moves by more than 1e-6 diagonals in a late frame; the forces of bones are the weight within "
                 "1 %; surface within 0.1 mm",
             .scene = "hard/loaded_two_plates",
             .left_out_because = depth_says_it,
             .effects = "gravity contact damping bending friction",
             .run = loaded_rest},
    HardCase{.id = "overlapping-bones",
             .what = "A ball falls at 1 m/s on a plate that is there twice, and on that plate alone.",
             .why = "The pushes of bones that overlap add up to twice the way out (paper, Fig. 4).",
             .bar = "the same shapes within 1e-6 diagonals",
             .scene = "hard/overlapping_bones",
             .effects = "multi_bone contact",
             .run = overlapping_bones},
    HardCase{.id = "lifted-by-two-bones",
             .what = "The plate that is there twice lifts the ball at 0.5 m/s, and so does that plate alone.",
             .why = "Pushed twice as far as the plate goes, the ball is thrown ahead of it.",
             .bar = "the same shapes within 1e-6 diagonals",
             .scene = "hard/overlapping_bones",
             .effects = "multi_bone contact",
             .run = lifted_by_two_bones},
    HardCase{.id = "needle",
             .what = "A block flies with a face onto a needle 1 mm square, at 0.1, 1 and 10 m/s.",
             .why = "The needle meets no node, and a depth of nodes says that all is well (review 4).",
             .bar = "surface within 0.1 mm of the bone",
             .scene = "hard/onto_needle",
             .left_out_because = depth_says_it,
             .effects = "surface_contact volume",
             .run = needle},
    HardCase{.id = "ridge",
             .what = "A block flies with its faces onto a ridge of 60 degrees, at 0.1, 1 and 10 m/s.",
             .why = "Edges of the muscle meet the edge of the ridge between nodes (review 5).",
             .bar = "surface within 0.1 mm of the bone",
             .scene = "hard/onto_ridge",
             .left_out_because = depth_says_it,
             .effects = "surface_contact contact volume",
             .run = steep_ridge},
    HardCase{.id = "border",
             .what = "Half of a block is bound. A ball of bone goes 3 mm down into the faces next to the bound nodes, "
                     "whose free corners have the weight 1, 0.1 and 0.01.",
             .why = "A face with one free corner of weight w moves it by gap / w to leave a bone (review 15).",
             .bar = "no edge beyond 1.5 times its length, volume within 1 %, nothing tunnelled or folded through "
                    "itself",
             .scene = "hard/poked_border",
             .left_out_because =
                 "the ball goes where bound nodes hold the muscle: no shape is free of it, and how deep it "
                 "is there is no fault of contact where corners are bound",
             .effects = "surface_contact volume edge_length",
             .run = poked_border},
    HardCase{.id = "margin-start",
             .what = "A ball begins 2.5 mm deep in a margin of 3 mm, 1 mm deep in a bone, 2 mm deep in another muscle.",
             .why = "What undoes an overlap in one step makes a velocity of it (review 9).",
             .bar = "after 10 frames the kinetic energy is that without overlap, none (1e-6 diagonals a frame); no "
                    "node moves by more than 1.5 overlaps",
             .scene = "hard/inside_margin",
             .left_out_because = "it begins in a bone, in a muscle: passing triangles, depth and status say that, too",
             .effects = "margin contact muscle_contact",
             .run = margin_start},
    HardCase{.id = "margin-at-speed",
             .what = "A ball flies at 1 and 10 m/s into a margin of 2 mm, with steps of 1 ms.",
             .why = "A step is as long as the margin is thick, or five times that.",
             .bar = "no node in the margin after a frame; the kinetic energy never grows; surface within 0.1 mm",
             .scene = "hard/thrown_at_margin",
             .left_out_because = depth_says_it,
             .effects = "margin contact tunnelling_guard",
             .run = margin_at_speed},
    HardCase{.id = "thrown-at-bone",
             .what = "A ball flies at 1, 10 and 100 m/s into plates of 10 and 1 mm, with steps of 1 ms.",
             .why = "At 100 m/s a step is ten times as long as the thick plate.",
             .bar = "no node and no triangle through the plate, or a status that says so",
             .scene = "hard/thrown_at_bone",
             .effects = "tunnelling_guard contact",
             .run = thrown_at_bone},
    HardCase{.id = "turned-fast",
             .what = "A paddle of 8 mm that turns by 30 degrees a frame hits a ball.",
             .why = "In one step the bone moves by more than twice its thickness where the ball is (rigid-ipc).",
             .bar = "no node and no triangle through the paddle, or a status that says so",
             .scene = "hard/turned_fast",
             .effects = "tunnelling_guard contact",
             .run = turned_fast},
};

}  // namespace

std::span<const HardCase> load_cases() { return cases_of_loads; }

}  // namespace musclebench

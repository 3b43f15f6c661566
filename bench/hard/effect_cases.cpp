#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/hard/courses.hpp"
#include "bench/hard/loaded_scene.hpp"
#include "bench/hard/run_figures.hpp"
#include "core/effects/local_volume/local_volume.hpp"

// Effects under load, against the formula of each or a run that moves slowly.
namespace musclebench {

namespace {

constexpr double standard_gravity_m_per_s2 = 9.80665;

/// Where f, which falls from `low` to `high`, is 0.
double root_between(double low, double high, const std::function<double(double)>& f) {
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (f(middle) > 0 ? low : high) = middle;
  }
  return low;
}

/// Of the tetrahedron's edges to its apex, and of its apex.
constexpr double apex_edge_m = 0.03;
constexpr double apex_mass_kg = 0.1;
constexpr double edge_compliance_m_per_n = 1e-3;

/// How far the apex hangs below its place at rest: 3 k (L0 - L) z / L = m g, with k softened by (1 - cos)^exponent of
/// an edge's angle to the fibre, which is vertical.
double apex_sag_m(double exponent) {
  const double height_m = apex_edge_m * std::sqrt(2.0 / 3);
  const double foot2 = apex_edge_m * apex_edge_m - height_m * height_m;
  const double stiffness = std::pow(1 - std::sqrt(2.0 / 3), exponent) / edge_compliance_m_per_n;
  return root_between(0, height_m, [&](double sag_m) {
    const double z_m = height_m - sag_m;
    const double length_m = std::sqrt(foot2 + z_m * z_m);
    return apex_mass_kg * standard_gravity_m_per_s2 - 3 * stiffness * (apex_edge_m - length_m) * z_m / length_m;
  });
}

/// The fibre through the apex.
void add_vertical_fibre(Scene& scene) { scene.muscles.front().fibres = {{Vec3(0, 0, 0), Vec3(0, 0, 0.03)}}; }

/// The angle of a flap under its weight at its tip: m g l cos(angle) compliance = angle.
double flap_angle_rad() {
  constexpr double lever_m = 0.03;
  constexpr double mass_kg = 0.1;
  constexpr double compliance_rad_per_n_m = 2;
  return root_between(0, 1, [&](double angle_rad) {
    return mass_kg * standard_gravity_m_per_s2 * lever_m * std::cos(angle_rad) * compliance_rad_per_n_m - angle_rad;
  });
}

HardCell sag(const HardRequest& request) {
  return watched_runs(request, false, MayRefuse::nobody, [&](RunFigures& figures) {
    for (const double time_step_s : {1e-4, 1e-3, 1e-2}) {
      constexpr double passed_s = 3;
      constexpr std::int64_t frames = 10;
      const auto hung = [&](const std::string& name, double exponent) {
        LoadedScene loaded{name,
                           {{"time_step_s", time_step_s},
                            {"frames", frames},
                            {"substeps", std::int64_t(std::round(passed_s / (frames * time_step_s)))}},
                           {{"damping", {{"rate_per_s", 5.0}}}}};
        if (name == "effects/edge_length") loaded.effects["edge_length"] = {{"anisotropy_exponent", exponent}};
        Scene scene = load(loaded);
        if (exponent > 0) add_vertical_fibre(scene);
        return moved(request, std::move(scene));
      };
      const auto add = [&](const char* words, const MovedScene& run, double value, double formula) {
        figures.add_bare_run(run, fmt::format("{}, steps of {:g} ms", words, 1e3 * time_step_s),
                             {{"off its formula by a share", std::abs(value / formula - 1), 0.01}});
      };
      for (const double exponent : {0.0, 0.5}) {
        const MovedScene run = hung("effects/edge_length", exponent);
        add(exponent == 0  ? "apex on three edges"
            : exponent < 1 ? "the same along a fibre"
                           : "the same, exponent 2",
            run, run.positions(0)[3].z() - run.result.snapshots.back().positions[3].z(), apex_sag_m(exponent));
      }
      const MovedScene flap = hung("effects/bending", 0);
      const Vec3& tip = flap.result.snapshots.back().positions[3];
      add("flap on a hinge", flap, std::atan2(-tip.z(), tip.x()), flap_angle_rad());
    }
  });
}

HardCell damped_fall(const HardRequest& request) {
  return watched_runs(request, false, MayRefuse::nobody, [&](RunFigures& figures) {
    constexpr double rate_per_s = 100;
    constexpr double passed_s = 0.1;
    for (const double time_step_s : {1e-4, 1e-3, 5e-3}) {
      const MovedScene run =
          moved(request, load({"effects/damping",
                               {{"time_step_s", time_step_s},
                                {"frames", std::int64_t{10}},
                                {"substeps", std::int64_t(std::round(passed_s / (10 * time_step_s)))}}}));
      const Body& ball = run.scene.muscles.front().body;
      const double fallen_m =
          middle_of(run.positions(0), ball).z() - middle_of(run.result.snapshots.back().positions, ball).z();
      // dv/dt = g - rate v, from rest.
      const double formula_m =
          standard_gravity_m_per_s2 / rate_per_s * (passed_s - (1 - std::exp(-rate_per_s * passed_s)) / rate_per_s);
      figures.add_bare_run(
          run, fmt::format("steps of {:g} ms", 1e3 * time_step_s),
          {{"path of the fall, off its formula by a share", std::abs(fallen_m / formula_m - 1), 0.01}});
    }
  });
}

HardCell pressed_spring(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    Scene scene = load({"hard/pressed_spring"});
    add_vertical_fibre(scene);
    const MovedScene run = moved_in_time(request, std::move(scene));
    if (figures.add_if_diverged(run, "")) return;
    const std::size_t last = run.result.snapshots.size() - 1;
    const double sag_m = apex_sag_m(0.5);
    double least_z_m = 1;
    for (const Snapshot& shape : run.result.snapshots) least_z_m = std::min(least_z_m, shape.positions[3].z());
    const double pressed_m = run.positions(0)[3].z() - least_z_m;
    const Outcome& outcome = run.result.outcome;
    figures.add_bare_run(
        run, "",
        {{"sag of the apex at the end, off its formula by a share",
          std::abs((run.positions(0)[3].z() - run.positions(last)[3].z()) / sag_m - 1), 0.01},
         {"runs in which the bone does not press the apex by 4 mm", pressed_m >= 0.004 ? 0.0 : 1.0, 0},
         {"depth of the surface in bones", 1e3 * outcome.max_surface_depth_m.value_or(std::nan("")), 0.1, "mm"},
         {"longest edge over its length at rest", outcome.max_edge_stretch.value_or(std::nan("")), 1.1}});
  });
}

/// Volume of the triangles of the bands up to `band`, closed by a fan about the mean of the nodes along the cut, as
/// local_volume closes it; m3.
double volume_up_to(const TriangleMesh& mesh, const std::vector<int>& bands, int band,
                    const std::vector<Vec3>& positions) {
  const auto at = [&](int node) { return positions[static_cast<std::size_t>(node)]; };
  double six_volume = 0;
  std::map<std::pair<int, int>, int> open;  // directed edges less those against them
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (bands[t] > band) continue;
    const auto& [a, b, c] = mesh.triangles[t];
    six_volume += at(a).dot(at(b).cross(at(c)));
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
      if (open.erase({to, from}) == 0) open[{from, to}] = 1;
    }
  }
  Vec3 mean = Vec3::Zero();
  for (const auto& [edge, count] : open) mean += at(edge.first);
  if (!open.empty()) mean /= static_cast<double>(open.size());
  for (const auto& [edge, count] : open) six_volume += mean.dot(at(edge.second).cross(at(edge.first)));
  return six_volume / 6;
}

/// The largest share by which a region's volume is off that at rest, after any frame.
double largest_region_error(const MovedScene& run, int regions) {
  const TriangleMesh& mesh = run.scene.muscle_mesh;
  const std::vector<int> bands = bands_along_bodies(mesh, run.scene.bodies(), regions);
  const auto volumes = [&](const std::vector<Vec3>& positions) {
    std::vector<double> of_regions;
    double below_m3 = 0;
    for (int band = 0; band < regions; ++band) {
      const double all_m3 = volume_up_to(mesh, bands, band, positions);
      of_regions.push_back(all_m3 - below_m3);
      below_m3 = all_m3;
    }
    return of_regions;
  };
  const std::vector<double> at_rest = volumes(run.positions(0));
  double largest = 0;
  for (std::size_t frame = 1; frame < run.result.snapshots.size(); ++frame) {
    const std::vector<double> now = volumes(run.positions(frame));
    for (std::size_t region = 0; region < now.size(); ++region) {
      const double error = std::abs(now[region] / at_rest[region] - 1);
      if (!(error <= largest)) largest = error;
    }
  }
  return largest;
}

HardFigure volume_figure(const MovedScene& run) {
  return {"volume error of the muscle", run.result.outcome.max_volume_error.value_or(std::nan("")), 0.01};
}

constexpr int regions_of_tubes = 8;

HardFigure region_figure(const MovedScene& run) {
  return {"volume error of a region", largest_region_error(run, regions_of_tubes), 0.01};
}

HardCell squeeze(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    Scene scene = load({"hard/squeezed_in_turn"});
    constexpr double displacement_m = 0.0105;  // half a millimetre before it touches
    const Vec3 down = -Vec3::UnitZ();
    move_straight(scene, 1, {down, {0, 0.25, 0.5, 1}, {0, displacement_m, 0, 0}});
    move_straight(scene, 2, {down, {0, 0.5, 0.75, 1}, {0, 0, displacement_m, 0}});
    const MovedScene run = moved_in_time(request, std::move(scene));
    figures.add_tight_run(run, "", {region_figure(run), volume_figure(run), bound_figure(run)});
  });
}

/// Mean distance of the nodes within 10 mm of the middle from the tube's axis.
double radius_in_the_middle_m(const std::vector<Vec3>& positions, double middle_x_m) {
  double sum_m = 0;
  int count = 0;
  for (const Vec3& position : positions) {
    if (std::abs(position.x() - middle_x_m) > 0.01) continue;
    sum_m += std::hypot(position.y(), position.z() - 0.01);
    ++count;
  }
  return sum_m / count;
}

HardCell isometric_and_shortening(const HardRequest& request) {
  return watched_runs(request, false, MayRefuse::nobody, [&](RunFigures& figures) {
    const MovedScene isometric = moved(request, load({"hard/isometric"}));
    figures.add_run(isometric, "isometric",
                    {region_figure(isometric), volume_figure(isometric), bound_figure(isometric)});
    // One end comes nearer by as much as the fibres between them shorten.
    Scene scene = load({"hard/isometric"});
    constexpr double shortening = 0.2;
    constexpr double displacement_m = shortening * 0.1;
    move_straight(scene, 1, {-Vec3::UnitX(), {0, 0.7, 1}, {0, displacement_m, displacement_m}});
    scene.loop.interpolate_poses = true;
    const MovedScene run = moved(request, std::move(scene));
    const double radius = radius_in_the_middle_m(run.result.snapshots.back().positions, -0.5 * displacement_m) /
                          radius_in_the_middle_m(run.positions(0), 0);
    figures.add_run(run, "shortening",
                    {{"radius in the middle, off 1 / sqrt(1 - shortening) by a share",
                      std::abs(radius * std::sqrt(1 - shortening) - 1), 0.01},
                     region_figure(run),
                     volume_figure(run),
                     bound_figure(run)});
  });
}

HardCell activation_stop(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    const MovedScene run = moved_in_time(request, load({"hard/shortening_stop"}));
    double widest_m = 0;
    for (const Vec3& position : run.result.snapshots.back().positions) {
      widest_m = std::max(widest_m, std::abs(position.y()));
    }
    figures.add_tight_run(run, "",
                          {region_figure(run),
                           volume_figure(run),
                           bound_figure(run),
                           // 1 / sqrt(1 - 0.36) times as thick it meets the plates, 1.12 times its radius away.
                           {"runs in which the muscle does not bulge to 11.5 mm", widest_m >= 0.0115 ? 0.0 : 1.0, 0}});
  });
}

HardCell refinement(const HardRequest& request) {
  return watched_runs(request, true, [&](RunFigures& figures) {
    std::vector<MovedScene> runs;
    const int most = request.whole ? 2 : 1;
    for (int times = 0; times <= most; ++times) {
      runs.push_back(moved_in_time(
          request, load({.name = "hard/pressed_tube", .meshes = {{"split_muscles", std::int64_t{times}}}}), most + 1));
      figures.add_tight_run(runs.back(), fmt::format("{} triangles", runs.back().scene.muscle_mesh.triangles.size()),
                            {});
    }
    // Vertices come first in the refined mesh.
    const auto gap_m = [&](int one, int other) {
      const std::vector<Vec3>& coarse = runs[static_cast<std::size_t>(one)].result.snapshots.back().positions;
      std::vector<Vec3> fine = runs[static_cast<std::size_t>(other)].result.snapshots.back().positions;
      fine.resize(coarse.size());
      return largest_gap_m(coarse, fine);
    };
    figures.add({"largest difference of a node from that of 4 times the triangles, over the diagonal",
                 gap_m(0, 1) / runs[0].diagonal_m(), 0.01});
    if (most > 1) {
      figures.add({"the same from 4 to 16 times the triangles, over that before", gap_m(1, 2) / gap_m(0, 1), 1});
    }
  });
}

HardCell jump(const HardRequest& request) {
  return watched_runs(request, true, MayRefuse::everybody, [&](RunFigures& figures) {
    constexpr std::size_t rod = 2;
    const auto add = [&](const std::string& words, const MovedScene& run, const MovedScene& slow) {
      figures.add_tight_run(
          run, words,
          {{"difference of a node from the slow run at the end, over the diagonal",
            largest_gap_m(run.result.snapshots.back().positions, slow.result.snapshots.back().positions) /
                run.diagonal_m(),
            1e-3}});
    };
    for (const double displacement_m : {1e-4, 1e-3, 1e-2}) {
      // Half a millimetre to the muscle, 1 mm in it, and then the jump.
      const auto run_with = [&](double jumps_at) {
        Scene scene = load({"hard/pressed_tube"});
        move_straight(scene, rod,
                      {-Vec3::UnitZ(),
                       {0, 0.2, jumps_at, 0.6, 1},
                       {0, 0.0015, 0.0015, 0.0015 + displacement_m, 0.0015 + displacement_m}});
        return moved_in_time(request, std::move(scene), 9);
      };
      // Between two substeps, or within 8 of 20 frames.
      add(fmt::format("jump of {:g} mm", 1e3 * displacement_m), run_with(0.6 - 1e-9), run_with(0.2 + 1e-9));
    }
    const MovedScene usual = moved_in_time(request, load({"hard/pressed_tube"}), 9);
    for (const double factor : {10.0, 100.0}) {
      Scene scene = load({"hard/pressed_tube"});
      scene.loop.time_step_changes = {{16, factor * scene.loop.time_step_s}};
      add(fmt::format("steps {:g} times as long from frame 16 on", factor), moved_in_time(request, std::move(scene), 9),
          usual);
    }
  });
}

constexpr std::array cases_of_effects = {
    HardCase{.id = "sag",
             .what = "An apex hangs on three compliant edges, with and without a fibre along its fall; a flap hangs on "
                     "a compliant hinge. Steps of 0.1, 1 and 10 ms.",
             .why = "A compliance in N/m is one for any time step, or it is a knob (XPBD).",
             .bar = "sag and angle within 1 % of their formulas",
             .scene = "effects/edge_length",
             .left_out_because = "few nodes that touch nothing, held to formulas of their places",
             .effects = "edge_length fibre_anisotropy bending gravity attachment",
             .asks_backend = false,
             .run = sag},
    HardCase{.id = "damped-fall",
             .what = "A ball falls through a viscous medium, with steps of 0.1, 1 and 5 ms.",
             .why = "Damping that is applied a step too early or late errs by rate times step (review 11).",
             .bar = "path within 1 % of the formula",
             .scene = "effects/damping",
             .left_out_because = "a fall without contact, held to the formula of its path",
             .effects = "damping gravity",
             .asks_backend = false,
             .run = damped_fall},
    HardCase{.id = "pressed-spring",
             .what = "A bone presses the apex of a tetrahedron 4 mm down against compliant edges and a fibre, and "
                     "leaves it.",
             .why = "A contact that leaves speed or a strain behind shows in where a spring comes to rest.",
             .bar = "sag of the apex within 1 % of its formula; surface within 0.1 mm",
             .scene = "hard/pressed_spring",
             .left_out_because = "four nodes, whose volume nothing keeps",
             .effects = "edge_length fibre_anisotropy contact attachment gravity damping",
             .run = pressed_spring},
    HardCase{.id = "squeeze",
             .what = "Two rods press one end of a tube by 10 mm and then the other, with local_volume in 8 regions.",
             .why = "Volume that is kept as a whole flows from end to end.",
             .bar = "each region and the muscle within 1 % of its volume",
             .scene = "hard/squeezed_in_turn",
             .left_out_because = depth_says_it,
             .effects = "local_volume contact attachment",
             .run = squeeze},
    HardCase{
        .id = "isometric",
        .what =
            "A muscle contracts by a fifth between two bones that stand still, and again while one of them follows.",
        .why = "The pull of the fibres and the volume work against each other (review 11: 3.9 % lost).",
        .bar = "each region and the muscle within 1 % of its volume; where it shortens it becomes 1 / sqrt(1 - "
               "shortening) times as thick, within 1 %",
        .scene = "hard/isometric",
        .effects = "activation local_volume attachment",
        .asks_backend = false,
        .run = isometric_and_shortening},
    HardCase{.id = "activation-stop",
             .what = "A muscle shortens by 36 % between two bones and bulges against two plates.",
             .why = "Activation, volume and contact each move the same nodes.",
             .bar = "each region and the muscle within 1 % of its volume; surface within 0.1 mm",
             .scene = "hard/shortening_stop",
             .left_out_because = depth_says_it,
             .effects = "activation local_volume contact attachment",
             .run = activation_stop},
    HardCase{.id = "refinement",
             .what = "A rod presses a tube, whose mesh has 1, 4 (and in the long run 16) times the triangles.",
             .why = "A compliance per edge makes another muscle of a finer mesh (review 11).",
             .bar = "shape within 1 % of the diagonal, and by less with each refinement",
             .scene = "hard/pressed_tube",
             .left_out_because = depth_says_it,
             .effects = "contact edge_length volume",
             .run = refinement},
    HardCase{.id = "jump",
             .what = "A rod that presses a tube jumps by 0.1, 1 and 10 mm from one step to the next; steps "
                     "become 10 and 100 times as long.",
             .why = "A jump is a blow, and a longer step another one.",
             .bar = "shape at the end within 1e-3 diagonals of that of a slow run, or a status that says so",
             .scene = "hard/pressed_tube",
             .left_out_because = depth_says_it,
             .effects = "contact damping edge_length",
             .run = jump},
};

}  // namespace

std::span<const HardCase> effect_cases() { return cases_of_effects; }

}  // namespace musclebench

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "bench/cases/verification.hpp"
#include "bench/hard/asked_bone.hpp"
#include "bench/hard/hard_case.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh_repair/repair_mesh.hpp"
#include "core/scene/check/bone_thickness.hpp"
#include "datasets/hard/hard_shapes.hpp"

// Cases that ask a backend about points: its answers are held against formulas, or against the Referee.
namespace musclebench {

namespace {

constexpr std::int64_t usual_points = 4000;
constexpr std::uint64_t points_seed = 20;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

std::vector<TriangleMesh> usual_shapes() {
  return {make_bumpy_ball(4), make_spike(), make_box({0.02, 0.03, 0.025}, 4), make_plate(0.004)};
}

double diagonal_m(const TriangleMesh& mesh) { return bounding_box(mesh.vertices).diagonal().norm(); }

HardCell exact_distance(const HardRequest& request) {
  if (!request.backend.exact || !request.backend.signed_distance) {
    return not_applicable("its answers are approximate: the case `soundness` holds them against what it declares");
  }
  double largest_share = 0;
  int wrong_signs = 0;
  for (const TriangleMesh& mesh : usual_shapes()) {
    const Bone bone{"bone", repair_mesh(mesh, "bone")};
    const SignedDistance distance = request.backend.signed_distance(bone, request.threads);
    const std::vector<Vec3> points = points_about(bone.surface.mesh, usual_points, points_seed);
    const std::vector<double> truth_m = true_distances(mesh, points);
    const double agreed_m = agreed_share * diagonal_m(mesh);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double own_m = distance(points[i]);
      largest_share = std::max(largest_share, std::abs(std::abs(own_m) - std::abs(truth_m[i])) / diagonal_m(mesh));
      if (std::abs(truth_m[i]) > agreed_m && (own_m < 0) != (truth_m[i] < 0)) ++wrong_signs;
    }
  }
  return judged({{"largest difference of the distance, over the diagonal", largest_share, 1e-12},
                 {"wrong signs", static_cast<double>(wrong_signs), 0, "points"}},
                request, "", MayRefuse::nobody);
}

HardCell soundness(const HardRequest& request) {
  return about_points(request, [&] {
    WrongAnswers all;
    for (const TriangleMesh& mesh : usual_shapes()) {
      const std::vector<Vec3> points = points_about(mesh, usual_points, points_seed);
      AskedBone asked(request, mesh, points.size());
      const WrongAnswers wrong =
          wrong_answers(true_distances(mesh, points), asked.contacts(points), asked, 1e-12 * asked.diagonal_m());
      all.missed += wrong.missed;
      all.invented += wrong.invented;
    }
    return judged({{"inner points missed beyond its declared bound", static_cast<double>(all.missed), 0, "points"},
                   {"outer points found beyond it", static_cast<double>(all.invented), 0, "points"}},
                  request);
  });
}

/// The edge of a cell over a bone of `longest_m` where the backend counts cells along its box; else of 64.
double usual_cell_m(const HardRequest& request, double longest_m) {
  for (const ParameterSpec& spec : request.backend.parameters) {
    if (spec.role == ParameterRole::resolution && spec.name == "cells") {
      return longest_m / static_cast<double>(request.parameters().integer("cells"));
    }
  }
  return longest_m / 64;
}

/// What `check` says of such a bone; empty for nothing.
std::string said_of_thin(const TriangleMesh& mesh, double cell_m) {
  const Bone bone{"bone", repair_mesh(mesh, "hard case")};
  const ThinShare thin = share_thinner_than(2 * cell_m, sample_thickness(bone, bounding_box(mesh.vertices)));
  return thin.share > 0 ? fmt::format(
                              "feature_thinner_than_cell: {:.0f} % of the surface is thinner than two cells, "
                              "down to {:.2g} mm",
                              100 * thin.share, 1e3 * thin.thinnest_m)
                        : "";
}

HardCell thin_plate(const HardRequest& request) {
  return about_points(request, [&] {
    constexpr double edge_m = 0.1;
    std::vector<HardFigure> figures;
    std::string said;
    bool is_silent = false;
    for (const double cells : {4.0, 2.0, 1.0, 0.5, 0.25}) {
      const double cell_m = usual_cell_m(request, edge_m);
      const TriangleMesh mesh = make_winged_block(cells * cell_m);
      std::vector<Vec3> points;
      for (int i = 0; i < 4000; ++i) {  // the middle of the wing, at places that no grid has
        points.emplace_back(0.0123 + 0.1 * cells * cell_m * std::sin(i),
                            0.98 * edge_m * (std::fmod(0.5 + i * 0.618033988749895, 1.0) - 0.5),
                            0.03 + 0.06 * (i + 0.5) / 4000);
      }
      AskedBone asked(request, mesh, points.size());
      const double missed = static_cast<double>(points.size() - asked.contacts(points).size());
      figures.push_back({fmt::format("missed in the middle of a wing of {:g} cells", cells),
                         missed / static_cast<double>(points.size()), 0});
      if (missed == 0) continue;
      const std::string of_this = said_of_thin(mesh, cell_m);
      is_silent = is_silent || of_this.empty();
      if (said.empty()) said = of_this;
    }
    return judged(std::move(figures), request, is_silent ? "" : said);
  });
}

HardCell small_hole(const HardRequest& request) {
  return about_points(request, [&] {
    std::vector<std::map<std::string, ParameterValue>> resolutions = {{}};
    if (find_parameter(request.backend.parameters, "cells") != nullptr) {
      resolutions.clear();
      for (const std::int64_t cells :
           request.whole ? std::vector<std::int64_t>{16, 32, 64, 128, 256} : std::vector<std::int64_t>{16, 64}) {
        resolutions.push_back({{"cells", cells}});
      }
    }
    std::vector<Vec3> places = {Vec3(0.3, -0.2, 0.9)};
    if (request.whole) places.insert(places.end(), {Vec3(1, 0, 0), Vec3(-0.6, 0.7, 0.4)});
    const TriangleMesh ball = make_sphere(0.025, 4);
    double worst_missed = 0;
    double worst_wrong = 0;
    for (const int triangles : {1, 10}) {
      for (const Vec3& place : places) {
        const TriangleMesh mesh = with_hole(ball, triangles, place);
        const std::vector<Vec3> points = points_about(mesh, usual_points, points_seed);
        const std::vector<double> truth_m = true_distances(mesh, points);
        for (const auto& resolution : resolutions) {
          AskedBone asked(request, mesh, points.size(), resolution);
          const WrongAnswers wrong = wrong_answers(truth_m, asked.contacts(points), asked, 1e-12 * asked.diagonal_m());
          worst_missed = std::max(worst_missed, static_cast<double>(wrong.missed) / std::max(1, wrong.inside));
          worst_wrong = std::max(worst_wrong, static_cast<double>(wrong.invented) / static_cast<double>(points.size()));
        }
      }
    }
    return judged({{"share of inner points missed beyond its declared bound", worst_missed, 0},
                   {"share of points found beyond it", worst_wrong, 1e-3}},
                  request);
  });
}

HardCell far_from_origin(const HardRequest& request) {
  return about_points(request, [&] {
    const TriangleMesh mesh = make_bumpy_ball(3);
    const std::vector<Vec3> points = points_about(mesh, usual_points, points_seed);
    const std::vector<double> truth_m = true_distances(mesh, points);
    AskedBone here(request, mesh, points.size());
    const std::vector<double> here_m = here.depths(points);
    std::vector<HardFigure> figures{missed_figure(truth_m, here.contacts(points), here)};
    for (const double offset_m : {1.0, 1e3, 1e6}) {
      const Vec3 offset = offset_m * Vec3(1, -0.5, 0.25);
      const double rounding_m = 64 * epsilon * offset.norm() + here.bound().storage_m;
      std::vector<Vec3> moved;
      for (const Vec3& point : points) moved.emplace_back(point + offset);
      AskedBone there(request, shifted(mesh, offset), points.size());
      const std::vector<double> there_m = there.depths(moved);
      double largest_m = 0;
      int changed = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        if ((here_m[i] > 0) == (there_m[i] > 0)) {
          largest_m = std::max(largest_m, std::abs(here_m[i] - there_m[i]));
        } else if (std::abs(truth_m[i]) > here.bound().missed_depth_m + here.bound().false_distance_m + rounding_m) {
          ++changed;
        }
      }
      figures.push_back(
          {fmt::format("largest change of a depth {:g} m from the origin", offset_m), largest_m, rounding_m, "m"});
      figures.push_back({fmt::format("points found here and not {:g} m from the origin, or the other way", offset_m),
                         static_cast<double>(changed), 0, "points"});
    }
    return judged(std::move(figures), request);
  });
}

HardCell scale(const HardRequest& request) {
  return about_points(request, [&] {
    const TriangleMesh mesh = make_bumpy_ball(3);
    const std::vector<Vec3> points = points_about(mesh, usual_points, points_seed);
    AskedBone usual(request, mesh, points.size());
    const std::vector<double> usual_m = usual.depths(points);
    int changed_bits = 0;
    double largest_relative = 0;
    for (const double factor : {1024.0, 1.0 / 1024, 1000.0}) {
      std::vector<Vec3> larger;
      for (const Vec3& point : points) larger.emplace_back(factor * point);
      AskedBone asked(request, scaled(mesh, factor), points.size());
      const std::vector<double> depths_m = asked.depths(larger);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double expected_m = usual.tells_depth() ? factor * usual_m[i] : usual_m[i];
        if (factor != 1000.0) {
          if (depths_m[i] != expected_m) ++changed_bits;
        } else {
          const double unit_m = usual.tells_depth() ? factor * usual.diagonal_m() : 1;
          largest_relative = std::max(largest_relative, std::abs(depths_m[i] - expected_m) / unit_m);
        }
      }
    }
    return judged(
        {{"answers with other bits at 1024 and 1/1024 of the size", static_cast<double>(changed_bits), 0, "points"},
         {"largest change in mm for m, over the diagonal", largest_relative,
          1e-9 + usual.bound().storage_m / usual.diagonal_m()},
         missed_figure(true_distances(mesh, points), usual.contacts(points), usual)},
        request);
  });
}

HardCell rigid_motion(const HardRequest& request) {
  return about_points(request, [&] {
    const TriangleMesh mesh = make_bumpy_ball(3);
    const std::vector<Vec3> points = points_about(mesh, usual_points, points_seed);
    const std::vector<double> truth_m = true_distances(mesh, points);
    AskedBone asked(request, mesh, points.size());
    const std::vector<double> still_m = asked.depths(points);
    const double slack_m = 1e-9 * asked.diagonal_m();
    double largest_share = 0;
    int changed = 0;
    for (int i = 1; i <= 5; ++i) {
      const RigidMotion pose =
          RigidMotion::about_axis(Vec3(std::sin(i), std::cos(3 * i), std::sin(5 * i + 1)).normalized(),
                                  Vec3(0.1 * i, -0.02, 0.3), 1.7 * i) *
          RigidMotion{Mat3::Identity(), Vec3(0.5, -0.7 * i, 1.1)};
      const std::vector<double> moved_m = asked.depths(points, pose);
      for (std::size_t k = 0; k < points.size(); ++k) {
        if ((still_m[k] > 0) == (moved_m[k] > 0)) {
          largest_share = std::max(largest_share, std::abs(still_m[k] - moved_m[k]) / asked.diagonal_m());
        } else if (std::abs(truth_m[k]) > asked.bound().missed_depth_m + asked.bound().false_distance_m + slack_m) {
          ++changed;
        }
      }
    }
    return judged({{"largest change of a depth, over the diagonal", largest_share, 1e-9},
                   {"points found in one place and not in the other", static_cast<double>(changed), 0, "points"},
                   missed_figure(truth_m, asked.contacts(points), asked)},
                  request);
  });
}

HardCell on_features(const HardRequest& request) {
  return about_points(request, [&] {
    double largest_error = 0;
    int not_finite = 0;
    double missed = 0;
    for (const TriangleMesh& mesh : {make_box({0.02, 0.03, 0.025}, 2), make_sphere(0.025, 2), make_spike()}) {
      std::vector<Vec3> points = {Vec3::Zero()};
      for (const Vec3& vertex : mesh.vertices) {
        for (const double share : {1.0, 1 - 1e-15, 1 - 1e-12, 1 - 1e-9, 1 - 1e-6, 0.5})
          points.push_back(share * vertex);
      }
      for (const Triangle& triangle : mesh.triangles) {
        const Vec3 middle = 0.5 * (mesh.vertices[static_cast<std::size_t>(triangle[0])] +
                                   mesh.vertices[static_cast<std::size_t>(triangle[1])]);
        for (const double share : {1.0, 1 - 1e-15, 1 - 1e-9, 0.5}) points.push_back(share * middle);
      }
      AskedBone asked(request, mesh, points.size());
      if (!asked.tells_depth()) return not_applicable("tells no normals");
      const std::vector<Contact> contacts = asked.contacts(points);
      missed += missed_figure(true_distances(mesh, points), contacts, asked).value;
      for (const Contact& contact : contacts) {
        const double error = std::abs(contact.normal.norm() - 1);
        if (!std::isfinite(error) || !std::isfinite(contact.depth_m) || contact.depth_m < 0) ++not_finite;
        largest_error = std::max(largest_error, error);
      }
    }
    return judged(
        {{"largest error of a normal's length", largest_error, 1e-12},
         {"depths and normals that are no numbers, or negative", static_cast<double>(not_finite), 0, "points"},
         {"inner points missed beyond its declared bound", missed, 0, "points"}},
        request, "", MayRefuse::nobody);
  });
}

HardCell domain_border(const HardRequest& request) {
  return about_points(request, [&] {
    const TriangleMesh mesh = make_box({0.02, 0.03, 0.025}, 4);
    std::vector<Vec3> points;
    constexpr int steps = 4000;
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0.3, 0.9, -0.2), Vec3(-0.5, -0.4, 0.7)}) {
      for (int i = 0; i < steps; ++i) points.push_back(i * 1e-4 * direction);  // to 0.4 m
      for (const double far_m : {1.0, 1e3, 1e6, 1e12, 1e100}) points.push_back(far_m * direction);
    }
    AskedBone asked(request, mesh, points.size());
    const std::vector<double> depths_m = asked.depths(points);
    std::vector<double> starts_m;
    double largest_jump_m = 0;
    int outside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 beyond = points[i].cwiseAbs() - Vec3(0.02, 0.03, 0.025);
      const double distance_m = beyond.cwiseMax(0).norm();
      if (points[i].isZero()) starts_m.push_back(depths_m[i]);
      if (depths_m[i] > 0 && distance_m > asked.bound().false_distance_m + 1e-12) ++outside;
      if (i + 1 < points.size() && distance_m < 0.3 && asked.tells_depth() &&
          (points[i + 1] - points[i]).norm() < 2e-4) {
        largest_jump_m =
            std::max(largest_jump_m, std::abs(depths_m[i + 1] - depths_m[i]) - (points[i + 1] - points[i]).norm());
      }
    }
    const double cell_m = request.backend.exact ? 0 : usual_cell_m(request, 0.06);
    return judged({{"contacts outside beyond its declared bound", static_cast<double>(outside), 0, "points"},
                   {"largest jump of the depth between neighbours, more than they are apart", largest_jump_m,
                    cell_m + 1e-12, "m"},
                   {"rays whose start, in the middle of the box, is not found",
                    static_cast<double>(std::ranges::count(starts_m, 0.0)), 0, "rays"}},
                  request);
  });
}

HardCell near_touching(const HardRequest& request) {
  return about_points(request, [&] {
    const Vec3 half(0.02, 0.03, 0.025);
    const TriangleMesh mesh = make_box(half, 3);
    std::vector<Vec3> points;
    std::vector<double> truth_m;
    for (const double share : {1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9}) {
      for (const double sign : {-1.0, 1.0}) {
        for (int i = 0; i < 100; ++i) {
          const double gap_m = sign * share * diagonal_m(mesh);
          points.emplace_back(0.019 * std::sin(i), 0.029 * std::sin(3 * i + 1), half.z() + gap_m);
          truth_m.push_back(points.back().z() - half.z());
        }
      }
    }
    AskedBone asked(request, mesh, points.size());
    const WrongAnswers wrong =
        wrong_answers(truth_m, asked.contacts(points), asked, (1e-12 + 1e-15) * asked.diagonal_m());
    return judged({{"inner points missed beyond its declared bound", static_cast<double>(wrong.missed), 0, "points"},
                   {"outer points found beyond it", static_cast<double>(wrong.invented), 0, "points"}},
                  request, "", MayRefuse::nobody);
  });
}

bool counts_cells(const HardRequest& request) {
  const ParameterSpec* cells = find_parameter(request.backend.parameters, "cells");
  return cells != nullptr && cells->role == ParameterRole::resolution;
}

/// Largest error of a depth at `points` with each number of cells.
std::vector<double> depth_errors_m(const HardRequest& request, const TriangleMesh& mesh, std::span<const Vec3> points,
                                   std::span<const double> truth_m, std::span<const std::int64_t> cells) {
  std::vector<double> errors_m;
  for (const std::int64_t count : cells) {
    AskedBone asked(request, mesh, points.size(), {{"cells", count}});
    const std::vector<double> depths_m = asked.depths(points);
    double largest_m = 0;
    for (std::size_t i = 0; i < points.size(); ++i) largest_m = std::max(largest_m, std::abs(depths_m[i] + truth_m[i]));
    errors_m.push_back(largest_m);
  }
  return errors_m;
}

/// Points on rays from the centre, `from` to `to` of the way to the surface in each direction.
std::vector<Vec3> points_within(double from, double to, const std::function<double(const Vec3&)>& reach_m) {
  std::vector<Vec3> points;
  constexpr int count = 3000;
  for (int i = 0; i < count; ++i) {  // directions on a spiral from pole to pole
    const double z = 1 - (2 * i + 1.0) / count;
    const double angle = 2.399963229728653 * i;
    const double radius = std::sqrt(1 - z * z);
    const Vec3 direction(radius * std::cos(angle), radius * std::sin(angle), z);
    points.emplace_back((from + (to - from) * (i % 97) / 96.0) * reach_m(direction) * direction);
  }
  return points;
}

HardCell order_smooth(const HardRequest& request) {
  return about_points(request, [&] {
    if (!counts_cells(request)) return not_applicable("has no cells to halve");
    constexpr double radius_m = 0.025;
    const TriangleMesh ball = make_sphere(radius_m, 7);  // its facets lie 2.6e-7 m below the sphere
    const std::vector<Vec3> points = points_within(0.5, 0.95, [](const Vec3&) { return radius_m; });
    const std::vector<double> truth_m = true_distances(ball, points);
    if (!AskedBone(request, ball, 1).tells_depth()) return not_applicable("tells no depths");
    const std::vector<std::int64_t> cells = {4, 8, 16};
    const std::vector<double> errors_m = depth_errors_m(request, ball, points, truth_m, cells);
    // The distance to facets is itself not smooth, by about as much as they lie below the sphere.
    constexpr double facets_m = 5e-7;
    std::vector<HardFigure> figures;
    for (std::size_t i = 1; i < cells.size(); ++i) {
      figures.push_back(
          {fmt::format("largest error with {} cells, over an eighth of that with {}", cells[i], cells[i - 1]),
           errors_m[i] < facets_m ? 0 : 8 * errors_m[i] / errors_m[i - 1], 1});
    }
    return judged(std::move(figures), request, "", MayRefuse::nobody);
  });
}

HardCell order_kink(const HardRequest& request) {
  return about_points(request, [&] {
    if (!counts_cells(request)) return not_applicable("has no cells to halve");
    const Vec3 half(0.02, 0.03, 0.025);
    const TriangleMesh box = make_box(half, 4);
    if (!AskedBone(request, box, 1).tells_depth()) return not_applicable("tells no depths");
    const std::vector<Vec3> points = points_within(
        0.05, 0.98, [&](const Vec3& direction) { return half.cwiseQuotient(direction.cwiseAbs()).minCoeff(); });
    const std::vector<double> truth_m = true_distances(box, points);
    const std::vector<std::int64_t> cells = {8, 16, 32, 64};
    const std::vector<double> errors_m = depth_errors_m(request, box, points, truth_m, cells);
    std::vector<HardFigure> figures;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      figures.push_back({fmt::format("largest error with {} cells, in cells", cells[i]),
                         errors_m[i] / (2 * half.maxCoeff() / static_cast<double>(cells[i])), 0.5});
    }
    figures.push_back({"largest error with 64 cells, over that with 8 halved as often as it should be",
                       errors_m.back() / errors_m.front() * std::pow(1.8, 3), 1});
    return judged(std::move(figures), request, "", MayRefuse::nobody);
  });
}

HardCell open_or_crossing(const HardRequest& request) {
  return about_points(request, [&] {
    const TriangleMesh ball = make_bumpy_ball(4);
    TriangleMesh crossing = ball;                                 // two that overlap
    TriangleMesh touching = make_box(Vec3(0.01, 0.01, 0.01), 2);  // two that share an edge
    const auto append = [](TriangleMesh& to, const TriangleMesh& mesh) {
      const int first = static_cast<int>(to.vertices.size());
      to.vertices.insert(to.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
      for (const Triangle& t : mesh.triangles) to.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    };
    append(crossing, shifted(make_sphere(0.015, 3), Vec3(0.02, 0.003, -0.004)));
    append(touching, shifted(make_box(Vec3(0.01, 0.01, 0.01), 2), Vec3(0.02, 0.02, 0)));
    std::vector<HardFigure> figures;
    const auto ask = [&](const TriangleMesh& mesh, const std::string& words) {
      const std::vector<Vec3> points = points_about(mesh, usual_points, points_seed);
      AskedBone asked(request, mesh, points.size());
      const WrongAnswers wrong =
          wrong_answers(true_distances(mesh, points), asked.contacts(points), asked, 1e-12 * asked.diagonal_m());
      figures.push_back({"share of wrong answers beyond the declared bound, " + words,
                         static_cast<double>(wrong.missed + wrong.invented) / static_cast<double>(points.size()),
                         1e-3});
    };
    for (const int triangles : {1, 10, 100}) {
      try {
        ask(with_hole(ball, triangles, Vec3(0.2, 1, 0.1)), fmt::format("{} triangles taken out", triangles));
      } catch (const InputError&) {
        // Refused for all backends, by the reader of bones: the status is that line.
      }
    }
    ask(crossing, "two balls that overlap");
    ask(touching, "two boxes that share an edge");
    return judged(std::move(figures), request);
  });
}

HardCell internal_edge(const HardRequest& request) {
  return about_points(request, [&] {
    const Vec3 half(0.03, 0.03, 0.01);
    std::vector<Vec3> points;
    for (int i = 0; i < 1500; ++i) {  // a path over the whole face, 0.1 mm deep
      points.emplace_back(0.05 * (i / 1500.0 - 0.5), 0.02 * std::sin(0.01 * i), half.z() - 1e-4);
    }
    AskedBone coarse(request, make_box(half, 1), points.size());
    AskedBone fine(request, make_box(half, 64), points.size());
    if (!coarse.tells_depth()) return not_applicable("tells no normals");
    double largest_angle_rad = 0;
    double largest_share = 0;
    double missed = 0;
    for (AskedBone* asked : {&coarse, &fine}) {
      const std::vector<Contact> contacts = asked->contacts(points);
      missed += missed_figure(std::vector<double>(points.size(), -1e-4), contacts, *asked).value;
      for (const Contact& contact : contacts) {
        largest_angle_rad = std::max(largest_angle_rad, contact.normal.cross(Vec3::UnitZ()).norm());
        largest_share = std::max(largest_share, std::abs(contact.depth_m - 1e-4) / asked->diagonal_m());
      }
    }
    const bool is_exact = request.backend.exact;
    return judged({{"largest error of a normal on a plane of 2 and of 8192 triangles", largest_angle_rad,
                    is_exact ? 1e-9 : 1e-3, "rad"},
                   {"largest error of a depth, over the diagonal", largest_share,
                    is_exact ? 1e-9 : coarse.bound().missed_depth_m / coarse.diagonal_m() + 1e-9},
                   {"points on the path missed beyond its declared bound", missed, 0, "points"}},
                  request, "", MayRefuse::nobody);
  });
}

/// The muscle of the next two: its surface cuts the bone, and deforms.
TriangleMesh cutting_ball(int pose) {
  TriangleMesh ball = make_sphere(0.03, 3);
  for (Vec3& vertex : ball.vertices) {
    vertex = vertex * (1 + 0.05 * std::sin(pose + 100 * vertex.x())) + Vec3(0.034 - 0.004 * pose, 0.006, -0.004);
  }
  return ball;
}

std::vector<Contact> contacts_of(CollisionBackend& backend, const TriangleMesh& muscle) {
  std::vector<int> nodes(muscle.vertices.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = static_cast<int>(i);
  std::vector<Contact> found;
  backend.update(std::array{RigidMotion{}}, muscle.vertices);
  backend.detect(muscle.vertices, nodes, found);
  return found;
}

int differences(const std::vector<Contact>& one, const std::vector<Contact>& other) {
  int count = std::abs(static_cast<int>(one.size()) - static_cast<int>(other.size()));
  for (std::size_t i = 0; i < std::min(one.size(), other.size()); ++i) {
    const bool is_same = one[i].node == other[i].node && one[i].bone == other[i].bone &&
                         one[i].depth_m == other[i].depth_m && one[i].normal == other[i].normal;
    if (!is_same) ++count;
  }
  return count;
}

/// A backend over a bumpy ball, with `cutting_ball(0)` for a muscle.
class MovedBackend {
 public:
  MovedBackend(const HardRequest& request, int threads) : m_backend(request.backend.make(request.parameters())) {
    m_bones.push_back({"bone", repair_mesh(make_bumpy_ball(4), "bone")});
    m_backend->build(m_bones, m_muscle, threads);
  }
  CollisionBackend& operator*() { return *m_backend; }

 private:
  std::vector<Bone> m_bones;
  TriangleMesh m_muscle = cutting_ball(0);
  std::unique_ptr<CollisionBackend> m_backend;
};

HardCell stale_structure(const HardRequest& request) {
  if (!request.backend.make(request.parameters())->capabilities().finds_contacts) {
    return not_applicable("finds no contacts");
  }
  MovedBackend followed(request, request.threads);
  int wrong = 0;
  std::size_t compared = 0;
  for (const int pose : {0, 1, 2, 3, 2, 8, 0}) {
    MovedBackend fresh(request, request.threads);
    const std::vector<Contact> expected = contacts_of(*fresh, cutting_ball(pose));
    wrong += differences(contacts_of(*followed, cutting_ball(pose)), expected);
    compared += expected.size();
  }
  return judged({{"contacts other than those of a backend that has seen no other pose", static_cast<double>(wrong), 0,
                  "contacts"},
                 {"comparisons of no contact at all", compared > 0 ? 0.0 : 1.0, 0}},
                request, "", MayRefuse::nobody);
}

HardCell same_for_threads(const HardRequest& request) {
  if (!request.backend.make(request.parameters())->capabilities().finds_contacts) {
    return not_applicable("finds no contacts");
  }
  MovedBackend alone(request, 1);
  MovedBackend together(request, 2);
  int wrong = 0;
  std::size_t compared = 0;
  for (const int pose : {0, 1, 2, 3}) {
    const std::vector<Contact> expected = contacts_of(*alone, cutting_ball(pose));
    wrong += differences(expected, contacts_of(*together, cutting_ball(pose)));
    compared += expected.size();
  }
  return judged({{"contacts with other bits on two threads", static_cast<double>(wrong), 0, "contacts"},
                 {"comparisons of no contact at all", compared > 0 ? 0.0 : 1.0, 0}},
                request, "", MayRefuse::nobody);
}

constexpr std::array cases_of_points = {
    HardCase{.id = "oracle-brute-force",
             .what = "Points about a bumpy ball, a spike, a box and a plate, on their vertices, edges and faces, too.",
             .why = "The truth must be proven before anything is measured by it. TriangleMeshDistance tests to 1e-10.",
             .bar = "distance within 1e-12 of the diagonal of the Referee's, no wrong sign beyond that",
             .scene = "",
             .run = exact_distance},
    HardCase{.id = "soundness",
             .what = "The same points, for every backend that can be asked about points (voxel-soundness).",
             .why = "A backend is conservative within the bound that it declares, or it is useless: voxels may invent "
                    "contacts within a cell of the surface and may miss none.",
             .bar = "no inner point missed and no outer one found beyond the declared bound",
             .scene = "",
             .run = soundness},
    HardCase{.id = "sdf-order-smooth",
             .what = "The inside of a ball, away from its centre, with 4, 8 and 16 cells.",
             .why = "A cubic field is paid for by its order: one that is only linear can be had for less.",
             .bar = "halving the cells cuts the largest error at least eight times",
             .scene = "",
             .run = order_smooth},
    HardCase{.id = "sdf-order-kink",
             .what = "The inside of a box with 8 to 64 cells.",
             .why = "At kinks no polynomial is of more than first order; it has to be honest first order.",
             .bar = "error at most half a cell, and 1.8 times smaller with each halving",
             .scene = "",
             .run = order_kink},
    HardCase{
        .id = "open-nonmanifold",
        .what = "A ball with 1, 10 and 100 triangles taken out, two balls that overlap, two boxes that share an edge.",
        .why = "Scanned bones are open and cross themselves (the pelvis as shipped; Discregrid issues 11, 15).",
        .bar = "at most 0.1 % of the answers wrong beyond the declared bound, or refused",
        .scene = "",
        .run = open_or_crossing},
    HardCase{.id = "thin-plate",
             .what = "A wing 4, 2, 1, 1/2 and 1/4 cells thick that stands on a thick block; points in its middle.",
             .why = "The wing of the ilium is thinner than the cells of a coarse grid, which may not see it at all.",
             .bar = "none missed; grids: or `check` says feature_thinner_than_cell",
             .scene = "",
             .run = thin_plate},
    HardCase{.id = "small-hole",
             .what =
                 "A ball from which 1 and 10 of 5120 triangles are taken out, at one place to the grid or three, 16 to "
                 "256 cells.",
             .why = "Scans have holes. A flood fill runs out of one and takes the whole bone for empty.",
             .bar = "no inner point missed beyond the declared bound, or refused",
             .scene = "",
             .run = small_hole},
    HardCase{.id = "far-from-origin",
             .what = "A bumpy ball and its points 1 m, 1 km and 1000 km from the origin.",
             .why = "Coordinates of a scanner or a motion lab are offset; digits are lost unless all is computed in a "
                    "frame of the bone's own.",
             .bar = "depths change by at most 64 roundings of the offset, and what the backend declares of its storage",
             .scene = "",
             .run = far_from_origin},
    HardCase{.id = "scale",
             .what = "The same ball 1024 times as large and as small, and in millimetres.",
             .why = "Absolute tolerances hide in every code of geometry.",
             .bar = "the same bits; 1e-9 of the diagonal in millimetres, and what the backend declares of its storage",
             .scene = "",
             .run = scale},
    HardCase{.id = "rigid-motion",
             .what = "Bone and points moved together by five rigid motions.",
             .why = "Queries are made in the bone's rest frame; the way there must cost no accuracy.",
             .bar = "depths within 1e-9 of the diagonal, the same contacts",
             .scene = "",
             .run = rigid_motion},
    HardCase{.id = "on-features",
             .what = "Points on edges, vertices and the medial axis, in the centre of a ball, and within rounding of "
                     "all these.",
             .why = "Where the closest point is not unique the gradient vanishes, and a normal is a division by zero.",
             .bar = "every normal has length 1 within 1e-12, every depth is a number and not negative",
             .scene = "",
             .run = on_features},
    HardCase{.id = "domain-border",
             .what = "Points on three rays from inside a box out to 1e100 m.",
             .why = "Outside of its domain a grid has no value: Discregrid answers DBL_MAX there.",
             .bar = "free outside; no jump of the depth by more than a cell",
             .scene = "",
             .run = domain_border},
    HardCase{.id = "near-touching",
             .what = "Points 1e-16 to 1e-9 diagonals in front of a face and behind it.",
             .why = "Collision libraries throw or answer at random there (FCL issue 493).",
             .bar = "the right side beyond 1e-12 of the diagonal and the declared bound",
             .scene = "",
             .run = near_touching},
    HardCase{.id = "internal-edge",
             .what = "A path 0.1 mm under a plane of 2 triangles and of 8192.",
             .why = "Edges inside of a flat face make ghost contacts that throw a sliding node aside (FCL issue 106).",
             .bar = "normal within 1e-9 rad (grids: 1e-3), depth within 1e-9 of the diagonal (grids: declared)",
             .scene = "",
             .run = internal_edge},
    HardCase{
        .id = "stale-structure",
        .what = "A muscle that deforms and jumps; each answer beside that of a backend which has seen nothing else.",
        .why = "A box or a clearance that was not renewed misses contacts (FCL issue 577).",
        .bar = "the same bits",
        .scene = "",
        .run = stale_structure},
    HardCase{.id = "threads",
             .what = "The same detections on one thread and on two.",
             .why = "A result that depends on the machine can't be compared with another's.",
             .bar = "the same bits",
             .scene = "",
             .run = same_for_threads},
};

}  // namespace

std::span<const HardCase> point_cases() { return cases_of_points; }

}  // namespace musclebench

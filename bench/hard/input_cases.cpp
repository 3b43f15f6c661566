#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/cases/verification.hpp"
#include "bench/hard/asked_bone.hpp"
#include "bench/hard/moved_scene.hpp"
#include "core/mesh_repair/weld_mesh.hpp"
#include "core/scene/scene_warnings.hpp"
#include "datasets/hard/hard_shapes.hpp"

// Cases of meshes as strangers have them: they mean the same surface as a clean one, or are told of.
namespace musclebench {

namespace {

constexpr std::int64_t points_of_input = 4000;
constexpr std::uint64_t input_seed = 20;

/// The answers about a mesh that means the same surface as `clean` are those about the clean one.
HardCell same_as(const TriangleMesh& other, const TriangleMesh& clean, const HardRequest& request) {
  return about_points(request, [&] {
    const std::vector<Vec3> points = points_about(clean, points_of_input, input_seed);
    const std::vector<double> truth_m = true_distances(clean, points);
    AskedBone asked(request, other, points.size());
    AskedBone usual(request, clean, points.size());
    const double slack_m = 1e-12 * asked.diagonal_m();
    const WrongAnswers wrong = wrong_answers(truth_m, asked.contacts(points), asked, slack_m);
    const std::vector<double> depths_m = asked.depths(points);
    const std::vector<double> usual_m = usual.depths(points);
    double largest_share = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!std::isfinite(depths_m[i])) largest_share = std::numeric_limits<double>::infinity();
      if ((depths_m[i] > 0) == (usual_m[i] > 0)) {
        largest_share = std::max(largest_share, std::abs(depths_m[i] - usual_m[i]) / asked.diagonal_m());
      }
    }
    return judged(
        {{"inner points missed beyond its declared bound", static_cast<double>(wrong.missed), 0, "points"},
         {"outer points found beyond it", static_cast<double>(wrong.invented), 0, "points"},
         {"largest change of a depth, over the diagonal", largest_share, request.backend.exact ? 1e-12 : 1e-6}},
        request, "", MayRefuse::nobody);
  });
}

HardCell degenerate(const HardRequest& request) {
  const TriangleMesh clean = make_bumpy_ball(3);
  return same_as(with_bad_triangles(clean), clean, request);
}

HardCell inverted_normals(const HardRequest& request) {
  const TriangleMesh right = make_bumpy_ball(3);
  return same_as(inside_out(right), right, request);
}

HardCell turned_triangles(const HardRequest& request) {
  const TriangleMesh right = make_bumpy_ball(4);
  TriangleMesh some_turned = right;
  for (std::size_t t = 0; t < some_turned.triangles.size(); t += 611) {
    std::swap(some_turned.triangles[t][0], some_turned.triangles[t][1]);
  }
  return same_as(some_turned, right, request);
}

/// Three vertices of its own for each triangle, as in an STL file, and 20 that no triangle uses.
TriangleMesh as_soup(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const Triangle& triangle : mesh.triangles) {
    const int first = static_cast<int>(soup.vertices.size());
    for (const int vertex : triangle) soup.vertices.push_back(mesh.vertices[static_cast<std::size_t>(vertex)]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  for (int stray = 0; stray < 20; ++stray) soup.vertices.emplace_back(0.001 * stray, 0, 0);
  return soup;
}

HardCell soup_of_triangles(const HardRequest& request) {
  const TriangleMesh clean = make_bumpy_ball(3);
  return same_as(as_soup(clean), clean, request);
}

/// The muscle of the scene as a soup ends where the indexed one does, node by node in the order of the soup's welding.
HardCell welded_muscle(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = scene_of("hard/step_size");
    choice.loop_overrides["frames"] = std::int64_t{64};  // slow enough that no node passes through the plate
    const MovedScene indexed = moved(request, choice);
    std::vector<int> welded_vertex;
    const MovedScene soup = moved(request, choice, 1, [&](Scene& scene) {
      WeldedMesh welded = weld_mesh(as_soup(scene.muscle_mesh), "soup");
      welded_vertex = welded.welded_vertex;
      const std::string name = scene.muscles.front().body.name;
      scene.muscles.clear();
      scene.muscle_mesh = {};
      scene.add_muscle(name, welded.mesh);
    });
    const std::size_t nodes = indexed.scene.muscle_mesh.vertices.size();
    const std::size_t last = indexed.result.snapshots.size() - 1;
    const auto& triangles = indexed.scene.muscle_mesh.triangles;
    double largest_m = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const auto node = static_cast<std::size_t>(triangles[t][corner]);
        const auto other = static_cast<std::size_t>(welded_vertex[3 * t + corner]);
        const double gap_m = (indexed.positions(last)[node] - soup.positions(last)[other]).norm();
        if (!(gap_m <= largest_m)) largest_m = gap_m;
      }
    }
    const double slack = 0.05 + declared_m(indexed, request) / indexed.diagonal_m();
    return judged({{"nodes more or fewer",
                    std::abs(static_cast<double>(soup.scene.muscle_mesh.vertices.size()) - static_cast<double>(nodes)),
                    0, "nodes"},
                   without_contact(indexed.result.records),
                   // Another order of the nodes is another order of the constraints, which each step goes through.
                   {"difference of the shapes at the end, over the diagonal", largest_m / indexed.diagonal_m(), slack}},
                  request, "", MayRefuse::nobody);
  });
}

HardCell wrong_unit(const HardRequest& request) {
  return watched(request, false, [&] {
    int silent = 0;
    const auto scaled_by = [](double factor, std::vector<Vec3>& vertices) {
      for (Vec3& vertex : vertices) vertex *= factor;
    };
    for (const double factor : {1000.0, 100.0}) {
      for (const bool is_all : {true, false}) {
        Scene scene = load_scene(scene_of("hard/step_size"));
        scaled_by(factor, scene.muscle_mesh.vertices);
        for (Muscle& muscle : scene.muscles) scaled_by(factor, muscle.file.mesh.vertices);
        for (std::size_t bone = 0; bone < scene.bones.size() && is_all; ++bone) {
          scaled_by(factor, scene.bones[bone].surface.mesh.vertices);
          scaled_by(factor, scene.bone_meshes[bone].mesh.vertices);
        }
        if (request.spoil) request.spoil(scene);
        const std::vector<SceneWarning> said = scene_warnings(scene);
        const std::string unit = factor == 1000.0 ? "millimetre" : "centimetre";
        silent += std::ranges::none_of(
            said, [&](const SceneWarning& warning) { return warning.text.find(unit) != std::string::npos; });
      }
    }
    return judged({{"scenes in mm or cm, or with a muscle in mm or cm, of which nothing names the unit",
                    static_cast<double>(silent), 0, "scenes"}},
                  request, "", MayRefuse::nobody);
  });
}

constexpr std::array cases_of_input = {
    HardCase{.id = "degenerate",
             .what = "A bumpy ball with triangles without area, triangles twice, and slivers of aspect 1e8.",
             .why = "Real bones have slivers of aspect 1148; a normal of no length spreads NaN.",
             .bar = "depths within 1e-12 of the diagonal of the clean surface's (grids: 1e-6), all of them numbers",
             .scene = "",
             .run = degenerate},
    HardCase{.id = "inverted-normals",
             .what = "A bumpy ball that is wound inwards.",
             .why = "A silent flip makes everything collide, or nothing.",
             .bar = "found by its volume: the same answers as about the right one",
             .scene = "",
             .run = inverted_normals},
    HardCase{
        .id = "femur-winding",
        .what = "A bumpy ball of which every 611th triangle is wound against the rest, as 5 of a real femur's are.",
        .why = "The sign of a distance by a single normal is wrong there.",
        .bar = "the same answers as about the right one",
        .scene = "",
        .run = turned_triangles},
    HardCase{
        .id = "welded-bone",
        .what = "A bumpy ball as a soup of triangles with corners of their own, and 20 stray vertices.",
        .why = "So STL files are: nothing is joined, and edges and vertices have no neighbours to take normals of.",
        .bar = "the same answers as about the indexed one",
        .scene = "",
        .run = soup_of_triangles},
    HardCase{.id = "welded-input",
             .what = "A moving muscle as such a soup.",
             .why = "Unwelded it falls into its triangles and ends with the status ok.",
             .bar = "as many nodes; the same shape within 5 % of the diagonal (constraints come in another order)",
             .scene = "hard/step_size",
             .left_out_because = "two runs are compared, as good or bad as the other",
             .run = welded_muscle},
    HardCase{.id = "wrong-unit",
             .what = "The scene, or its muscle alone, in mm and in cm.",
             .why = "Most meshes are in mm. All numbers come out, a thousand times too large.",
             .bar = "a warning that names the unit, before anything runs",
             .scene = "hard/step_size",
             .left_out_because = "nothing runs",
             .asks_backend = false,
             .run = wrong_unit},
};

}  // namespace

std::span<const HardCase> input_cases() { return cases_of_input; }

}  // namespace musclebench

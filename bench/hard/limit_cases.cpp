#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/hard/asked_bone.hpp"
#include "bench/hard/courses.hpp"
#include "bench/hard/moved_scene.hpp"
#include "bench/hard/sane_figures.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh_files/polygon_mesh.hpp"
#include "core/scene/read_scene.hpp"
#include "core/scene/scene_request.hpp"
#include "datasets/hard/hard_shapes.hpp"

// Cases of nothing at all and of too much: empty inputs, counts beyond 2^31, deep nesting, many nodes.
namespace musclebench {

namespace {

/// Whether `attempt` ended as asked (true), or in a line that refuses it.
template <typename Attempt>
bool is_right_or_refused(const Attempt& attempt) {
  try {
    return attempt();
  } catch (const InputError&) {
    return true;
  }
}

/// Whether the backend finds no contact of the muscle with such bones, which have no inside.
bool finds_nothing(const HardRequest& request, const std::vector<TriangleMesh>& meshes, const TriangleMesh& muscle) {
  return is_right_or_refused([&] {
    std::vector<Bone> bones;
    for (const TriangleMesh& mesh : meshes) bones.push_back({"bone", repair_mesh(mesh, "bone")});
    const auto backend = request.backend.make(request.parameters());
    backend->build(bones, muscle, request.threads);
    backend->update(std::vector<RigidMotion>(bones.size()), muscle.vertices);
    std::vector<int> nodes;
    for (std::size_t i = 0; i < muscle.vertices.size(); ++i) nodes.push_back(static_cast<int>(i));
    std::vector<Contact> found;
    backend->detect(muscle.vertices, nodes, found);
    return found.empty();
  });
}

HardCell empty_input(const HardRequest& request) {
  if (!request.backend.make(request.parameters())->capabilities().finds_contacts) {
    return not_applicable("finds no contacts");
  }
  const TriangleMesh ball = make_sphere(0.03, 2);
  const bool no_bones = finds_nothing(request, {}, ball);
  const bool no_muscle = finds_nothing(request, {ball}, {});
  const bool no_contact = finds_nothing(request, {make_sphere(0.03, 3)}, shifted(ball, Vec3(0.01, 0, 0)));
  return judged({{"contacts without a bone", no_bones ? 0.0 : 1.0, 0},
                 {"contacts without a muscle", no_muscle ? 0.0 : 1.0, 0},
                 {"balls that overlap and don't touch", no_contact ? 1.0 : 0.0, 0}},
                request, "", MayRefuse::nobody);
}

/// The finest grid that a parameter allows; nothing for one that sets no resolution.
std::optional<ParameterValue> finest(const ParameterSpec& spec) {
  if (spec.role != ParameterRole::resolution) return std::nullopt;
  if (spec.kind == ParameterKind::integer) return static_cast<std::int64_t>(spec.maximum);
  // A cell size of a real bone's box over 4,000,000.
  return std::max(spec.minimum, 1e-7);
}

HardCell huge_grid(const HardRequest& request) {
  return about_points(request, [&] {
    const TriangleMesh cube = make_box(Vec3(0.2, 0.2, 0.2), 1);
    const std::vector<Vec3> points = {Vec3(0.01, 0.02, 0.03), Vec3(0.5, 0, 0)};
    std::vector<HardFigure> figures;
    for (const ParameterSpec& spec : request.backend.parameters) {
      const std::optional<ParameterValue> value = finest(spec);
      if (!value) continue;
      const bool is_right = is_right_or_refused([&] {
        AskedBone asked(request, cube, points.size(), {{std::string(spec.name), *value}});
        return asked.contacts(points).size() == 1;
      });
      figures.push_back({fmt::format("wrong answers with {} at its finest", spec.name), is_right ? 0.0 : 1.0, 0});
    }
    if (figures.empty()) return not_applicable("has no resolution");
    return judged(std::move(figures), request, "", MayRefuse::nobody);
  });
}

HardCell deep_tree(const HardRequest& request) {
  return about_points(request, [&] {
    constexpr int parts = 1500;
    const TriangleMesh mesh = make_shrinking_row(parts, 0.98);
    std::vector<Vec3> points;
    for (std::size_t part = 0; part < parts; part += 5) {  // the centre of each tetrahedron, and as far beside it
      const Vec3 centre = 0.25 * (mesh.vertices[4 * part] + mesh.vertices[4 * part + 1] + mesh.vertices[4 * part + 2] +
                                  mesh.vertices[4 * part + 3]);
      points.push_back(centre);
      points.push_back(2 * mesh.vertices[4 * part] - centre);
    }
    AskedBone asked(request, mesh, points.size());
    const WrongAnswers wrong = wrong_answers(true_distances(mesh, points), asked.contacts(points), asked, 0);
    const double lost = static_cast<double>(points.size()) / 2 - wrong.inside;
    return judged({{"centres that the Referee does not find inside", lost, 0, "points"},
                   {"inner points missed beyond its declared bound", static_cast<double>(wrong.missed), 0, "points"},
                   {"outer points found beyond it", static_cast<double>(wrong.invented), 0, "points"}},
                  request);
  });
}

template <typename Attempt>
bool is_refused(const Attempt& attempt) {
  try {
    attempt();
    return false;
  } catch (const InputError&) {
    return true;
  }
}

/// Files of a few bytes that announce more than an index can count, or name a vertex that wraps round to one there is.
int read_in_spite_of_their_counts() {
  using Parse = PolygonMesh (*)(std::string_view, const std::string&);
  struct File {
    Parse parse;
    std::string text;
  };
  std::vector<File> files;
  for (const char* count : {"2147483648", "4294967297", "18446744073709551617"}) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      files.push_back(
          {parse_ply, fmt::format("ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
                                  "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                                  "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
                                  format, count)});
      files.push_back(
          {parse_ply, fmt::format("ply\nformat {} 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                  "property float z\nelement face {}\nproperty list uchar int vertex_indices\n"
                                  "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
                                  format, count)});
    }
    files.push_back({parse_off, fmt::format("OFF\n{} 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", count)});
    files.push_back({parse_off, fmt::format("OFF\n3 {} 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", count)});
    files.push_back({parse_off, fmt::format("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 {}\n", count)});
    files.push_back({parse_obj, fmt::format("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {}\n", count)});
    files.push_back({parse_obj, fmt::format("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -{}\n", count)});
  }
  files.push_back({parse_stl, std::string(80, ' ') + "\xff\xff\xff\xff" + std::string(50, '\0')});
  int read = 0;
  for (const File& file : files) read += is_refused([&] { (void)file.parse(file.text, "announced"); }) ? 0 : 1;
  return read;
}

/// Scenes nested so deeply that a parser which calls itself for each level has no stack left.
int read_in_spite_of_their_depth() {
  int read = 0;
  for (const char* level : {"[", "{a=", "a."}) {
    SceneRequest request;
    request.name = request.file = "nested";
    request.text = "title = ";
    for (int i = 0; i < 200'000; ++i) request.text += level;
    read += is_refused([&] { (void)read_scene(request); }) ? 0 : 1;
  }
  return read;
}

HardCell announced_sizes(const HardRequest& request) {
  return watched(request, false, [&] {
    return judged({{"mesh files read that announce, or name, more than 2^31",
                    static_cast<double>(read_in_spite_of_their_counts()), 0, "files"},
                   {"scenes read that are nested 200,000 times", static_cast<double>(read_in_spite_of_their_depth()), 0,
                    "scenes"}},
                  request, "", MayRefuse::nobody);
  });
}

HardCell many_nodes(const HardRequest& request) {
  return watched(request, true, [&] {
    SceneChoice choice = scene_of("hard/step_size");
    choice.effect_overrides.push_back({.location = "hard cases", .name = "tunnelling_guard"});
    Scene scene = load_scene(choice);
    const std::string name = scene.muscles.front().body.name;
    const Vec3 centre = bounding_box(scene.muscle_mesh.vertices).center();
    TriangleMesh ball =
        make_sphere(0.5 * bounding_box(scene.muscle_mesh.vertices).sizes().maxCoeff(), request.whole ? 7 : 5);
    for (Vec3& vertex : ball.vertices) vertex += centre;
    scene.muscles.clear();
    scene.muscle_mesh = {};
    scene.add_muscle(name, ball);
    if (!request.whole) scene.loop.frames = 6;
    const MovedScene run = moved_in_time(request, std::move(scene));
    return judged(sane_figures(run, request), request, run.said());
  });
}

constexpr std::array cases_of_limits = {
    HardCase{.id = "empty-input",
             .what = "No bone at all, and a muscle without a node; beside them two balls that overlap.",
             .why = "The box of nothing is infinite or inside out, and a tree over it has no root.",
             .bar = "no contact without a bone or a node, or a line that refuses it; the balls touch",
             .scene = "",
             .run = empty_input},
    HardCase{.id = "huge-grid",
             .what = "A box of 40 cm with the finest grid that the backend's parameters allow: up to 7e10 cells.",
             .why = "Beyond 2^31 an index wraps round, and what is allocated is too little.",
             .bar = "right answers, or a line that refuses it before memory runs out",
             .scene = "",
             .run = huge_grid},
    HardCase{.id = "deep-tree",
             .what = "A row of 1,500 tetrahedra, each 2 % smaller than the last, down to 7e-14 of the first.",
             .why = "Trees become deep over it: recursion runs out of stack, a fixed stack overflows.",
             .bar = "no inner point missed and no outer one found beyond the declared bound",
             .scene = "",
             .run = deep_tree},
    HardCase{.id = "announced-sizes",
             .what = "Files of a few bytes that announce 2^31, 2^32 + 1 and 2^64 + 1 vertices, faces or indices, and "
                     "scenes nested 200,000 times.",
             .why = "A count that is believed takes all memory; one that wraps round names a vertex that is there.",
             .bar = "each is refused in a line",
             .scene = "",
             .asks_backend = false,
             .run = announced_sizes},
    HardCase{.id = "many-nodes",
             .what = "A ball of 10,242 nodes (163,842 in the long run: more than ten muscles') that a plate of 4 mm "
                     "sweeps along, "
                     "12 mm a frame (6 in the long run), with the tunnelling guard.",
             .why = "What is kept a pair or a cell grows faster than the muscle; constraints need more iterations.",
             .bar = "the sane figures, of which no node is on the wrong side",
             .scene = "hard/step_size",
             .run = many_nodes},
};

}  // namespace

std::span<const HardCase> limit_cases() { return cases_of_limits; }

}  // namespace musclebench

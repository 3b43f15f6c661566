#include <filesystem>
#include <optional>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include "bench/python/arrays.hpp"
#include "bench/python/bindings.hpp"
#include "bench/python/loaded_scene.hpp"
#include "bench/trials/effect_search.hpp"
#include "core/base/input_error.hpp"
#include "core/mesh/morton_order.hpp"
#include "core/scene/check/scene_check.hpp"

namespace musclebench {

namespace py = pybind11;
using namespace pybind11::literals;

namespace {

constexpr int most_fibres = 100'000;

/// `{"friction": {"coefficient": 0.3}, "volume": False}`.
std::vector<EffectOverride> changed_effects(const py::dict& effects) {
  std::vector<EffectOverride> changes;
  for (const auto& [key, value] : effects) {
    EffectOverride change{.location = {}, .name = py::str(key).cast<std::string>()};
    change.location = "effects." + change.name;
    if (py::isinstance<py::dict>(value)) {
      change.values = values_of(value.cast<py::dict>(), change.location);
    } else if (is_truth_value(value)) {
      change.is_removed = !py::bool_(value.attr("__bool__")()).cast<bool>();
    } else {
      throw InputError(change.location, "has to be True, False or a dict of parameters");
    }
    changes.push_back(std::move(change));
  }
  return changes;
}

std::shared_ptr<LoadedScene> open_scene(const std::filesystem::path& scene, const std::string& preset,
                                        const std::optional<std::filesystem::path>& data, const py::dict& loop,
                                        const py::dict& motion, const py::dict& meshes, const py::dict& effects,
                                        const py::object& fibres) {
  SceneChoice choice;
  // Recordings name it, and the working folder may change.
  choice.scene =
      scene.extension() == ".toml" ? std::filesystem::absolute(scene).lexically_normal().string() : scene.string();
  choice.preset = preset;
  if (data) choice.data = data->string();
  choice.loop_overrides = values_of(loop, "loop");
  choice.motion_overrides = values_of(motion, "motion");
  choice.mesh_overrides = values_of(meshes, "meshes");
  choice.effect_overrides = changed_effects(effects);
  if (!fibres.is_none()) {
    const std::int64_t count = integer_of(fibres, "fibres");
    if (count < 0 || count > most_fibres) {
      throw InputError("fibres", fmt::format("are {}; give 0 to {}", count, most_fibres));
    }
    choice.fibres = {static_cast<int>(count), "fibres"};
  }
  const py::gil_scoped_release unlocked;
  auto loaded = std::make_shared<LoadedScene>(std::move(choice));
  require_named_effects(loaded->scene, "a scene in Python");
  loaded->scene.warnings = warnings_of(loaded->scene);
  return loaded;
}

py::dict json_like(const std::map<std::string, ParameterValue>& values) {
  py::dict result;
  for (const auto& [name, value] : values) result[py::str(name)] = py::cast(value);
  return result;
}

std::vector<std::string> texts_of(const std::vector<SceneWarning>& warnings) {
  std::vector<std::string> texts;
  for (const SceneWarning& warning : warnings) texts.push_back(warning.text);
  return texts;
}

template <typename Parts>
py::dict meshes_by_name(const Parts& parts) {
  py::dict result;
  for (const auto& [name, vertices, triangles] : parts) result[py::str(name)] = py::make_tuple(vertices, triangles);
  return result;
}

}  // namespace

void bind_scene(py::module_& module) {
  py::class_<Bone, std::shared_ptr<Bone>>(
      module, "Bone",
      "A rigid bone: a repaired surface in its rest frame, in metres, outwards and closed where it can be.")
      .def(py::init([](const std::string& name, const py::object& vertices, const py::object& triangles) {
             auto bone = std::make_shared<Bone>();
             bone->name = name;
             bone->surface = repair_mesh(mesh_of(vertices, triangles, "bone '" + name + "'"), name);
             sort_in_morton_order(bone->surface.mesh);
             return bone;
           }),
           "name"_a, "vertices"_a, "triangles"_a,
           "vertices: (n, 3), metres. triangles: (m, 3), indices, counter-clockwise from outside. Is repaired, and "
           "sorted "
           "so that neighbours are close in memory. Raises InputError where the surface can't be closed.")
      .def_readonly("name", &Bone::name)
      .def_property_readonly(
          "vertices", [](const py::object& self) { return view_of(self.cast<Bone&>().surface.mesh.vertices, self); },
          "(n, 3), metres, rest frame. A view.")
      .def_property_readonly(
          "triangles", [](const py::object& self) { return view_of(self.cast<Bone&>().surface.mesh.triangles, self); },
          "(m, 3), indices. A view.")
      .def_property_readonly(
          "changes", [](const Bone& bone) { return bone.surface.changes; }, "What its repair changed, a line each.");

  py::class_<LoadedScene, std::shared_ptr<LoadedScene>>(module, "Scene", "A scene that is ready to be run.")
      .def_property_readonly("name", [](const LoadedScene& of) { return of.scene.name; })
      .def_property_readonly("title", [](const LoadedScene& of) { return of.scene.title; })
      .def_property_readonly("frames", [](const LoadedScene& of) { return of.scene.loop.frames; })
      .def_property_readonly(
          "loop", [](const LoadedScene& of) { return json_like(loop_values(of.scene.loop)); },
          "Values of the loop, by name (`musclebench list` has their units).")
      .def_property_readonly(
          "effects",
          [](const LoadedScene& of) {
            py::dict effects;
            for (const SceneEffect& effect : of.scene.effects) {
              effects[py::str(effect.name)] = json_like(effect.parameters.values());
            }
            return effects;
          },
          "Parameters of each effect, by name.")
      .def_property_readonly(
          "warnings", [](const LoadedScene& of) { return texts_of(of.scene.warnings); },
          "What is odd about the scene, a line each.")
      .def_property_readonly(
          "bones",
          [](const py::object& self) {
            py::list bones;
            for (const Bone& bone : self.cast<LoadedScene&>().scene.bones) {
              bones.append(py::cast(bone, py::return_value_policy::reference_internal, self));
            }
            return bones;
          },
          "Bones, in the order of their indices.")
      .def_property_readonly(
          "muscles",
          [](const LoadedScene& of) {
            py::dict nodes;
            for (const Muscle& muscle : of.scene.muscles) {
              nodes[py::str(muscle.body.name)] = py::slice(muscle.body.first_node, muscle.body.last_node, 1);
            }
            return nodes;
          },
          "By name, the slice of `nodes` that is the muscle's.")
      .def_property_readonly(
          "nodes",
          [](const py::object& self) { return view_of(self.cast<LoadedScene&>().scene.muscle_mesh.vertices, self); },
          "Nodes of all muscles at rest: (n, 3), metres. A view.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) { return view_of(self.cast<LoadedScene&>().scene.muscle_mesh.triangles, self); },
          "Triangles of all muscles: (m, 3), indices of nodes. A view.")
      .def(
          "poses",
          [](const LoadedScene& of, double frame) {
            if (!(frame >= 0 && frame <= of.scene.loop.frames)) {
              throw InputError("frame", fmt::format("{} is not within 0 (rest) and {}", frame, of.scene.loop.frames));
            }
            std::vector<RigidMotion> poses;
            of.scene.poses_at(frame, poses);
            return matrices_of(poses);
          },
          "frame"_a, "Poses of all bones at a frame (0: rest): (bones, 4, 4), from rest frames to the world, metres.");

  module.def("load_scene", &open_scene, "scene"_a, py::kw_only(), "preset"_a = "", "data"_a = py::none(),
             "loop"_a = py::dict(), "motion"_a = py::dict(), "meshes"_a = py::dict(), "effects"_a = py::dict(),
             "fibres"_a = py::none(), "See musclebench.load_scene.");
}

}  // namespace musclebench

#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/hard/moved_scene.hpp"

namespace musclebench {

/// An embedded scene, and what a case changes in it before it is read.
struct LoadedScene {
  std::string name;
  std::map<std::string, ParameterValue> loop = {};
  /// Effects with their values, added where the scene lacks them.
  std::map<std::string, std::map<std::string, ParameterValue>> effects = {};
  std::map<std::string, ParameterValue> meshes = {};
};

/// Throws InputError.
Scene load(const LoadedScene& scene);

/// The mean position of the nodes of one muscle.
Vec3 middle_of(std::span<const Vec3> positions, const Body& body);

/// The largest move of a node within one of the last `frames` frames, over the diagonal.
double late_move(const MovedScene& run, std::size_t frames);

double frame_s(const Scene& scene);

/// Of each node, kg, as the simulation has them.
std::vector<double> node_masses_kg(const Scene& scene);

/// What bones bear, over the weight.
struct LoadOfBones {
  std::optional<double> normal = {};
  std::optional<double> friction = {};
};

using HardFigures = std::vector<HardFigure>;

/// How far the mean forces of bones in the last `frames` frames are from the weight of all muscles and its shares; bars
/// of 1 %. None where the backend's response has no forces.
HardFigures late_force_figures(const MovedScene& run, int frames, const LoadOfBones& expected = {});

/// How far bound nodes are from where their bones carry them, over the diagonal.
HardFigure bound_figure(const MovedScene& run);

/// A bone's path along a straight line: `displacement_m` along `direction` at each time, from 0 to 1 over the run.
struct StraightCourse {
  Vec3 direction;
  std::vector<double> times;
  std::vector<double> displacement_m;
};

/// By a turn about an axis so far away that the path is straight within a micrometre.
void move_straight(Scene& scene, std::size_t bone, const StraightCourse& course);

/// The bone as it rests, elsewhere or as thick as `scale` makes it.
void place_bone(Scene& scene, std::size_t bone, const Vec3& by_m, const Vec3& scale = Vec3::Ones());

/// The same scene with its two muscles in the other order, and the largest difference of a node between two such runs.
void swap_muscles(Scene& scene);
double gap_of_swapped_m(const MovedScene& run, const MovedScene& swapped);

}  // namespace musclebench

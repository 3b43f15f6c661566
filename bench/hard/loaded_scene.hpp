#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "bench/hard/moved_scene.hpp"
#include "bench/hard/sane_figures.hpp"

namespace musclebench {

/// An embedded scene, and what a case changes in it before it is read.
struct LoadedScene {
  std::string name;
  std::map<std::string, ParameterValue> loop = {};
  /// Effects with their values, added where the scene lacks them.
  std::map<std::string, std::map<std::string, ParameterValue>> effects = {};
};

/// Throws InputError.
Scene load(const LoadedScene& scene);

/// Figures of the runs of one case. A run that breaks a bar has to say so itself: the status of another run does not
/// excuse it.
class LoadFigures {
 public:
  explicit LoadFigures(const HardRequest& request) : m_request(request) {}

  /// The figures of one run, named by `words` (empty: there is one), and its sane figures.
  void add_run(const MovedScene& run, const std::string& words, std::vector<HardFigure> figures,
               const SaneBars& bars = {});
  /// The same where the surface may be deep in a bone by the 0.1 mm that surface_contact promises, and by no more for
  /// a large muscle: that depth says then whether a triangle passes through a bone.
  void add_tight_run(const MovedScene& run, const std::string& words, std::vector<HardFigure> figures);
  /// The same without the sane figures.
  void add_bare_run(const MovedScene& run, const std::string& words, std::vector<HardFigure> figures);
  /// Whether the run blew up: there is nothing to add but that.
  bool add_if_diverged(const MovedScene& run, const std::string& words);
  /// A figure of several runs, which no status excuses.
  void add(HardFigure figure) { m_silent |= !figure.holds(), m_figures.push_back(std::move(figure)); }

  [[nodiscard]] HardCell judged(MayRefuse may_refuse = MayRefuse::approximate) const;

 private:
  const HardRequest& m_request;
  std::vector<HardFigure> m_figures;
  std::string m_said;
  bool m_silent = false;  ///< a figure broke and no status said so
};

/// The mean position of the nodes of one muscle.
Vec3 middle_of(std::span<const Vec3> positions, const Body& body);

/// The largest move of a node within one of the last `frames` frames, over the diagonal.
double late_move(const MovedScene& run, std::size_t frames);

double frame_s(const Scene& scene);

/// Of each node, kg, as the simulation has them.
std::vector<double> node_masses_kg(const Scene& scene);

/// A bone's way along a straight line: `way_m` along `direction` at each time, from 0 to 1 over the run.
struct StraightCourse {
  Vec3 direction;
  std::vector<double> times;
  std::vector<double> way_m;
};

/// By a turn about an axis so far away that the path is straight within a micrometre.
void move_straight(Scene& scene, std::size_t bone, const StraightCourse& course);

/// The bone as it rests, elsewhere or as thick as `scale` makes it.
void place_bone(Scene& scene, std::size_t bone, const Vec3& by_m, const Vec3& scale = Vec3::Ones());

/// Each triangle of the only muscle split in four, `times` times; attachments bind what lies over their areas.
void refine_muscle(Scene& scene, int times);

/// The same scene with its two muscles in the other order, and the largest difference of a node between two such runs.
void swap_muscles(Scene& scene);
double gap_of_swapped_m(const MovedScene& run, const MovedScene& swapped);

}  // namespace musclebench

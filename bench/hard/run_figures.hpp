#pragma once

#include <string>
#include <utility>
#include <vector>

#include "bench/hard/moved_scene.hpp"
#include "bench/hard/sane_figures.hpp"

namespace musclebench {

/// Why a case whose depth has the bar of surface_contact leaves out triangles through bones.
inline constexpr const char* depth_says_it =
    "a depth of more than 0.1 mm says that triangles pass through a bone, and a lesser one only touches";

/// Figures of the runs of one case. A run that breaks a bar has to say so itself: the status of another run does not
/// excuse it.
class RunFigures {
 public:
  explicit RunFigures(const HardRequest& request) : m_request(request) {}

  /// The figures of one run, named by `words` (empty: there is only one), and its sane figures.
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

/// The cell, which also tells what was not run. The verdict stays: nothing that the program itself has said.
HardCell without(HardCell cell, const std::string& left_out);

/// As `watched`, of a case that adds its runs one by one: `watch(figures)`. What is beyond a bar counts though a later
/// run takes too long.
template <typename Watch>
HardCell watched_runs(const HardRequest& request, bool asks_backend, MayRefuse may_refuse, const Watch& watch) {
  return watched(request, asks_backend, [&] {
    RunFigures figures(request);
    try {
      watch(figures);
    } catch (const TakesTooLong& slow) {
      const HardCell so_far = figures.judged(may_refuse);
      if (so_far.verdict == Verdict::holds) throw;
      return without(so_far, std::string("a later run ") + slow.what());
    }
    return figures.judged(may_refuse);
  });
}

template <typename Watch>
HardCell watched_runs(const HardRequest& request, bool asks_backend, const Watch& watch) {
  return watched_runs(request, asks_backend, MayRefuse::approximate, watch);
}

}  // namespace musclebench

#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

struct Scene;

/// A figure beside its bar, which it may reach and not pass.
struct HardFigure {
  std::string name;
  double value = 0;
  double bar = 0;
  std::string unit = {};

  /// Not for NaN.
  [[nodiscard]] bool holds() const { return value <= bar; }
};

enum class Verdict : std::uint8_t { holds, breaks, refused, not_applicable };

std::string_view name_of(Verdict verdict);

/// What one backend did in one case.
struct HardCell {
  Verdict verdict = Verdict::breaks;
  std::string detail = {};  ///< why it is not applicable, or what the program said in place of an answer
  std::vector<HardFigure> figures = {};
  double seconds = 0;  ///< that it took, where it ran in a process of its own to its end
};

/// The figure farthest beyond its bar, or nearest to it; nullptr for none.
const HardFigure* worst_figure(const HardCell& cell);

/// Whether a backend that says in a status that it can't answer has done its duty: those that approximate, or all of
/// them (a run whose step is too long for anybody).
enum class MayRefuse : std::uint8_t { nobody, approximate, everybody };

/// What a case is run with.
struct HardRequest {
  const BackendEntry& backend;
  std::map<std::string, ParameterValue> given = {};  ///< parameters of the backend
  bool whole = false;                                ///< the long sweeps, too
  std::string data = {};                             ///< folder of the anatomical data; empty: $MUSCLEBENCH_DATA
  int threads = 1;
  /// Cases that ask about points write those that the backend answers wrongly to PREFIX-1.queries and so on, to be sent
  /// to its makers; empty: nowhere.
  std::string wrong_prefix = {};
  /// What a test spoils in each scene before it runs, to see that the case breaks.
  std::function<void(Scene&)> spoil = {};

  /// `more` goes before what was given. Throws InputError.
  [[nodiscard]] Parameters parameters(const std::map<std::string, ParameterValue>& more = {}) const;
  /// The same of a backend that is asked about single points: with what its entry says that it needs for that.
  [[nodiscard]] Parameters parameters_for_points(const std::map<std::string, ParameterValue>& more = {}) const;
};

/// Of the figures, and of what the user was told beside them: beyond a bar a backend breaks, unless it `said` so and
/// may.
HardCell judged(std::vector<HardFigure> figures, const HardRequest& request, const std::string& said = "",
                MayRefuse may_refuse = MayRefuse::approximate);

HardCell not_applicable(std::string why);

/// A case that has to stay numerically stable.
struct HardCase {
  std::string_view id;
  std::string_view what;   ///< happens in it
  std::string_view why;    ///< it is hard, and who tests so
  std::string_view bar;    ///< in words
  std::string_view scene;  ///< embedded scene that it moves; empty: it asks about points
  /// Why it leaves out the figures of sane_figures, or some of them, although it moves a scene.
  std::string_view left_out_because = {};
  /// That carry a load in it, by their names apart by spaces: without any of them it breaks, or breaks by more.
  std::string_view effects = {};
  bool asks_backend = true;  ///< false: the loop alone, which every backend would repeat
  HardCell (*run)(const HardRequest& request);
};

/// All cases, in the order in which they are shown.
std::vector<HardCase> hard_cases();

// The parts of the table.
std::span<const HardCase> point_cases();
std::span<const HardCase> input_cases();
std::span<const HardCase> motion_cases();
std::span<const HardCase> course_cases();
std::span<const HardCase> loop_cases();
std::span<const HardCase> limit_cases();
std::span<const HardCase> anatomy_cases();
std::span<const HardCase> load_cases();
std::span<const HardCase> muscle_load_cases();
std::span<const HardCase> passage_cases();
std::span<const HardCase> effect_cases();
std::span<const HardCase> tendon_cases();

}  // namespace musclebench

#include "bench/trials/effect_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/trials/addition.hpp"
#include "core/base/input_error.hpp"
#include "core/scene/check/auto_effects.hpp"
#include "core/scene/check/scene_check.hpp"

namespace musclebench {

namespace {

/// By which the excess of a figure that does not hold anyway may grow before that counts.
constexpr double tolerated_growth = 1.1;
/// What an addition spoils may be this part of what it mends, both as logarithms of excesses.
constexpr double tolerated_harm = 0.5;
/// A run that diverges is no worse than that.
constexpr double largest_excess = 1e6;
constexpr const char* trial_rule = "trial";

/// A shape that moves by less counts as the same. A coarse wish does not raise this.
double felt_m(const Scene& scene) { return std::min(scene.wanted.surface_m, Wanted().surface_m); }

/// What changes in a scene during a search. Its bones and muscles stay, and with them what was built over them.
struct EffectSet {
  std::vector<SceneEffect> effects;
  std::vector<SceneMusclePair> pairs;
  std::vector<AddedEffect> added;
};

EffectSet set_of(const Scene& scene) { return {scene.effects, scene.muscle_pairs, scene.auto_effects.added}; }

void put(const EffectSet& set, Scene& scene) {
  scene.effects = set.effects;
  scene.muscle_pairs = set.pairs;
  scene.auto_effects.added = set.added;
}

/// A set with something added.
struct Mended {
  EffectSet set;
  EffectTrial trial;
  double gain = 0;
};

/// 0 where the figure holds, else the logarithm of its excess.
double badness(const RequiredFigure& figure) {
  return figure.holds() ? 0 : std::log(std::min(figure.excess(), largest_excess));
}

bool diverges(const RequiredFigure& figure) {
  return figure.requirement == Requirement::whole_surface && std::isinf(figure.value);
}

bool run_diverges(const EffectTrial& trial) {
  const RequiredFigure* surface = find_figure(trial.figures, Requirement::whole_surface);
  return surface != nullptr && diverges(*surface);
}

/// An excess that is not halved is not mended.
bool is_too_little(const RequiredFigure& broken, const RequiredFigure& mended) {
  return !mended.holds() && (std::isinf(mended.excess()) || mended.excess() > broken.excess() / 2);
}

std::string verdict_of(const EffectTrial& trial) {
  if (!trial.refusal.empty()) return trial.refusal;
  std::vector<std::string> broken;
  for (const RequiredFigure& figure : trial.figures) {
    if (!figure.holds()) broken.push_back(figure.text());
  }
  return broken.empty() ? "holds all that is wanted" : fmt::format("{}", fmt::join(broken, "; "));
}

class EffectSearch {
 public:
  EffectSearch(Scene& scene, const TryScene& try_scene) : m_scene(scene), m_try(try_scene) {}

  EffectChoice run(const SearchOptions& options) {
    for (const AddedEffect& added : set_of(m_scene).added) remove_added(m_scene, added.effect);
    for (const SceneEffect& effect : m_scene.effects) m_own.push_back(effect.name);
    add_what_rules_ask_for();
    m_now = attempt("", {});
    if (!m_now.refusal.empty()) {
      m_choice.was_refused = true;
      m_choice.unmet.push_back({m_now.refusal});
      return std::move(m_choice);
    }
    mend_and_take_away();
    if (options.judges_the_end && !m_now.judged_all_frames) {
      m_judges_all = true;
      m_whole.clear();
      m_given_up.clear();
      m_now = attempt("", {});
      mend_and_take_away();
    }
    if (options.looks_for_needless) look_for_needless();
    return finish();
  }

 private:
  EffectChoice finish() {
    m_choice.added = m_scene.auto_effects.added;
    m_choice.figures = m_now.figures;
    m_choice.judged_all_frames = m_now.judged_all_frames;
    for (const RequiredFigure& figure : m_now.figures) {
      if (figure.holds()) continue;
      m_choice.unmet.push_back({figure.text(), m_given_up[figure.requirement]});
    }
    for (const TriedSet& tried : m_choice.tried) m_choice.cpu_ns += tried.cpu_ns;
    return std::move(m_choice);
  }

  /// They need no run: without an effect that moves attached nodes, a run means nothing.
  void add_what_rules_ask_for() {
    for (const Finding& finding : quick_findings(m_scene)) {
      if (!finding.effect || !may_add_effect(m_scene, finding.effect->name)) continue;
      add_effect(m_scene, *finding.effect, finding.id, fmt::format("{}: {}", finding.where, finding.what));
    }
  }

  /// Of the scene as it is.
  EffectTrial attempt(const std::string& change, const ShowsEnough& shows_enough) {
    const std::string what = !change.empty() ? change : m_judges_all ? "what was found, in every frame" : "as it is";
    EffectTrial trial = m_try(m_scene, {shows_enough, m_judges_all}, what);
    m_choice.tried.push_back({what, verdict_of(trial), trial.figures, trial.was_stopped, trial.frames, trial.cpu_ns});
    return trial;
  }

  void mend_and_take_away() {
    while (const RequiredFigure* broken = first_broken()) mend(RequiredFigure(*broken));
    take_away_additions();
  }

  [[nodiscard]] const RequiredFigure* first_broken() const {
    const auto found = std::ranges::find_if(m_now.figures, [&](const RequiredFigure& figure) {
      return !figure.holds() && !m_given_up.contains(figure.requirement);
    });
    return found == m_now.figures.end() ? nullptr : &*found;
  }

  void mend(const RequiredFigure& broken) {
    const EffectSet before = set_of(m_scene);
    const std::vector<Finding> findings = quick_findings(m_scene);
    std::optional<Mended> best;
    std::vector<std::string> tried;
    // What makes a run diverge may be anything, and so may what mends it.
    const Requirement aim = diverges(broken) ? Requirement::trusted_run : broken.requirement;
    std::vector<Addition> additions = additions_for(m_scene, aim, {});
    if (!additions.empty()) additions = additions_for(m_scene, aim, advised());
    for (const Addition& addition : additions) {
      put(before, m_scene);
      add(m_scene, addition, trial_rule, "when it was tried, without it " + broken.text());
      if (const std::string why = refusal_by_rules(m_scene, findings); !why.empty()) {
        tried.push_back(fmt::format("{} is not run: {}", addition.name, why));
        continue;
      }
      EffectTrial trial = trial_with(addition, broken);
      tried.push_back(result_of(addition, trial, broken));
      const std::optional<double> won = gain(broken, trial);
      if (!won || (best && *won <= best->gain)) continue;
      const RequiredFigure& mended = *find_figure(trial.figures, broken.requirement);
      for (std::size_t i = before.added.size(); i < m_scene.auto_effects.added.size(); ++i) {
        m_scene.auto_effects.added[i].reason += ", with it " + mended.value_text();
      }
      const bool is_all = mended.holds() && *won == badness(broken);
      best = Mended{set_of(m_scene), std::move(trial), *won};
      if (is_all) break;
    }
    put(best ? best->set : before, m_scene);
    if (!best) {
      m_given_up[broken.requirement] = std::move(tried);
      return;
    }
    m_last_mending = best->set.added.size() - before.added.size();
    m_now = std::move(best->trial);
    m_whole.clear();
    m_given_up.clear();  // what could not be mended before may be now
  }

  /// What the checker finds, from geometry: of the scene when it first failed, as that takes a while.
  const std::vector<Finding>& advised() {
    if (!m_advised) m_advised = check_scene(m_scene);
    return *m_advised;
  }

  /// One that went to its end for another requirement is not run again.
  EffectTrial trial_with(const Addition& addition, const RequiredFigure& broken) {
    if (const auto known = m_whole.find(addition.name); known != m_whole.end()) return known->second;
    EffectTrial trial = attempt("+ " + addition.name, stops_where_no_better(broken));
    if (trial.is_whole()) m_whole.emplace(addition.name, trial);
    return trial;
  }

  /// Of a figure that is worse than now; 0 for others. What nobody judged before held.
  [[nodiscard]] double harm(const RequiredFigure& figure) const {
    // A run that diverges did not come to what it would have spoilt.
    if (run_diverges(m_now)) return 0;
    const RequiredFigure* now = find_figure(m_now.figures, figure.requirement);
    if (now == nullptr) return badness(figure);
    const double grown = badness(figure) - badness(*now);
    return now->holds() || grown > std::log(tolerated_growth) ? std::max(0.0, grown) : 0;
  }

  [[nodiscard]] bool is_worse(const RequiredFigure& figure) const { return harm(figure) > 0; }

  [[nodiscard]] ShowsEnough stops_where_no_better(const RequiredFigure& broken) const {
    return [this, broken](const RequiredFigure& of_frame) {
      if (of_frame.requirement == broken.requirement) return is_too_little(broken, of_frame);
      return harm(of_frame) > tolerated_harm * badness(broken);
    };
  }

  /// By how much a trial is better than now; nothing where it does not mend the figure, or spoils too much.
  [[nodiscard]] std::optional<double> gain(const RequiredFigure& broken, const EffectTrial& trial) const {
    // One that diverges, too, may have done so before it came to what is broken.
    if (!trial.is_whole() || (run_diverges(m_now) && run_diverges(trial))) return std::nullopt;
    const RequiredFigure* mended = find_figure(trial.figures, broken.requirement);
    if (mended == nullptr || is_too_little(broken, *mended)) return std::nullopt;
    double spoilt = 0;
    for (const RequiredFigure& figure : trial.figures) spoilt += harm(figure);
    const double won = badness(broken) - badness(*mended);
    return spoilt > tolerated_harm * won ? std::nullopt : std::optional(won - spoilt);
  }

  /// In words.
  [[nodiscard]] std::string result_of(const Addition& addition, const EffectTrial& trial,
                                      const RequiredFigure& broken) const {
    if (!trial.refusal.empty()) return fmt::format("{}: {}", addition.name, trial.refusal);
    const RequiredFigure* figure = find_figure(trial.figures, broken.requirement);
    std::string words = addition.name;
    if (trial.was_stopped) words += fmt::format(", which was ended in frame {},", trial.frames);
    const bool is_told = figure != nullptr && (!trial.was_stopped || !figure->holds());
    if (is_told) words += " leaves " + figure->value_text();
    const auto worse = std::ranges::find_if(trial.figures, [&](const RequiredFigure& other) {
      return other.requirement != broken.requirement && is_worse(other);
    });
    if (worse == trial.figures.end()) {
      if (!is_told) words += figure == nullptr ? " does not tell" : " is no better";
      return words;
    }
    return fmt::format("{}{}{}", words, is_told ? ", and " : " spoils other things: ", worse->text());
  }

  /// What the last mending added, if it is one thing, was what the run before lacked.
  void take_away_additions() {
    const std::vector<AddedEffect> added = m_scene.auto_effects.added;
    for (auto each = added.rbegin(); each != added.rend(); ++each) {
      if (each == added.rbegin() && m_last_mending == 1) continue;
      const EffectSet before = set_of(m_scene);
      remove_added(m_scene, each->effect);
      EffectTrial trial = attempt_without(each->effect);
      // What a rule asked for a scene may mean without that a figure feels it: nodes that are bound.
      const bool is_felt = each->rule != trial_rule && !(largest_change_m(trial) <= felt_m(m_scene));
      if (is_felt || is_needed(trial)) {
        put(before, m_scene);
        m_choice.tried.back().verdict += ": it stays";
        continue;
      }
      m_choice.tried.back().verdict += ": it goes";
      m_now = std::move(trial);
      m_last_mending = 0;
      m_whole.clear();
    }
  }

  /// One after the other, and those before it left out: what two of them do alike is needed once.
  void look_for_needless() {
    if (m_now.shapes.empty() || run_diverges(m_now)) return;
    const EffectSet whole = set_of(m_scene);
    for (const std::string& effect : m_own) {
      const EffectSet before = set_of(m_scene);
      std::erase_if(m_scene.effects, [&](const SceneEffect& each) { return each.name == effect; });
      const EffectTrial trial = attempt_without(effect);
      const double shape_m = largest_change_m(trial);
      if (is_needed(trial) || !(shape_m <= felt_m(m_scene))) {
        put(before, m_scene);
        continue;
      }
      m_choice.needless.push_back(fmt::format(
          "{}: without it no figure gets worse, and the shape moves by {:.2g} mm (RMS)", effect, 1e3 * shape_m));
    }
    put(whole, m_scene);
  }

  EffectTrial attempt_without(const std::string& name) {
    EffectTrial trial = attempt("- " + name, [this](const RequiredFigure& of_frame) { return is_worse(of_frame); });
    const double shape_m = largest_change_m(trial);
    if (trial.is_whole() && std::isfinite(shape_m)) {
      m_choice.tried.back().verdict += fmt::format("; the shape moves by {:.2g} mm (RMS)", 1e3 * shape_m);
    }
    return trial;
  }

  [[nodiscard]] bool is_needed(const EffectTrial& without) const {
    const auto is_worse_without = [this](const RequiredFigure& figure) { return is_worse(figure); };
    if (!without.is_whole() || std::ranges::any_of(without.figures, is_worse_without)) return true;
    const std::optional<double> arm_m = m_scene.wanted.moment_arm_m;
    return arm_m && arm_error(without.arms, m_now.arms).rms_m > *arm_m;
  }

  /// RMS over a muscle's nodes, in the frame with the largest; infinite where that can't be told.
  [[nodiscard]] double largest_change_m(const EffectTrial& trial) const {
    if (trial.shapes.size() != m_now.shapes.size() || trial.shapes.empty()) {
      return std::numeric_limits<double>::infinity();
    }
    double largest_m = 0;
    for (std::size_t i = 0; i < trial.shapes.size(); ++i) {
      largest_m =
          std::max(largest_m, largest_rms_distance(m_scene.bodies(), trial.shapes[i], m_now.shapes[i]).distance_m);
    }
    return largest_m;
  }

  Scene& m_scene;
  const TryScene& m_try;
  EffectChoice m_choice;
  EffectTrial m_now;               ///< of the scene as it is
  std::vector<std::string> m_own;  ///< effects that the scene names
  std::optional<std::vector<Finding>> m_advised;
  bool m_judges_all = false;
  std::size_t m_last_mending = 0;                              ///< how many things it added
  std::map<Requirement, std::vector<std::string>> m_given_up;  ///< and what was tried
  std::map<std::string, EffectTrial> m_whole;                  ///< of the scene as it is with an addition
};

}  // namespace

std::string Unmet::text() const {
  return tried.empty() ? what : fmt::format("{}; tried: {}", what, fmt::join(tried, "; "));
}

bool waits_for_trials(const Scene& scene) { return scene.auto_effects.wanted && scene.wanted.is_given; }

void require_named_effects(const Scene& scene, const std::string& what) {
  if (!waits_for_trials(scene)) return;
  throw InputError(
      scene.file,
      fmt::format(
          "has no named effects yet, which {} needs: write them with `musclebench check {} --trial --out FILE.toml`",
          what, scene.file));
}

EffectChoice choose_effects(Scene& scene, const TryScene& try_scene, const SearchOptions& options) {
  return EffectSearch(scene, try_scene).run(options);
}

}  // namespace musclebench

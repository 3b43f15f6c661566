#include "bench/trials/effect_search.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/effects/effect_registry.hpp"
#include "core/scene/check/auto_effects.hpp"
#include "core/scene/check/scene_check.hpp"

namespace musclebench {

namespace {

/// By which the excess of a figure that does not hold anyway may grow before that counts.
constexpr double tolerated_growth = 1.1;
/// What an effect spoils may be this part of what it mends, both as logarithms of excesses.
constexpr double tolerated_harm = 0.5;
/// A run that diverges is no worse than that.
constexpr double largest_excess = 1e6;
constexpr const char* trial_rule = "trial";

/// What can be added to a scene, as one.
struct Candidate {
  std::string name;
  std::optional<AdvisedEffect> effect = {};
  std::vector<MusclePair> pairs = {};  ///< or these
};

/// A scene with something added.
struct Mended {
  Scene scene;
  EffectTrial trial;
  double gain = 0;
};

bool is_about_muscles(Requirement requirement) {
  return requirement == Requirement::muscle_passage || requirement == Requirement::muscle_depth;
}

/// No frame does.
bool never(const RequiredFigure& /*of_frame*/) { return false; }

class EffectSearch {
 public:
  EffectSearch(Scene& scene, const TryScene& try_scene) : m_scene(scene), m_try(try_scene) {}

  EffectChoice run(const SearchOptions& options) {
    for (const SceneEffect& effect : m_scene.effects) m_own.push_back(effect.name);
    add_what_rules_ask_for();
    m_now = attempt(m_scene, "", never);
    m_choice.tried.back().verdict = verdict_of(m_now);
    if (!m_now.refusal.empty()) {
      m_choice.unmet.push_back(m_now.refusal);
      return finish();
    }
    while (const RequiredFigure* broken = first_broken()) mend(*broken);
    take_away_additions();
    if (options.looks_for_needless) look_for_needless();
    return finish();
  }

 private:
  EffectChoice finish() {
    m_choice.added = m_scene.auto_effects.added;
    m_choice.figures = m_now.figures;
    for (const TriedSet& tried : m_choice.tried) m_choice.cpu_ns += tried.trial.cpu_ns;
    return std::move(m_choice);
  }

  /// They need no run: without an effect that moves attached nodes, a run means nothing.
  void add_what_rules_ask_for() {
    CheckOptions options;
    options.only_quick = true;
    for (const Finding& finding : check_scene(m_scene, options)) {
      if (!finding.effect || !may_add_effect(m_scene, finding.effect->name)) continue;
      add_effect(m_scene, *finding.effect, finding.id, fmt::format("{}: {}", finding.where, finding.what));
    }
  }

  /// Its verdict is still to be filled in.
  EffectTrial attempt(const Scene& scene, const std::string& change, const ShowsEnough& shows_enough) {
    EffectTrial trial = m_try(scene, shows_enough, change.empty() ? "as it is" : change);
    m_choice.tried.push_back({change, "", trial});
    return trial;
  }

  [[nodiscard]] static std::string verdict_of(const EffectTrial& trial) {
    if (!trial.refusal.empty()) return trial.refusal;
    std::vector<std::string> broken;
    for (const RequiredFigure& figure : trial.figures) {
      if (!figure.holds()) broken.push_back(figure.text());
    }
    return broken.empty() ? "holds all that is wanted" : fmt::format("{}", fmt::join(broken, "; "));
  }

  [[nodiscard]] const RequiredFigure* first_broken() const {
    const auto found = std::ranges::find_if(m_now.figures, [&](const RequiredFigure& figure) {
      return !figure.holds() && !m_given_up.contains(figure.requirement);
    });
    return found == m_now.figures.end() ? nullptr : &*found;
  }

  void mend(const RequiredFigure& broken_now) {
    const RequiredFigure broken = broken_now;
    std::optional<Mended> best;
    std::vector<std::string> tried;
    for (const Candidate& candidate : candidates(broken.requirement)) {
      Scene with = m_scene;
      add(with, candidate, broken);
      if (const std::string why = refused_by_rules(with, candidate); !why.empty()) {
        tried.push_back(fmt::format("{} cannot act: {}", candidate.name, why));
        continue;
      }
      EffectTrial trial = trial_with(with, candidate, broken);
      tried.push_back(judge(broken, trial, candidate.name));
      const std::optional<double> won = gain(broken, trial);
      if (!won || (best && *won <= best->gain)) continue;
      const RequiredFigure& mended = *find_figure(trial.figures, broken.requirement);
      tell_result(with, candidate, mended);
      const bool is_all = mended.holds() && *won == badness(broken);
      best = Mended{std::move(with), std::move(trial), *won};
      if (is_all) break;
    }
    if (!best) {
      m_given_up.insert(broken.requirement);
      m_choice.unmet.push_back(tried.empty() ? broken.text() + "; no effect that may be added is a remedy"
                                             : fmt::format("{}; tried: {}", broken.text(), fmt::join(tried, "; ")));
      return;
    }
    m_last_mending = best->scene.auto_effects.added.size() - m_scene.auto_effects.added.size();
    m_scene = std::move(best->scene);
    m_now = std::move(best->trial);
    m_whole.clear();
  }

  /// One that went to its end for another requirement is not run again.
  EffectTrial trial_with(const Scene& with, const Candidate& candidate, const RequiredFigure& broken) {
    if (const auto known = m_whole.find(candidate.name); known != m_whole.end()) return known->second;
    EffectTrial trial = attempt(with, "+ " + candidate.name, stops_where_no_better(broken));
    m_choice.tried.back().verdict = judge(broken, trial, candidate.name);
    if (trial.is_whole()) m_whole.emplace(candidate.name, trial);
    return trial;
  }

  /// What the checker advises first, then by the order of the registry.
  std::vector<Candidate> candidates(Requirement requirement) {
    std::vector<Candidate> found;
    if (is_about_muscles(requirement) || requirement == Requirement::trusted_run) {
      if (std::vector<MusclePair> pairs = pairs_to_add(); !pairs.empty()) {
        found.push_back({pairs.size() == 1 ? name_of_muscle_contact(m_scene, pairs.front()) : "contact between muscles",
                         {},
                         std::move(pairs)});
      }
    }
    std::vector<Candidate> advised;
    std::vector<Candidate> others;
    for (const EffectEntry& entry : effect_registry()) {
      // What makes a run suspect may be anything, and so may what mends it.
      const auto remedy = requirement == Requirement::trusted_run
                              ? entry.remedies.begin()
                              : std::ranges::find(entry.remedies, requirement, &Remedy::requirement);
      if (remedy == entry.remedies.end() || !may_add_effect(m_scene, entry.name)) continue;
      const auto rule = std::ranges::find_if(
          findings(), [&](const Finding& finding) { return finding.effect && finding.effect->name == entry.name; });
      if (rule != findings().end()) {
        advised.push_back({entry.name, rule->effect});
      } else {
        others.push_back({entry.name, AdvisedEffect{entry.name, remedy->values}});
      }
    }
    std::ranges::move(advised, std::back_inserter(found));
    std::ranges::move(others, std::back_inserter(found));
    return found;
  }

  /// Those that the checker expects to meet; where it expects none, all.
  std::vector<MusclePair> pairs_to_add() {
    std::vector<MusclePair> pairs;
    const auto add_pair = [&](MusclePair pair) {
      if (may_add_muscle_contact(m_scene, pair)) pairs.push_back(pair);
    };
    for (const Finding& finding : findings()) {
      if (finding.muscle_pair) add_pair(*finding.muscle_pair);
    }
    const int muscles = static_cast<int>(m_scene.muscles.size());
    for (int first = 0; first < muscles && pairs.empty(); ++first) {
      for (int second = first + 1; second < muscles; ++second) {
        const bool are_closed = is_closed_muscle(m_scene, static_cast<std::size_t>(first)) &&
                                is_closed_muscle(m_scene, static_cast<std::size_t>(second));
        if (are_closed) add_pair({first, second});
      }
    }
    return pairs;
  }

  /// Of the scene before anything was added.
  const Findings& findings() {
    if (!m_findings) m_findings = check_scene(m_scene);
    return *m_findings;
  }

  static void add(Scene& scene, const Candidate& candidate, const RequiredFigure& broken) {
    const std::string reason = "without it " + broken.text();
    if (candidate.effect) add_effect(scene, *candidate.effect, trial_rule, reason);
    for (const MusclePair& pair : candidate.pairs) add_muscle_contact(scene, pair, trial_rule, reason);
  }

  static void tell_result(Scene& scene, const Candidate& candidate, const RequiredFigure& mended) {
    std::vector<AddedEffect>& added = scene.auto_effects.added;
    const std::size_t count = candidate.effect ? 1 : candidate.pairs.size();
    for (auto last = added.end() - static_cast<std::ptrdiff_t>(count); last != added.end(); ++last) {
      last->reason += ", with it " + mended.value_text();
    }
  }

  /// Why it could not do anything, or should not be run.
  static std::string refused_by_rules(const Scene& with, const Candidate& candidate) {
    if (!candidate.effect) return {};
    CheckOptions options;
    options.only_quick = true;
    const std::string key = "effects." + candidate.effect->name;
    for (const Finding& finding : check_scene(with, options)) {
      const bool is_meant = finding.where.starts_with(key);
      const bool refuses = finding.kind == FindingKind::cannot_act || finding.kind == FindingKind::contradiction;
      if (is_meant && refuses) return finding.what;
    }
    return {};
  }

  /// 0 where the figure holds, else the logarithm of its excess.
  static double badness(const RequiredFigure& figure) {
    return figure.holds() ? 0 : std::log(std::min(figure.excess(), largest_excess));
  }

  /// Of a figure that is worse than now; 0 for others.
  [[nodiscard]] double harm(const RequiredFigure& figure) const {
    const RequiredFigure* now = find_figure(m_now.figures, figure.requirement);
    if (now == nullptr) return 0;
    const double grown = badness(figure) - badness(*now);
    return now->holds() || grown > std::log(tolerated_growth) ? std::max(0.0, grown) : 0;
  }

  [[nodiscard]] bool is_worse(const RequiredFigure& figure) const { return harm(figure) > 0; }

  /// An excess that is not halved is not mended.
  static bool is_too_little(const RequiredFigure& broken, const RequiredFigure& mended) {
    return !mended.holds() && mended.excess() > broken.excess() / 2;
  }

  [[nodiscard]] ShowsEnough stops_where_no_better(const RequiredFigure& broken) const {
    return [this, &broken](const RequiredFigure& of_frame) {
      if (of_frame.requirement == broken.requirement) return is_too_little(broken, of_frame);
      return harm(of_frame) > tolerated_harm * badness(broken);
    };
  }

  /// By how much a trial is better than now; nothing where it does not mend the figure, or spoils too much.
  [[nodiscard]] std::optional<double> gain(const RequiredFigure& broken, const EffectTrial& trial) const {
    if (!trial.is_whole()) return std::nullopt;
    const RequiredFigure* mended = find_figure(trial.figures, broken.requirement);
    if (mended == nullptr || is_too_little(broken, *mended)) return std::nullopt;
    double spoilt = 0;
    for (const RequiredFigure& figure : trial.figures) spoilt += harm(figure);
    const double won = badness(broken) - badness(*mended);
    return spoilt > tolerated_harm * won ? std::nullopt : std::optional(won - spoilt);
  }

  /// In words.
  [[nodiscard]] std::string judge(const RequiredFigure& broken, const EffectTrial& trial,
                                  const std::string& name) const {
    if (!trial.refusal.empty()) return fmt::format("{}: {}", name, trial.refusal);
    const RequiredFigure* figure = find_figure(trial.figures, broken.requirement);
    const auto worse = std::ranges::find_if(trial.figures, [&](const RequiredFigure& other) {
      return other.requirement != broken.requirement && is_worse(other);
    });
    std::string words =
        fmt::format("{} leaves {}", name, figure == nullptr ? "nothing to judge" : figure->value_text());
    if (trial.was_stopped) words += " or more";
    if (worse != trial.figures.end()) words += fmt::format(", and {}", worse->text());
    return words;
  }

  /// What the last mending added, if it is one thing, was what the run before lacked.
  void take_away_additions() {
    const std::vector<AddedEffect> added = m_scene.auto_effects.added;
    for (auto each = added.rbegin(); each != added.rend(); ++each) {
      if (each == added.rbegin() && m_last_mending == 1) continue;
      Scene without = m_scene;
      remove_added(without, each->effect);
      EffectTrial trial = attempt_without(without, each->effect);
      // What a rule asked for a scene may mean without that a figure feels it: nodes that are bound.
      const bool is_felt = each->rule != trial_rule && largest_change_m(trial) > m_scene.wanted.surface_m;
      if (is_felt || is_needed(trial)) continue;
      m_scene = std::move(without);
      m_now = std::move(trial);
    }
  }

  void look_for_needless() {
    for (const std::string& effect : m_own) {
      Scene without = m_scene;
      std::erase_if(without.effects, [&](const SceneEffect& each) { return each.name == effect; });
      const EffectTrial trial = attempt_without(without, effect);
      const double shape_m = largest_change_m(trial);
      if (is_needed(trial) || shape_m > m_scene.wanted.surface_m) continue;
      m_choice.needless.push_back(fmt::format(
          "{}: without it no figure gets worse, and the shape moves by {:.2g} mm (RMS)", effect, 1e3 * shape_m));
    }
  }

  EffectTrial attempt_without(const Scene& without, const std::string& name) {
    EffectTrial trial =
        attempt(without, "- " + name, [this](const RequiredFigure& of_frame) { return is_worse(of_frame); });
    std::string& verdict = m_choice.tried.back().verdict;
    verdict = verdict_of(trial);
    if (trial.is_whole()) verdict += fmt::format("; the shape moves by {:.2g} mm (RMS)", 1e3 * largest_change_m(trial));
    return trial;
  }

  [[nodiscard]] bool is_needed(const EffectTrial& without) const {
    const auto is_worse_without = [this](const RequiredFigure& figure) { return is_worse(figure); };
    if (!without.is_whole() || std::ranges::any_of(without.figures, is_worse_without)) return true;
    const std::optional<double> arm_m = m_scene.wanted.moment_arm_m;
    return arm_m && arm_error(without.arms, m_now.arms).rms_m > *arm_m;
  }

  /// RMS over a muscle's nodes, in the middle of the motion or at its end.
  [[nodiscard]] double largest_change_m(const EffectTrial& trial) const {
    double largest_m = 0;
    for (std::size_t i = 0; i < trial.shapes.size() && i < m_now.shapes.size(); ++i) {
      largest_m = std::max(largest_m, largest_rms_distance_m(m_scene.bodies(), trial.shapes[i], m_now.shapes[i]));
    }
    return largest_m;
  }

  Scene& m_scene;
  const TryScene& m_try;
  EffectChoice m_choice;
  EffectTrial m_now;               ///< of the scene as it is
  std::vector<std::string> m_own;  ///< effects that the scene names
  std::size_t m_last_mending = 0;  ///< how many things it added
  std::set<Requirement> m_given_up;
  std::map<std::string, EffectTrial> m_whole;  ///< of the scene as it is with a candidate
  std::optional<Findings> m_findings;
};

}  // namespace

EffectChoice choose_effects(Scene& scene, const TryScene& try_scene, const SearchOptions& options) {
  return EffectSearch(scene, try_scene).run(options);
}

}  // namespace musclebench

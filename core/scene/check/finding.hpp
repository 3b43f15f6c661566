#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/muscle_contact.hpp"

namespace musclebench {

enum class FindingKind : std::uint8_t {
  cannot_act,     ///< the scene names it, and it has nothing to act on or changes nothing
  acts_in_part,   ///< the scene names it, and there is something that it would have to act on and does not
  lacking,        ///< the scene calls for it and lacks it
  contradiction,  ///< two things that the scene names do not go together
};

/// As in `check --json`: "cannot_act", ...
std::string_view name_of(FindingKind kind);

/// A measured value behind a finding.
struct Figure {
  std::string name;  ///< ends in the unit where it has one (`step_m`)
  double value = 0;
};

/// An effect with the parameters that differ from its defaults.
struct AdvisedEffect {
  std::string name;
  std::map<std::string, ParameterValue> values = {};
};

/// What the checker found: one thing at one location, and what mends it.
struct Finding {
  std::string id = {};  ///< stable: of the rule
  FindingKind kind = FindingKind::lacking;
  std::string place = {};                      ///< file, and line where one is meant
  std::string where;                           ///< "bone 'femur'", "effects.damping"
  std::string what;                            ///< one clause with its figures
  std::vector<Figure> figures = {};            ///< SI units
  std::vector<std::string> add = {};           ///< lines of a scene file, all of them
  std::vector<std::string> remove = {};        ///< the same, to take out
  std::optional<AdvisedEffect> effect = {};    ///< what `effects = "auto"` adds
  std::optional<MusclePair> muscle_pair = {};  ///< the same
};

/// "the scene calls for [id]: place: where: what; add ..."
std::string text_of(const Finding& finding);

}  // namespace musclebench

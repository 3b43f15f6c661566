#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace musclebench {

using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

enum class ParameterKind { flag, integer, number, choice, path };

/// What a parameter is for, where a study or an advice has to know.
enum class ParameterRole {
  none,
  resolution,       ///< how fine the structures are
  wanted_error,     ///< how far answers may be off; the structures become as fine as that asks for
  storage,          ///< where structures are kept; changes no answer
  clearance_cache,  ///< `on` or `off`; changes no answer
};

/// One parameter of a backend, an effect or the loop. `list` prints these, scene files and `--param` are checked
/// against them. Made by one of the functions of `parameter`.
struct ParameterSpec {
  std::string name;  ///< ends in the unit where it has one (`voxel_size_m`)
  ParameterKind kind = ParameterKind::flag;
  ParameterRole role = ParameterRole::none;
  std::string unit = {};         ///< "m", "kg/m3", ...; empty: none
  ParameterValue default_value;  ///< of the type that `kind` says
  std::string help;
  double minimum = 0;                     ///< inclusive; integers and numbers
  double maximum = 0;                     ///< inclusive; integers and numbers
  std::vector<std::string> choices = {};  ///< the allowed words of a choice

  /// Whether it has a smallest and a largest value.
  [[nodiscard]] bool has_range() const { return kind == ParameterKind::integer || kind == ParameterKind::number; }
};

/// Makers of parameter specifications, one a kind.
namespace parameter {

struct Flag {
  std::string name = {};
  bool default_value = false;
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

struct Integer {
  std::string name = {};
  std::int64_t default_value = 0;
  std::int64_t minimum = std::numeric_limits<std::int64_t>::min();
  std::int64_t maximum = std::numeric_limits<std::int64_t>::max();
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

struct Number {
  std::string name = {};
  std::string unit = {};
  double default_value = 0;
  double minimum = 0;
  double maximum = 0;
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

struct Choice {
  std::string name = {};
  std::vector<std::string> choices = {};
  std::string default_value = {};  ///< empty: the first
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

struct Path {
  std::string name = {};
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

ParameterSpec flag(Flag declared);
ParameterSpec integer(Integer declared);
ParameterSpec number(Number declared);
ParameterSpec choice(Choice declared);
/// Empty by default: none.
ParameterSpec path(Path declared);

}  // namespace parameter

/// As in `list --json`: "flag", "integer", ...
std::string_view name_of(ParameterKind kind);
/// "resolution", "wanted_error", ...; empty for `none`.
std::string_view name_of(ParameterRole role);

/// The parameter of that name, or nullptr.
const ParameterSpec* find_parameter(const std::vector<ParameterSpec>& specs, std::string_view name);
/// The first parameter with that role, or nullptr.
const ParameterSpec* find_parameter(const std::vector<ParameterSpec>& specs, ParameterRole role);

/// A complete, checked set of parameter values.
class Parameters {
 public:
  /// All of `specs` at their defaults, overwritten by `given`. Throws InputError that names `location` (file and table,
  /// or
  /// `--param`), the key and the cure, for an unknown key (with the nearest known one), a value of another type or out
  /// of range.
  Parameters(const std::vector<ParameterSpec>& specs, const std::map<std::string, ParameterValue>& given,
             std::string_view location);

  [[nodiscard]] bool flag(const std::string& name) const { return std::get<bool>(m_values.at(name)); }
  [[nodiscard]] std::int64_t integer(const std::string& name) const {
    return std::get<std::int64_t>(m_values.at(name));
  }
  [[nodiscard]] double number(const std::string& name) const { return std::get<double>(m_values.at(name)); }
  /// Of a choice or a path.
  [[nodiscard]] const std::string& word(const std::string& name) const {
    return std::get<std::string>(m_values.at(name));
  }
  [[nodiscard]] const std::map<std::string, ParameterValue>& values() const { return m_values; }
  /// Whether the value was given, and be it the default.
  [[nodiscard]] bool given(const std::string& name) const { return m_given.contains(name); }

 private:
  std::map<std::string, ParameterValue> m_values;
  std::set<std::string> m_given;
};

/// `text` as the most specific of bool, integer, number, word.
ParameterValue parse_parameter_value(std::string_view text);

/// Texts `key=value`; `option` is the location that an InputError names. What `specs` say is a word stays one, though
/// it may look like a number: `structures=2024` is a folder.
std::map<std::string, ParameterValue> parse_assignments(const std::vector<std::string>& texts,
                                                        const std::string& option,
                                                        const std::vector<ParameterSpec>& specs);

/// The value so that it reads back to the same bits.
std::string format_parameter_value(const ParameterValue& value);

}  // namespace musclebench

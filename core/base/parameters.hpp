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

/// The value of a parameter. A string holds both choices and paths.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// The type of a parameter. A choice is one of a list of words. A path names a file or folder.
enum class ParameterKind { flag, integer, number, choice, path };

/// What a parameter is for. Studies and `advise` find the parameter that they vary by its role.
enum class ParameterRole {
  none,
  resolution,       ///< how fine the structures are
  wanted_error,     ///< how large the error of an answer may be; the structures are refined until they reach it
  storage,          ///< where structures are stored; changes no answer
  clearance_cache,  ///< `on` or `off`; changes no answer
};

/// Describes one parameter of a backend, an effect or the loop. `list` prints it, and the values in scene files and
/// `--param` are checked against it. Make one with a function of `parameter`.
struct ParameterSpec {
  std::string name;  ///< ends in the unit if the parameter has one (`voxel_size_m`)
  ParameterKind kind = ParameterKind::flag;
  ParameterRole role = ParameterRole::none;
  std::string unit = {};         ///< "m", "kg/m3", ...; empty: no unit
  ParameterValue default_value;  ///< has the type that `kind` names
  std::string help;
  double minimum = 0;                     ///< smallest allowed value; for integers and numbers
  double maximum = 0;                     ///< largest allowed value; for integers and numbers
  std::vector<std::string> choices = {};  ///< the allowed words of a choice

  /// Whether `minimum` and `maximum` apply.
  [[nodiscard]] bool has_range() const { return kind == ParameterKind::integer || kind == ParameterKind::number; }
};

/// Makers of parameter specifications, one for each kind.
namespace parameter {

/// Describes a parameter that is true or false.
struct Flag {
  std::string name = {};
  bool default_value = false;
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

/// Describes an integer between `minimum` and `maximum`, both allowed.
struct Integer {
  std::string name = {};
  std::int64_t default_value = 0;
  std::int64_t minimum = std::numeric_limits<std::int64_t>::min();
  std::int64_t maximum = std::numeric_limits<std::int64_t>::max();
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

/// Describes a number between `minimum` and `maximum`, both allowed, in `unit`.
struct Number {
  std::string name = {};
  std::string unit = {};
  double default_value = 0;
  double minimum = 0;
  double maximum = 0;
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

/// Describes a parameter that is one of several words.
struct Choice {
  std::string name = {};
  std::vector<std::string> choices = {};
  std::string default_value = {};  ///< empty: the first choice
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

/// Describes a path of a file or folder. The default is empty, which means none.
struct Path {
  std::string name = {};
  ParameterRole role = ParameterRole::none;
  std::string help = {};
};

/// The specification of a flag.
ParameterSpec flag(Flag declared);
/// The specification of an integer.
ParameterSpec integer(Integer declared);
/// The specification of a number.
ParameterSpec number(Number declared);
/// The specification of a choice.
ParameterSpec choice(Choice declared);
/// The specification of a path.
ParameterSpec path(Path declared);

}  // namespace parameter

/// The name of a kind, as `list --json` prints it: "flag", "integer", ...
std::string_view name_of(ParameterKind kind);
/// The name of a role: "resolution", "wanted_error", ... Empty for `none`.
std::string_view name_of(ParameterRole role);

/// Returns the parameter of that name, or nullptr. The pointer is valid as long as `specs` is.
const ParameterSpec* find_parameter(const std::vector<ParameterSpec>& specs, std::string_view name);
/// Returns the first parameter with that role, or nullptr. The pointer is valid as long as `specs` is.
const ParameterSpec* find_parameter(const std::vector<ParameterSpec>& specs, ParameterRole role);

/// A complete and checked set of parameter values. Reading is safe from several threads. The readers throw an exception
/// of the standard library for a name that is not in the set or has another type: that is a programmer's error.
class Parameters {
 public:
  /// Takes the defaults of all `specs` and overwrites them with `given`. Throws InputError for an unknown key, a value
  /// of another type, or one out of range. The error names `location` (a file and table, or `--param`), the key and the
  /// cure. For an unknown key the cure is the nearest known key.
  Parameters(const std::vector<ParameterSpec>& specs, const std::map<std::string, ParameterValue>& given,
             std::string_view location);

  [[nodiscard]] bool flag(const std::string& name) const { return std::get<bool>(m_values.at(name)); }
  [[nodiscard]] std::int64_t integer(const std::string& name) const {
    return std::get<std::int64_t>(m_values.at(name));
  }
  [[nodiscard]] double number(const std::string& name) const { return std::get<double>(m_values.at(name)); }
  /// The value of a choice or a path.
  [[nodiscard]] const std::string& word(const std::string& name) const {
    return std::get<std::string>(m_values.at(name));
  }
  /// All values by name, defaults included.
  [[nodiscard]] const std::map<std::string, ParameterValue>& values() const { return m_values; }
  /// Whether `given` contained the value. True even if it equals the default.
  [[nodiscard]] bool given(const std::string& name) const { return m_given.contains(name); }

 private:
  std::map<std::string, ParameterValue> m_values;
  std::set<std::string> m_given;
};

/// Parses `text` as a bool, an integer, a number or a word: the first of these that fits.
ParameterValue parse_parameter_value(std::string_view text);

/// Parses texts of the form `key=value`. If `specs` says that a value is a word, it stays a word even if it looks like
/// a number: `structures=2024` is a folder. Throws InputError that names `option` for a text of another
/// form and for a key that is given twice.
std::map<std::string, ParameterValue> parse_assignments(const std::vector<std::string>& texts,
                                                        const std::string& option,
                                                        const std::vector<ParameterSpec>& specs);

/// Formats a value with enough digits that parsing returns the same bits.
std::string format_parameter_value(const ParameterValue& value);

}  // namespace musclebench

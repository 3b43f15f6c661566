#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace musclebench {

using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// One parameter of a backend, an effect or the loop: what it is called, in which unit, its default and its range.
/// The type of the default is the type of the parameter. `list` prints these, scene files and `--param` are checked
/// against them.
struct ParameterSpec {
  std::string name;  ///< ends in the unit where it has one (`voxel_size_m`)
  ParameterValue default_value;
  std::string help;
  double minimum = -1e300;                ///< inclusive, numbers only
  double maximum = 1e300;                 ///< inclusive, numbers only
  std::vector<std::string> choices = {};  ///< the allowed words, strings only; empty: any
};

/// A complete, checked set of parameter values.
class Parameters {
 public:
  /// All of `specs` at their defaults, overwritten by `given`. Throws InputError that names `place` (file and table, or
  /// `--param`), the key and the cure, for an unknown key (with the nearest known one), a value of another type or out
  /// of range.
  Parameters(const std::vector<ParameterSpec>& specs, const std::map<std::string, ParameterValue>& given,
             std::string_view place);

  [[nodiscard]] bool flag(const std::string& name) const { return std::get<bool>(m_values.at(name)); }
  [[nodiscard]] std::int64_t integer(const std::string& name) const {
    return std::get<std::int64_t>(m_values.at(name));
  }
  [[nodiscard]] double number(const std::string& name) const { return std::get<double>(m_values.at(name)); }
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

/// The value so that it reads back to the same bits.
std::string format_parameter_value(const ParameterValue& value);

}  // namespace musclebench

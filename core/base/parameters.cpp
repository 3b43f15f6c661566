#include "core/base/parameters.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

const char* type_name(const ParameterValue& value) {
  static constexpr const char* names[] = {"true or false", "a whole number", "a number", "a word"};
  return names[value.index()];
}

/// An integer is welcome where a number is wanted; nothing else is converted.
ParameterValue converted(const ParameterSpec& spec, const ParameterValue& value, const std::string& key) {
  if (value.index() == spec.default_value.index()) {
    return value;
  }
  if (std::holds_alternative<double>(spec.default_value) && std::holds_alternative<std::int64_t>(value)) {
    return static_cast<double>(std::get<std::int64_t>(value));
  }
  const std::string wanted =
      spec.choices.empty() ? type_name(spec.default_value) : fmt::format("one of {}", fmt::join(spec.choices, ", "));
  throw InputError(key, fmt::format("is {}, not {}", wanted, format_parameter_value(value)));
}

void check_range(const ParameterSpec& spec, const ParameterValue& value, const std::string& key) {
  if (const auto* word = std::get_if<std::string>(&value)) {
    if (!spec.choices.empty() && std::find(spec.choices.begin(), spec.choices.end(), *word) == spec.choices.end()) {
      throw InputError(key, fmt::format("'{}' is not one of {}; did you mean '{}'?", *word,
                                        fmt::join(spec.choices, ", "), nearest_word(*word, spec.choices)));
    }
    return;
  }
  if (std::holds_alternative<bool>(value)) {
    return;
  }
  const double number = std::holds_alternative<double>(value) ? std::get<double>(value)
                                                              : static_cast<double>(std::get<std::int64_t>(value));
  if (!std::isfinite(number) || number < spec.minimum || number > spec.maximum) {
    throw InputError(key, fmt::format("{} is out of range; allowed is {} to {} ({})", format_parameter_value(value),
                                      spec.minimum, spec.maximum, spec.help));
  }
}

}  // namespace

Parameters::Parameters(const std::vector<ParameterSpec>& specs, const std::map<std::string, ParameterValue>& given,
                       std::string_view place) {
  for (const ParameterSpec& spec : specs) {
    m_values[spec.name] = spec.default_value;
  }
  for (const auto& [name, value] : given) {
    const std::string key = fmt::format("{}: {}", place, name);
    const auto spec =
        std::find_if(specs.begin(), specs.end(), [&wanted = name](const auto& s) { return s.name == wanted; });
    if (spec == specs.end()) {
      std::vector<std::string> known;
      for (const ParameterSpec& s : specs) {
        known.push_back(s.name);
      }
      throw InputError(key, known.empty() ? std::string("is unknown; there are no parameters here")
                                          : fmt::format("is unknown; did you mean '{}'?", nearest_word(name, known)));
    }
    const ParameterValue checked = converted(*spec, value, key);
    check_range(*spec, checked, key);
    m_values[name] = checked;
    m_given.insert(name);
  }
}

ParameterValue parse_parameter_value(std::string_view text) {
  if (text == "true" || text == "false") {
    return text == "true";
  }
  const char* end = text.data() + text.size();
  std::int64_t integer = 0;
  if (const auto [rest, error] = std::from_chars(text.data(), end, integer); error == std::errc{} && rest == end) {
    return integer;
  }
  double number = 0;
  if (const auto [rest, error] = std::from_chars(text.data(), end, number); error == std::errc{} && rest == end) {
    return number;
  }
  return std::string(text);
}

std::string format_parameter_value(const ParameterValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

}  // namespace musclebench

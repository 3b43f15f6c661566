#include "core/base/parameters.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <utility>

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
  if (!spec.has_range()) {
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

namespace parameter {

ParameterSpec flag(Flag declared) {
  return {.name = std::move(declared.name),
          .kind = ParameterKind::flag,
          .role = declared.role,
          .default_value = declared.default_value,
          .help = std::move(declared.help)};
}

ParameterSpec integer(Integer declared) {
  return {.name = std::move(declared.name),
          .kind = ParameterKind::integer,
          .role = declared.role,
          .default_value = declared.default_value,
          .help = std::move(declared.help),
          .minimum = static_cast<double>(declared.minimum),
          .maximum = static_cast<double>(declared.maximum)};
}

ParameterSpec number(Number declared) {
  assert(declared.minimum < declared.maximum);
  return {.name = std::move(declared.name),
          .kind = ParameterKind::number,
          .role = declared.role,
          .unit = std::move(declared.unit),
          .default_value = declared.default_value,
          .help = std::move(declared.help),
          .minimum = declared.minimum,
          .maximum = declared.maximum};
}

ParameterSpec choice(Choice declared) {
  assert(!declared.choices.empty());
  std::string chosen = declared.default_value.empty() ? declared.choices.front() : std::move(declared.default_value);
  return {.name = std::move(declared.name),
          .kind = ParameterKind::choice,
          .role = declared.role,
          .default_value = std::move(chosen),
          .help = std::move(declared.help),
          .choices = std::move(declared.choices)};
}

ParameterSpec path(Path declared) {
  return {.name = std::move(declared.name),
          .kind = ParameterKind::path,
          .role = declared.role,
          .default_value = std::string(),
          .help = std::move(declared.help)};
}

}  // namespace parameter

std::string_view name_of(ParameterKind kind) {
  static constexpr std::array<std::string_view, 5> names = {"flag", "integer", "number", "choice", "path"};
  return names[static_cast<std::size_t>(kind)];
}

std::string_view name_of(ParameterRole role) {
  static constexpr std::array<std::string_view, 5> names = {"", "resolution", "wanted_error", "storage",
                                                            "clearance_cache"};
  return names[static_cast<std::size_t>(role)];
}

const ParameterSpec* find_parameter(const std::vector<ParameterSpec>& specs, std::string_view name) {
  const auto found = std::find_if(specs.begin(), specs.end(), [&](const ParameterSpec& s) { return s.name == name; });
  return found == specs.end() ? nullptr : &*found;
}

const ParameterSpec* find_parameter(const std::vector<ParameterSpec>& specs, ParameterRole role) {
  const auto found = std::find_if(specs.begin(), specs.end(), [&](const ParameterSpec& s) { return s.role == role; });
  return found == specs.end() ? nullptr : &*found;
}

Parameters::Parameters(const std::vector<ParameterSpec>& specs, const std::map<std::string, ParameterValue>& given,
                       std::string_view location) {
  for (const ParameterSpec& spec : specs) {
    m_values[spec.name] = spec.default_value;
  }
  for (const auto& [name, value] : given) {
    const std::string key = fmt::format("{}: {}", location, name);
    const ParameterSpec* spec = find_parameter(specs, name);
    if (spec == nullptr) {
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

std::map<std::string, ParameterValue> parse_assignments(const std::vector<std::string>& texts,
                                                        const std::string& option,
                                                        const std::vector<ParameterSpec>& specs) {
  std::map<std::string, ParameterValue> values;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw InputError(fmt::format("{} {}", option, text), "has to read key=value");
    }
    const std::string key = text.substr(0, equals);
    const std::string_view value = std::string_view(text).substr(equals + 1);
    const ParameterSpec* spec = find_parameter(specs, key);
    const bool is_word = spec != nullptr && std::holds_alternative<std::string>(spec->default_value);
    if (!values.emplace(key, is_word ? ParameterValue(std::string(value)) : parse_parameter_value(value)).second) {
      throw InputError(fmt::format("{} {}", option, text), fmt::format("gives {} twice; leave one out", key));
    }
  }
  return values;
}

std::string format_parameter_value(const ParameterValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

}  // namespace musclebench

#include "core/scene/toml_table.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/scene/toml_depth.hpp"

namespace musclebench {

toml::table parse_toml(std::string_view text, const std::string& file) {
  require_shallow_keys(text, file);
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}", file, error.source().begin.line),
                     fmt::format("is not valid TOML: {}", error.description()));
  }
}

std::string TomlTable::location(std::string_view key) const {
  return fmt::format("{}{}{}", line_of(key), m_prefix.empty() ? "" : ".", key);
}

std::string TomlTable::line_of(std::string_view key) const {
  const toml::node* found = m_table->get(key);
  const auto line = (found != nullptr ? found->source() : m_table->source()).begin.line;
  return fmt::format("{}:{}: {}", m_file, line, m_prefix);
}

std::string TomlTable::location() const { return fmt::format("{}: {}", place(), m_prefix); }

std::string TomlTable::place() const { return fmt::format("{}:{}", m_file, m_table->source().begin.line); }

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, value] : *m_table) {
    keys.emplace_back(key.str());
  }
  return keys;
}

void TomlTable::refuse_key_of_the_file(const std::string& key) const {
  if (m_prefix.empty() || (key != "effects" && key != "preset" && key != "title")) return;
  const char* cure = key == "effects" ? "; with [effects.NAME] tables write auto = true below [effects] instead" : "";
  throw InputError(location(key), fmt::format("is a key of the file, and a table takes in all keys below it: put it "
                                              "above the first line that begins with [{}",
                                              cure));
}

void TomlTable::allow_only(const std::vector<std::string>& known) const {
  for (const std::string& key : keys()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      refuse_key_of_the_file(key);
      throw InputError(location(key), fmt::format("is unknown; did you mean '{}'?", nearest_word(key, known)));
    }
  }
}

const toml::node& TomlTable::node(std::string_view key) const {
  const toml::node* found = m_table->get(key);
  if (found == nullptr) {
    throw InputError(location(key), "is missing; add it");
  }
  return *found;
}

bool TomlTable::is_word(std::string_view key) const {
  const toml::node* found = m_table->get(key);
  return found != nullptr && found->is_string();
}

bool TomlTable::is_list(std::string_view key) const {
  const toml::node* found = m_table->get(key);
  return found != nullptr && found->is_array();
}

bool TomlTable::is_false(std::string_view key) const {
  const toml::node* found = m_table->get(key);
  return found != nullptr && found->is_boolean() && !found->as_boolean()->get();
}

std::string TomlTable::word(std::string_view key) const {
  const auto value = node(key).value_exact<std::string>();
  if (!value || value->empty()) {
    throw InputError(location(key), "has to be a word in quotes");
  }
  return *value;
}

std::string TomlTable::word_or(std::string_view key, const std::string& fallback) const {
  return has(key) ? word(key) : fallback;
}

std::vector<std::string> TomlTable::words(std::string_view key) const {
  const toml::array* array = node(key).as_array();
  std::vector<std::string> words;
  for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
    words.push_back(array->get(i)->value_exact<std::string>().value_or(""));
  }
  if (words.empty() || std::find(words.begin(), words.end(), "") != words.end()) {
    throw InputError(location(key), "has to be a list of words in quotes [\"a\", \"b\"]");
  }
  return words;
}

double TomlTable::number(std::string_view key, double minimum, double maximum) const {
  const auto value = node(key).value<double>();
  if (!node(key).is_number() || !value || !std::isfinite(*value) || *value < minimum || *value > maximum) {
    throw InputError(location(key), fmt::format("has to be a number from {} to {}", minimum, maximum));
  }
  return *value;
}

bool TomlTable::flag_or(std::string_view key, bool fallback) const {
  if (!has(key)) {
    return fallback;
  }
  const auto value = node(key).value_exact<bool>();
  if (!value) {
    throw InputError(location(key), "has to be true or false");
  }
  return *value;
}

Vec3 TomlTable::point_from(const toml::node& value, std::string_view key) const {
  const toml::array* array = value.as_array();
  Vec3 point = Vec3::Constant(NAN);
  if (array != nullptr && array->size() == 3) {
    for (int i = 0; i < 3; ++i) {
      const toml::node* component = array->get(static_cast<std::size_t>(i));
      point[i] = component->is_number() ? *component->value<double>() : NAN;
    }
  }
  if (!point.allFinite()) {
    throw InputError(location(key), "has to be made of three finite numbers [x, y, z]");
  }
  return point;
}

Vec3 TomlTable::point(std::string_view key) const { return point_from(node(key), key); }

std::vector<Vec3> TomlTable::points(std::string_view key) const {
  const toml::array* array = node(key).as_array();
  if (array == nullptr) {
    throw InputError(location(key), "has to be a list of points [[x, y, z], ...]");
  }
  std::vector<Vec3> points;
  for (const toml::node& value : *array) {
    points.push_back(point_from(value, key));
  }
  return points;
}

std::optional<TomlTable> TomlTable::table(std::string_view key) const {
  if (!has(key)) {
    return std::nullopt;
  }
  const toml::table* child = node(key).as_table();
  if (child == nullptr) {
    throw InputError(location(key),
                     fmt::format("has to be a table: write [{}{}{}]", m_prefix, m_prefix.empty() ? "" : ".", key));
  }
  return TomlTable(*child, m_file, m_prefix.empty() ? std::string(key) : fmt::format("{}.{}", m_prefix, key));
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  std::vector<TomlTable> children;
  if (!has(key)) {
    return children;
  }
  const toml::array* array = node(key).as_array();
  if (array == nullptr || !array->is_array_of_tables()) {
    throw InputError(location(key), fmt::format("has to be a list of tables: write [[{}]]", key));
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    children.emplace_back(*array->get(i)->as_table(), m_file, fmt::format("{}[{}]", key, i + 1));
  }
  return children;
}

std::vector<TomlTable> TomlTable::table_or_tables(std::string_view key) const {
  if (is_list(key)) {
    return tables(key);
  }
  const auto one = table(key);
  if (!one) {
    throw InputError(location(key), fmt::format("is missing; add a [{}] table with name and mesh", key));
  }
  return {*one};
}

std::map<std::string, ParameterValue> TomlTable::values() const {
  std::map<std::string, ParameterValue> values;
  for (const auto& [key, value] : *m_table) {
    const std::string name(key.str());
    refuse_key_of_the_file(name);
    if (value.is_boolean()) {
      values[name] = *value.value<bool>();
    } else if (value.is_integer()) {
      values[name] = *value.value<std::int64_t>();
    } else if (value.is_floating_point()) {
      values[name] = *value.value<double>();
    } else if (value.is_string()) {
      values[name] = *value.value<std::string>();
    } else {
      throw InputError(location(name),
                       "has to be a number, a word, true or false. A table takes in all keys below it: if this key "
                       "belongs to the scene, move the table to the end of the file");
    }
  }
  return values;
}

}  // namespace musclebench

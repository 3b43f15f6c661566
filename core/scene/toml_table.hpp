#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

#include "core/base/parameters.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// A table of a TOML file whose every access names file, line and key when it fails.
class TomlTable {
 public:
  /// `file` is for messages; `prefix` is the dotted key of the table, empty for the whole file.
  TomlTable(const toml::table& table, std::string file, std::string prefix)
      : m_table(&table), m_file(std::move(file)), m_prefix(std::move(prefix)) {}

  /// Throws InputError for a key that is not one of `known`, naming the nearest.
  void allow_only(const std::vector<std::string>& known) const;

  [[nodiscard]] bool has(std::string_view key) const { return m_table->contains(key); }
  [[nodiscard]] std::string word(std::string_view key) const;
  /// A list of words.
  [[nodiscard]] std::vector<std::string> words(std::string_view key) const;
  [[nodiscard]] std::string word_or(std::string_view key, const std::string& fallback) const;
  /// A finite number in [minimum, maximum].
  [[nodiscard]] double number(std::string_view key, double minimum, double maximum) const;
  [[nodiscard]] bool flag_or(std::string_view key, bool fallback) const;
  [[nodiscard]] Vec3 point(std::string_view key) const;
  [[nodiscard]] std::vector<Vec3> points(std::string_view key) const;
  [[nodiscard]] std::optional<TomlTable> table(std::string_view key) const;
  [[nodiscard]] std::vector<TomlTable> tables(std::string_view key) const;
  /// One `[key]`, or several `[[key]]`; at least one.
  [[nodiscard]] std::vector<TomlTable> table_or_tables(std::string_view key) const;
  /// All values of a flat table.
  [[nodiscard]] std::map<std::string, ParameterValue> values() const;
  [[nodiscard]] std::vector<std::string> keys() const;
  [[nodiscard]] bool is_word(std::string_view key) const;
  [[nodiscard]] bool is_false(std::string_view key) const;
  [[nodiscard]] bool is_list(std::string_view key) const;

  /// "file:line: dotted.key" of a key, or of the table where the key is missing.
  [[nodiscard]] std::string location(std::string_view key) const;
  /// "file:line: dotted.prefix" with the line of the key.
  [[nodiscard]] std::string line_of(std::string_view key) const;
  /// "file:line: dotted.prefix".
  [[nodiscard]] std::string location() const;
  /// "file:line" of the table.
  [[nodiscard]] std::string place() const;

 private:
  /// The likeliest mistake with it is that it stands below a table.
  void refuse_key_of_the_file(const std::string& key) const;
  [[nodiscard]] const toml::node& node(std::string_view key) const;
  [[nodiscard]] Vec3 point_from(const toml::node& value, std::string_view key) const;

  const toml::table* m_table;
  std::string m_file;
  std::string m_prefix;
};

/// Parses TOML; throws InputError with file and line.
toml::table parse_toml(std::string_view text, const std::string& file);

}  // namespace musclebench

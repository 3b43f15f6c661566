#include "core/scene/toml_depth.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

/// The end of the string that begins at `begin` with a quotation mark; the end of the text where it is never closed.
std::size_t end_of_string(std::string_view text, std::size_t begin) {
  const char quote = text[begin];
  const std::string triple(3, quote);
  const bool is_long = text.substr(begin, 3) == triple;
  const std::string_view closing = is_long ? std::string_view(triple) : text.substr(begin, 1);
  std::size_t i = begin + closing.size();
  while (i < text.size() && text.substr(i, closing.size()) != closing && (is_long || text[i] != '\n')) {
    i += quote == '"' && text[i] == '\\' ? 2 : 1;
  }
  return std::min(i + closing.size(), text.size());
}

}  // namespace

void require_shallow_keys(std::string_view text, const std::string& file) {
  constexpr int most_dots = 50;
  constexpr std::string_view ends_of_a_key = "=,[]{}\n";
  int dots = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      i = end_of_string(text, i);
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }
    dots = ends_of_a_key.find(c) != std::string_view::npos ? 0 : dots + (c == '.' ? 1 : 0);
    if (dots > most_dots) {
      throw InputError(
          fmt::format("{}:{}", file, 1 + std::count(text.begin(), text.begin() + static_cast<long>(i), '\n')),
          fmt::format("has a key of more than {} dotted parts; no scene needs one", most_dots));
    }
    ++i;
  }
}

}  // namespace musclebench

#include "core/base/input_error.hpp"

#include <algorithm>
#include <numeric>

namespace musclebench {

namespace {

/// Letters of a word that someone may have typed wrongly.
constexpr std::size_t longest_word = 200;

/// Of words that nobody types a bound: what a damaged file takes for one may have megabytes.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  if (std::max(a.size(), b.size()) > longest_word) return std::max(a.size(), b.size());
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

/// What a message quotes from a file, a key among it, may have megabytes: the middle is left out.
std::string shortened(std::string_view text) {
  constexpr std::size_t longest = 2000;
  constexpr std::size_t end = 500;  // where the cure stands
  if (text.size() <= longest) return std::string(text);
  std::string kept(text.substr(0, longest - end));
  kept += " ... ";
  kept += text.substr(text.size() - end);
  return kept;
}

/// Names of files and keys may hold anything; the message stays one line.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 127; }, ' ');
  return text;
}

}  // namespace

InputError::InputError(std::string_view location, std::string_view problem)
    : std::runtime_error(one_line(shortened(location) + ": " + shortened(problem))) {}

std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates) {
  const auto nearest = std::min_element(
      candidates.begin(), candidates.end(),
      [&](const std::string& a, const std::string& b) { return edit_distance(word, a) < edit_distance(word, b); });
  return nearest == candidates.end() ? std::string{} : *nearest;
}

}  // namespace musclebench

#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace musclebench {

/// Input that the user can correct: one line that names the location (file, key or option), what is wrong and the cure.
/// The program prints it and exits with code 2.
class InputError : public std::runtime_error {
 public:
  InputError(std::string_view location, std::string_view problem);
};

/// The candidate with the smallest edit distance to `word`; empty when there are no candidates.
std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace musclebench

#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace musclebench {

/// An error in the input that the user can correct. The text is one line: `location` (file, key or option), what is
/// wrong, and the cure. The program prints the line and exits with code 2.
class InputError : public std::runtime_error {
 public:
  InputError(std::string_view location, std::string_view problem);
};

/// Returns the candidate with the smallest edit distance to `word`, for "did you mean" messages. Returns an empty
/// string if there are no candidates.
std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace musclebench

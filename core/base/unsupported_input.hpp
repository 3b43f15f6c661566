#pragma once

#include "core/base/input_error.hpp"

namespace musclebench {

/// An input that is right, but that this backend can't take: another one can. The program prints the line and exits
/// with code 6. A study writes the reason into the backend's row and goes on.
class UnsupportedInput : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace musclebench

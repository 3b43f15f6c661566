# Run in every build: writes OUTPUT only when the state of the checkout has changed.
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=12
  OUTPUT_VARIABLE state OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(state "unknown")
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#pragma once

namespace musclebench {

inline constexpr char git_state[] = \"${state}\";

}  // namespace musclebench
")

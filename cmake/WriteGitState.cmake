# Run in every build: writes OUTPUT only when the state of the checkout has changed.
execute_process(COMMAND git -C "${SOURCE}" describe --always --abbrev=12
  OUTPUT_VARIABLE state OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
# What is measured is written into pages: a publication that goes on where it was stopped has the same program.
execute_process(COMMAND git -C "${SOURCE}" diff --quiet HEAD -- . ":!reports" ":!README.md"
  ERROR_QUIET RESULT_VARIABLE differs)
if(failed)
  set(state "unknown")
elseif(differs)
  string(APPEND state "-dirty")
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#pragma once

namespace musclebench {

inline constexpr char git_state[] = \"${state}\";

}  // namespace musclebench
")

# Effects: a folder each, and the table of those that a program is built with.

# musclebench_effect(NAME SOURCES file... [CHECKS file...] [TESTS file...])
# The folder NAME of core/effects. One of its sources defines `EffectEntry NAME_entry()` of namespace musclebench: what it
# does. CHECKS define `EffectChecks NAME_checks()`: what the checker knows of it. The file scene.toml is the scene
# `effects/NAME`, which shows it.
function(musclebench_effect name)
  cmake_parse_arguments(arg "" "" "SOURCES;CHECKS;TESTS" ${ARGN})
  foreach(kind IN ITEMS SOURCES CHECKS TESTS)
    list(TRANSFORM arg_${kind} PREPEND "${CMAKE_CURRENT_SOURCE_DIR}/")
    set_property(GLOBAL APPEND PROPERTY MUSCLEBENCH_EFFECT_${kind} ${arg_${kind}})
  endforeach()
  set_property(GLOBAL APPEND PROPERTY MUSCLEBENCH_EFFECTS ${name})
  if(arg_CHECKS)
    set_property(GLOBAL APPEND PROPERTY MUSCLEBENCH_CHECKED_EFFECTS ${name})
  endif()
endfunction()

# Writes the source FILE that defines the table of these effects, in this order. KIND, and what HEADER says of it:
#   entry    `effect_table()` of `NAME_entry()`
#   checks   `effect_checks_table()` of `NAME_checks()`
function(musclebench_write_effect_table file header kind)
  if(kind STREQUAL "entry")
    set(row "EffectSource")
    set(told "EffectEntry")
    set(table "effect_table")
  else()
    set(row "EffectChecksSource")
    set(told "EffectChecks")
    set(table "effect_checks_table")
  endif()
  set(declarations "")
  set(rows "")
  foreach(name IN LISTS ARGN)
    string(APPEND declarations "${told} ${name}_${kind}();\n")
    string(APPEND rows "      ${row}{\"${name}\", ${name}_${kind}},\n")
  endforeach()
  list(LENGTH ARGN count)
  file(GENERATE OUTPUT "${file}" CONTENT "#include <array>

#include \"${header}\"

namespace musclebench {

${declarations}
std::span<const ${row}> ${table}() {
  static constexpr std::array<${row}, ${count}> rows = {
${rows}  };
  return rows;
}

}  // namespace musclebench
")
endfunction()

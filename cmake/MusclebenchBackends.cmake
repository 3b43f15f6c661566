# Backends: a folder each, and the table of those that a program is built with.

# musclebench_backend(NAME SOURCES file... [DEPENDS target...] [PRIVATE target...])
# The library musclebench_backend_NAME of the folder NAME. One of its sources defines `BackendEntry NAME_entry()` of
# namespace musclebench; a study.toml in the folder says what studies sweep and what `advise` may try. A folder `micro`
# in it defines the library musclebench_NAME_kernels with `void register_NAME_kernels(const Scene&)`: kernels that time the
# inside of the backend.
function(musclebench_backend name)
  musclebench_library(musclebench_backend_${name} ${ARGN})
  set(study "${CMAKE_CURRENT_SOURCE_DIR}/study.toml")
  if(NOT EXISTS "${study}")
    set(study "")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}")
  endif()
  set_target_properties(musclebench_backend_${name} PROPERTIES MUSCLEBENCH_STUDY "${study}")
  if(MUSCLEBENCH_WITH_MICRO AND EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/micro/CMakeLists.txt")
    add_subdirectory(micro)
    set_property(GLOBAL APPEND PROPERTY MUSCLEBENCH_KERNELS ${name})
  endif()
endfunction()

# Folders outside the project, a backend each.
function(musclebench_add_extra_backends out)
  set(names "")
  foreach(folder IN LISTS MUSCLEBENCH_EXTRA_BACKENDS)
    get_filename_component(folder "${folder}" ABSOLUTE BASE_DIR "${CMAKE_SOURCE_DIR}")
    get_filename_component(name "${folder}" NAME)
    if(NOT EXISTS "${folder}/CMakeLists.txt")
      message(FATAL_ERROR "MUSCLEBENCH_EXTRA_BACKENDS: ${folder} has no CMakeLists.txt; give the folder of a backend")
    endif()
    add_subdirectory("${folder}" "${CMAKE_BINARY_DIR}/extra_backends/${name}")
    if(NOT TARGET musclebench_backend_${name})
      message(FATAL_ERROR "MUSCLEBENCH_EXTRA_BACKENDS: ${folder}/CMakeLists.txt has to call musclebench_backend(${name} ...)")
    endif()
    list(APPEND names ${name})
  endforeach()
  set(${out} ${names} PARENT_SCOPE)
endfunction()

# Writes the source FILE that defines `backend_table()` with these backends, in this order.
function(musclebench_write_backend_table file)
  set(declarations "")
  set(rows "")
  foreach(name IN LISTS ARGN)
    get_target_property(study musclebench_backend_${name} MUSCLEBENCH_STUDY)
    set(text "")
    if(study)
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${study}")
      file(READ "${study}" text)
    endif()
    string(APPEND declarations "BackendEntry ${name}_entry();\n")
    string(APPEND rows "      BackendSource{\"${name}\", ${name}_entry, R\"study(${text})study\"},\n")
  endforeach()
  list(LENGTH ARGN count)
  file(GENERATE OUTPUT "${file}" CONTENT "#include <array>

#include \"backends/registry.hpp\"

namespace musclebench {

${declarations}
std::span<const BackendSource> backend_table() {
  static constexpr std::array<BackendSource, ${count}> rows = {
${rows}  };
  return rows;
}

}  // namespace musclebench
")
endfunction()

# Writes the source FILE that defines `register_backend_kernels()`; LIBRARIES is set to what it calls.
function(musclebench_write_kernel_table file libraries)
  get_property(names GLOBAL PROPERTY MUSCLEBENCH_KERNELS)
  set(declarations "")
  set(calls "")
  set(linked "")
  foreach(name IN LISTS names)
    string(APPEND declarations "void register_${name}_kernels(const Scene& scene);\n")
    string(APPEND calls "  register_${name}_kernels(scene);\n")
    list(APPEND linked musclebench_${name}_kernels)
  endforeach()
  set(${libraries} ${linked} PARENT_SCOPE)
  file(GENERATE OUTPUT "${file}" CONTENT "#include \"bench/micro/micro_kernels.hpp\"

namespace musclebench {

${declarations}
void register_backend_kernels([[maybe_unused]] const Scene& scene) {
${calls}}

}  // namespace musclebench
")
endfunction()

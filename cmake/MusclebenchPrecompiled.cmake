# Precompiled headers. Reading Eigen, the standard library and GoogleTest takes four fifths of a compilation here, so a
# full build with them takes a third of the time. A source still has to include what it uses: a build with
# -DMUSCLEBENCH_PCH=OFF is what proves it.

set(musclebench_common_headers <algorithm> <array> <cmath> <cstddef> <cstdint> <filesystem> <functional> <limits> <map>
  <memory> <optional> <random> <span> <sstream> <string> <string_view> <utility> <variant> <vector> <Eigen/Core>
  <Eigen/Geometry>)

# A target whose only use is that others share its precompiled header; they have to have its compile options.
function(musclebench_precompile name)
  cmake_parse_arguments(arg "" "" "HEADERS;LINKS" ${ARGN})
  file(GENERATE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp" CONTENT "")
  add_library(${name} STATIC "${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp")
  target_link_libraries(${name} PRIVATE musclebench_settings Eigen3::Eigen ${arg_LINKS})
  target_precompile_headers(${name} PRIVATE ${musclebench_common_headers} ${arg_HEADERS})
endfunction()

function(musclebench_make_precompiled_headers)
  if(NOT MUSCLEBENCH_PCH)
    return()
  endif()
  musclebench_precompile(musclebench_pch)
  if(MUSCLEBENCH_WITH_OPENMP)
    musclebench_precompile(musclebench_pch_openmp LINKS OpenMP::OpenMP_CXX)
  endif()
  if(MUSCLEBENCH_WITH_TESTS)
    musclebench_precompile(musclebench_pch_tests HEADERS <gtest/gtest.h> LINKS musclebench_test_settings GTest::gtest_main)
  endif()
endfunction()

# musclebench_share_precompiled_headers(TARGET link-target...): of the kind that fits what TARGET links.
function(musclebench_share_precompiled_headers name)
  if(NOT TARGET musclebench_pch)
    return()
  endif()
  if(ARGN MATCHES "GTest::")
    set(kind musclebench_pch_tests)
  elseif(ARGN MATCHES "OpenMP::" AND MUSCLEBENCH_WITH_OPENMP)
    set(kind musclebench_pch_openmp)
  else()
    set(kind musclebench_pch)
  endif()
  target_precompile_headers(${name} REUSE_FROM ${kind})
endfunction()

# What `cmake --install` leaves, and `find_package(musclebench)` finds: the program, the libraries of core and backends as
# musclebench::NAME (without the prefix musclebench_), and the headers of public_headers.txt by the paths that sources
# here include.
include(CMakePackageConfigHelpers)

set(musclebench_package_dir lib/cmake/musclebench)

# Libraries of core, of backends and of backends outside the project; those of bench, datasets, tests, kernels and fuzzers are
# not for others.
function(musclebench_install_library name)
  file(RELATIVE_PATH folder "${CMAKE_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  if(folder MATCHES "^(bench|datasets)" OR folder MATCHES "/(micro|fuzz)$" OR (NOT folder MATCHES "^\\.\\." AND folder MATCHES "/tests/"))
    return()
  endif()
  string(REGEX REPLACE "^musclebench_" "" short "${name}")
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${short})
  install(TARGETS ${name} EXPORT musclebench ARCHIVE DESTINATION lib)
endfunction()

# The headers that the file LIST names, one a line.
function(musclebench_install_headers list)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${list}")
  file(STRINGS "${list}" headers REGEX "^[^#]")
  foreach(header IN LISTS headers)
    cmake_path(GET header PARENT_PATH folder)
    install(FILES "${header}" DESTINATION "include/musclebench/${folder}")
  endforeach()
endfunction()

function(musclebench_install_package)
  set_target_properties(musclebench_settings PROPERTIES EXPORT_NAME settings)
  install(TARGETS musclebench_settings EXPORT musclebench)
  install(TARGETS musclebench RUNTIME DESTINATION bin)
  musclebench_install_headers(cmake/public_headers.txt)
  install(EXPORT musclebench NAMESPACE musclebench:: FILE musclebench-targets.cmake DESTINATION ${musclebench_package_dir})
  configure_package_config_file(cmake/musclebench-config.cmake.in "${CMAKE_BINARY_DIR}/musclebench-config.cmake"
    INSTALL_DESTINATION ${musclebench_package_dir})
  write_basic_package_version_file("${CMAKE_BINARY_DIR}/musclebench-config-version.cmake" COMPATIBILITY SameMinorVersion)
  install(FILES "${CMAKE_BINARY_DIR}/musclebench-config.cmake" "${CMAKE_BINARY_DIR}/musclebench-config-version.cmake"
    DESTINATION ${musclebench_package_dir})
endfunction()

# The Python module, where pybind11 is: MUSCLEBENCH_HAS_PYTHON. Tools and packages are of Debian's interpreter, so it comes
# first.
set(MUSCLEBENCH_HAS_PYTHON OFF)
if(NOT DEFINED Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)
endif()
if(MUSCLEBENCH_WITH_PYTHON AND NOT MUSCLEBENCH_SANITIZE AND NOT MUSCLEBENCH_PREBUILT)
  find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
  if(Python3_FOUND)
    find_package(pybind11 2.10 QUIET)
    set(MUSCLEBENCH_HAS_PYTHON ${pybind11_FOUND})
  endif()
endif()

# musclebench_python_module(FOLDER SOURCES file... PACKAGE file... LINKS target...): the package FOLDER/musclebench of the build
# with the compiled module `native` and the files PACKAGE, and what `cmake --install` puts where Python looks below the prefix.
# A file of tools/musclebench keeps its place in the package; others go to its top.
function(musclebench_python_module folder)
  cmake_parse_arguments(arg "" "" "SOURCES;PACKAGE;LINKS" ${ARGN})
  pybind11_add_module(musclebench_python MODULE NO_EXTRAS ${arg_SOURCES})
  target_link_libraries(musclebench_python PRIVATE musclebench_settings ${arg_LINKS})
  set_target_properties(musclebench_python PROPERTIES OUTPUT_NAME native LIBRARY_OUTPUT_DIRECTORY "${folder}/musclebench")
  execute_process(COMMAND "${Python3_EXECUTABLE}" -c "import sysconfig; print(sysconfig.get_path('purelib').rsplit('/')[-1])"
    OUTPUT_VARIABLE kind OUTPUT_STRIP_TRAILING_WHITESPACE)  # dist-packages on Debian, else site-packages
  set(MUSCLEBENCH_PYTHON_DIR "lib/python${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}/${kind}" CACHE STRING
    "Where the Python module is installed, below the prefix")
  install(TARGETS musclebench_python LIBRARY DESTINATION "${MUSCLEBENCH_PYTHON_DIR}/musclebench")
  foreach(file IN LISTS arg_PACKAGE)
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" OUTPUT_VARIABLE path)
    file(RELATIVE_PATH place "${CMAKE_SOURCE_DIR}/tools/musclebench" "${path}")
    if(place MATCHES "^\\.\\.")
      cmake_path(GET path FILENAME place)
    endif()
    configure_file("${path}" "${folder}/musclebench/${place}" COPYONLY)
    cmake_path(GET place PARENT_PATH below)
    install(FILES "${path}" DESTINATION "${MUSCLEBENCH_PYTHON_DIR}/musclebench/${below}")
  endforeach()
endfunction()

# Run by CTest: installs BUILD into FOLDER, compares the headers with the list HEADERS, then configures, builds and runs
# PROJECT against it.
set(prefix "${FOLDER}/prefix")
set(outside "${FOLDER}/outside")
file(REMOVE_RECURSE "${prefix}" "${outside}")

function(call)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${ARGV}\n${output}")
  endif()
  message(STATUS "${output}")
endfunction()

call("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${prefix}")
file(STRINGS "${HEADERS}" wanted REGEX "^[^#]")
file(GLOB_RECURSE installed RELATIVE "${prefix}/include/musclebench" "${prefix}/include/musclebench/*")
list(SORT wanted)
list(SORT installed)
if(NOT "${installed}" STREQUAL "${wanted}")
  message(FATAL_ERROR "${HEADERS} lists\n${wanted}\nbut these were installed:\n${installed}")
endif()

call("${CMAKE_COMMAND}" -S "${PROJECT}" -B "${outside}" -G "${GENERATOR}" "-DCMAKE_PREFIX_PATH=${prefix}"
  "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_BUILD_TYPE=${BUILD_TYPE}" "-DWANTED_VERSION=${VERSION}")
call("${CMAKE_COMMAND}" --build "${outside}")
call("${outside}/outside")
call("${prefix}/bin/musclebench" --version)
if(PYTHON_DIR)
  call("${CMAKE_COMMAND}" -E env "PYTHONPATH=${prefix}/${PYTHON_DIR}" "${PYTHON}" -c
    "import musclebench; scene = musclebench.load_scene('synthetic/iliacus', loop={'frames': 3}); print(musclebench.run(scene, 'sdf'), musclebench.__file__)")
endif()

# The compile settings that every target shares, and the two ways to declare one.

add_library(musclebench_settings INTERFACE)
target_compile_features(musclebench_settings INTERFACE cxx_std_20)
target_include_directories(musclebench_settings INTERFACE
  "$<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>" "$<INSTALL_INTERFACE:include/musclebench>")
# FCL and other packaged libraries have Eigen members by value and are compiled for the baseline CPU. With -march=native
# Eigen would align them wider here than there: another layout of the same classes.
target_compile_definitions(musclebench_settings INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
# Contraction would let the compiler fuse a*b+c where it likes: results would then differ between compilers and flags.
target_compile_options(musclebench_settings INTERFACE -ffp-contract=off -fno-math-errno)
# The libraries of a program go into a module of Python, too. A linker of programs undoes what position-independent code
# would cost, but for calls that a compiler no longer inlines, as another library might replace their function.
target_compile_options(musclebench_settings INTERFACE -fPIC -fno-semantic-interposition)
# Eigen's own products are fused where FMA is there, and AVX-512 brings it: without them a state has the same bits as in
# any other build. Kernels that use such vectors are chosen when the program runs.
if(MUSCLEBENCH_NATIVE)
  include(CheckCXXCompilerFlag)
  check_cxx_compiler_flag(-mno-avx512f MUSCLEBENCH_IS_X86)
  set(MUSCLEBENCH_NATIVE_FLAGS -march=native)
  if(MUSCLEBENCH_IS_X86)
    list(APPEND MUSCLEBENCH_NATIVE_FLAGS -mno-fma -mno-fma4 -mno-avx512f)
  endif()
  target_compile_options(musclebench_settings INTERFACE ${MUSCLEBENCH_NATIVE_FLAGS})
endif()
# Of no concern to those who use an installed library.
set(warnings -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  # GCC 12 sees overlaps and overflows in std::string that are not there (its bug 105651 and what is like it).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict -Wno-stringop-overflow>
  $<$<BOOL:${MUSCLEBENCH_WERROR}>:-Werror>)
target_compile_options(musclebench_settings INTERFACE "$<BUILD_INTERFACE:${warnings}>")
option(MUSCLEBENCH_ONE_SIMD_TARGET "Compile SIMD kernels for SSE4 only, which every CPU has: for checks, not for timing" OFF)
if(MUSCLEBENCH_ONE_SIMD_TARGET)
  target_compile_definitions(musclebench_settings INTERFACE HWY_COMPILE_ONLY_STATIC)
  target_compile_options(musclebench_settings INTERFACE -march=x86-64-v2 -maes -mpclmul)
endif()
# A test may take so long; under sanitizers, on a busy machine, some need ten times their usual time.
set(MUSCLEBENCH_TEST_SECONDS 240)
if(MUSCLEBENCH_SANITIZE)
  set(MUSCLEBENCH_TEST_SECONDS 1200)
  target_compile_options(musclebench_settings INTERFACE
    -fsanitize=${MUSCLEBENCH_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(musclebench_settings INTERFACE -fsanitize=${MUSCLEBENCH_SANITIZE})
endif()

# What a test program itself computes is little: optimising it would take longer than it saves. So does the usual linker,
# where a quicker one is there. Programs that are timed keep the usual one.
add_library(musclebench_test_settings INTERFACE)
target_link_libraries(musclebench_test_settings INTERFACE musclebench_settings)
target_compile_options(musclebench_test_settings INTERFACE $<$<CONFIG:Release>:-O1>)
include(CheckLinkerFlag)
foreach(linker lld gold)
  check_linker_flag(CXX -fuse-ld=${linker} MUSCLEBENCH_HAS_${linker})
  if(MUSCLEBENCH_HAS_${linker})
    target_link_options(musclebench_test_settings INTERFACE -fuse-ld=${linker})
    break()
  endif()
endforeach()

option(MUSCLEBENCH_TESTS_BY_PROGRAM "One test of CTest for each test program, for builds whose processes start slowly" OFF)

# Highway compiles such a source once for each instruction set, by including it again, or for one alone: it stands alone.
function(musclebench_compile_simd_alone)
  foreach(source IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" OUTPUT_VARIABLE path)
    if(NOT EXISTS "${path}")  # generated
      continue()
    endif()
    file(STRINGS "${path}" dispatched REGEX "hwy/highway.h" LIMIT_COUNT 1)
    if(dispatched)
      set_source_files_properties("${source}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
endfunction()

# Sources in whose place a program may link functions of its own (bench/effects: what an effect costs that is absent).
function(musclebench_replaceable)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# musclebench_library(NAME SOURCES file... [DEPENDS target...] [PRIVATE target...])
# DEPENDS shows in the headers of NAME; PRIVATE does not, so its users cannot include it by mistake.
# MUSCLEBENCH_PREBUILT=BUILD, for a test: what that build has is linked from there, but for the table of backends.
function(musclebench_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS;PRIVATE" ${ARGN})
  file(RELATIVE_PATH folder "${CMAKE_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  set(built "${MUSCLEBENCH_PREBUILT}/${folder}/lib${name}.a")
  if(MUSCLEBENCH_PREBUILT AND EXISTS "${built}" AND NOT name STREQUAL musclebench_backends)
    add_library(${name}_built STATIC IMPORTED GLOBAL)
    set_target_properties(${name}_built PROPERTIES IMPORTED_LOCATION "${built}")
    target_link_libraries(${name}_built INTERFACE ${arg_DEPENDS} ${arg_PRIVATE})
    set(arg_SOURCES "${CMAKE_BINARY_DIR}/empty.cpp")
    file(TOUCH "${arg_SOURCES}")
    list(APPEND arg_PRIVATE ${name}_built)
  endif()
  add_library(${name} STATIC ${arg_SOURCES})
  target_link_libraries(${name} PUBLIC musclebench_settings ${arg_DEPENDS} PRIVATE ${arg_PRIVATE})
  musclebench_compile_simd_alone(${arg_SOURCES})
  musclebench_install_library(${name})
  musclebench_share_precompiled_headers(${name} ${arg_DEPENDS} ${arg_PRIVATE})
endfunction()

# musclebench_test(NAME SOURCES file... DEPENDS target... [THREADS n] [TOGETHER suite...] [SLOW filter...] [LONG filter...])
# THREADS: of the loop, which CTest has to keep cores for. Without, threads that wait give way to the tests beside them.
# TOGETHER: suites whose tests share what takes long to make: each suite is one test of CTest, in one process.
# SLOW: tests by GoogleTest's filter that get the label `slow`: under sanitizers they run weekly only.
# LONG: the same with the label `long`: `tools/test` leaves them out, too, unless it is told --all.
function(musclebench_test name)
  if(NOT MUSCLEBENCH_WITH_TESTS)
    return()
  endif()
  cmake_parse_arguments(arg "" "THREADS" "SOURCES;DEPENDS;TOGETHER;SLOW;LONG" ${ARGN})
  if(NOT arg_THREADS OR NOT MUSCLEBENCH_WITH_OPENMP)
    set(arg_THREADS 1)
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE musclebench_test_settings ${arg_DEPENDS} GTest::gtest_main)
  musclebench_share_precompiled_headers(${name} ${arg_DEPENDS} GTest::gtest_main)
  set(properties PROCESSORS ${arg_THREADS} ENVIRONMENT OMP_WAIT_POLICY=passive)
  if(MUSCLEBENCH_TESTS_BY_PROGRAM)
    math(EXPR seconds "3 * ${MUSCLEBENCH_TEST_SECONDS}")
    list(APPEND properties TIMEOUT ${seconds})
    list(JOIN arg_SLOW ":" slow)
    list(JOIN arg_LONG ":" long)
    add_test(NAME ${name} COMMAND ${name} "--gtest_filter=*-${slow}:${long}")
    set_tests_properties(${name} PROPERTIES ${properties})
    foreach(label IN ITEMS slow long)
      if(${label})
        add_test(NAME ${name}_${label} COMMAND ${name} "--gtest_filter=${${label}}")
        set_tests_properties(${name}_${label} PROPERTIES ${properties} LABELS ${label})
      endif()
    endforeach()
    return()
  endif()
  list(APPEND properties TIMEOUT ${MUSCLEBENCH_TEST_SECONDS})
  set(apart "${arg_TOGETHER}")
  foreach(suite IN LISTS arg_TOGETHER)
    add_test(NAME ${suite} COMMAND ${name} "--gtest_filter=${suite}.*")
    set_tests_properties(${suite} PROPERTIES ${properties})
    foreach(label IN ITEMS SLOW LONG)
      if("${suite}.*" IN_LIST arg_${label})
        string(TOLOWER ${label} lower)
        set_tests_properties(${suite} PROPERTIES LABELS ${lower})
        list(REMOVE_ITEM arg_${label} "${suite}.*")
      endif()
    endforeach()
  endforeach()
  list(TRANSFORM apart APPEND ".*")
  foreach(label IN ITEMS SLOW LONG)
    if(arg_${label})
      list(JOIN arg_${label} ":" filter)
      string(TOLOWER ${label} lower)
      gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 TEST_FILTER "${filter}" PROPERTIES ${properties} LABELS ${lower})
      list(APPEND apart ${arg_${label}})
    endif()
  endforeach()
  list(JOIN apart ":" apart)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 TEST_FILTER "*-${apart}" PROPERTIES ${properties})
endfunction()

# Readers of files under libFuzzer (tools/fuzz, preset fuzz), and their corpus as a test of every build.
if(MUSCLEBENCH_WITH_FUZZERS AND NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  message(FATAL_ERROR "MUSCLEBENCH_WITH_FUZZERS: libFuzzer comes with clang; take the preset fuzz")
endif()

# musclebench_fuzz_readers(LIBRARY): of a library that defines `fuzzed_readers()`, in a folder with `corpus/READER/`.
function(musclebench_fuzz_readers library)
  musclebench_test(${library}_tests
    SOURCES "${CMAKE_SOURCE_DIR}/core/fuzz/tests/corpus_test.cpp"
    DEPENDS ${library})
  if(TARGET ${library}_tests)
    target_compile_definitions(${library}_tests PRIVATE MUSCLEBENCH_CORPUS="${CMAKE_CURRENT_SOURCE_DIR}/corpus")
  endif()
  if(MUSCLEBENCH_WITH_FUZZERS)
    add_executable(${library}_fuzzer "${CMAKE_SOURCE_DIR}/core/fuzz/libfuzzer_entry.cpp")
    set_target_properties(${library}_fuzzer PROPERTIES OUTPUT_NAME fuzz_readers)
    target_link_libraries(${library}_fuzzer PRIVATE ${library})
    target_link_options(${library}_fuzzer PRIVATE -fsanitize=fuzzer)
    set_property(GLOBAL APPEND PROPERTY MUSCLEBENCH_FUZZERS ${library}_fuzzer)
  endif()
endfunction()

# All of them, as tools/fuzz builds them.
function(musclebench_add_fuzz_target)
  get_property(fuzzers GLOBAL PROPERTY MUSCLEBENCH_FUZZERS)
  if(fuzzers)
    add_custom_target(fuzzers DEPENDS ${fuzzers})
  endif()
endfunction()

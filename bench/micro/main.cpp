// The Google Benchmark kernels. They measure the scene in MUSCLEBENCH_MICRO_SCENE (default: synthetic/iliacus) and keep
// distance fields in the folder MUSCLEBENCH_MICRO_STRUCTURES, where it is given. `ns_a_point`, `ns_a_node` and
// `ns_a_step` are nanoseconds.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "bench/micro/micro_kernels.hpp"
#include "bench/micro/micro_scene.hpp"
#include "core/base/input_error.hpp"

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 2;
  }
  try {
    musclebench::register_query_kernels();
    musclebench::register_backend_kernels(musclebench::micro_scene());
    musclebench::register_detect_kernels();
    musclebench::register_size_kernels();
    musclebench::register_constraint_kernels();
    musclebench::register_loop_kernels();
    musclebench::register_allocation_kernels();
    musclebench::register_effect_kernels();
    benchmark::RunSpecifiedBenchmarks();
  } catch (const musclebench::InputError& error) {
    fmt::print(stderr, "musclebench_micro: {}\n", error.what());
    return 2;
  }
  benchmark::Shutdown();
  return 0;
}

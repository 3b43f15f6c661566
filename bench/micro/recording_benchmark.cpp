// What recording costs: one timer (a frame of the paper preset takes 45), the copy of the last detection (one a frame),
// one row of frames.csv.
#include <sstream>

#include <benchmark/benchmark.h>

#include "core/base/scoped_timer.hpp"
#include "core/measure/step_record.hpp"

namespace musclebench {
namespace {

void scoped_timer(benchmark::State& state) {
  Nanoseconds total_ns = 0;
  for (auto _ : state) {
    const ScopedTimer timer(total_ns);
  }
  benchmark::DoNotOptimize(total_ns);
}
BENCHMARK(scoped_timer);

void copy_of_last_detection(benchmark::State& state) {
  const std::vector<Vec3> positions(6931, Vec3::Ones());
  LastDetection last;
  const CollisionStep step{positions, {}, positions, {}, true};
  for (auto _ : state) {
    last.before_detection(step);
    benchmark::DoNotOptimize(last.positions.data());
  }
}
BENCHMARK(copy_of_last_detection);

void frames_csv_row(benchmark::State& state) {
  StepRecord record;
  record.times.effects_ns.assign(4, 123456);
  record.judged = true;
  record.depth = {17, 1.0 / 3000, 1.0 / 3001, 1.0 / 7000};
  record.volumes_m3 = {1.0 / 9999};
  for (auto _ : state) {
    std::ostringstream out;
    write_frames_csv(out, {"attachment", "edge_length", "volume", "bending"}, {}, {record});
    benchmark::DoNotOptimize(out.str().size());
  }
}
BENCHMARK(frames_csv_row);

}  // namespace
}  // namespace musclebench

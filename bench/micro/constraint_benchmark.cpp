// Constraints of the muscle, and the whole loop over them: in SIMD lanes, one by one (`scalar`), and by the formulas of
// another library (`published`).
#include <algorithm>
#include <cmath>
#include <random>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <hwy/targets.h>

#include "bench/cases/collider_backends.hpp"
#include "bench/micro/micro_kernels.hpp"
#include "bench/micro/micro_scene.hpp"
#include "bench/micro/published_constraints.hpp"
#include "bench/micro/scalar_loop.hpp"
#include "core/base/huge_pages.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/effects/surface_edges.hpp"

namespace musclebench {
namespace {

/// The muscle with every node 0.1 mm (standard deviation) from its rest position, so that every constraint has an
/// error.
struct Deformed {
  const TriangleMesh& mesh = micro_scene().muscle_mesh;
  std::vector<Body> bodies = micro_scene().bodies();
  std::vector<std::vector<FibreSegment>> fibres = std::vector<std::vector<FibreSegment>>(bodies.size());
  std::vector<BoundNode> bound;
  std::vector<RigidMotion> poses = std::vector<RigidMotion>(micro_scene().bones.size());
  NodeOrder order{mesh.vertices, bodies};
  EffectInput input{mesh, bodies, order, fibres, bound, poses};
  SubstepInput substep{1e-3, poses};
  std::vector<Vec3> predicted = mesh.vertices;
  std::vector<double> inverse_masses = std::vector<double>(mesh.vertices.size(), 1e4);

  Deformed() {
    std::mt19937 random(1);
    std::normal_distribution<double> jitter_m(0, 1e-4);
    for (Vec3& x : predicted) {
      x += Vec3(jitter_m(random), jitter_m(random), jitter_m(random));
    }
  }
};

std::size_t constraints_of(std::string_view effect) {
  const std::vector<SurfaceEdge> edges = surface_edges(micro_scene().muscle_mesh);
  return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), [&](const SurfaceEdge& edge) {
    return effect == "edge_length" || (edge.left >= 0 && edge.right >= 0);
  }));
}

/// Times `project` from the same deformed muscle again and again.
template <typename Restore, typename Project>
void time_projections(benchmark::State& state, std::string_view effect, const Restore& restore,
                      const Project& project) {
  std::size_t projections = 0;
  move_to_huge_pages();
  for (auto _ : state) {
    state.PauseTiming();
    restore();
    state.ResumeTiming();
    project();
    ++projections;
  }
  state.counters["ns_a_constraint"] =
      benchmark::Counter(1e-9 * static_cast<double>(projections * constraints_of(effect)),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

Parameters defaults(const std::string& effect) { return {find_effect(effect)->parameters, {}, effect}; }

void by_lanes(benchmark::State& state, const std::string& name) {
  Deformed muscle;
  const auto effect = find_effect(name)->make(muscle.input, defaults(name));
  const NodeRows start(muscle.order, muscle.predicted, muscle.inverse_masses);
  NodeRows rows = start;
  time_projections(
      state, name, [&] { rows = start; }, [&] { effect->project(rows, muscle.substep, Team()); });
}

/// As on a CPU without AVX-512.
void by_lanes_of_avx2(benchmark::State& state, const std::string& name) {
  if ((hwy::SupportedTargets() & HWY_AVX2) == 0) {
    state.SkipWithError("this CPU has no AVX2");
    return;
  }
  hwy::SetSupportedTargetsForTest(HWY_AVX2);
  by_lanes(state, name);
  hwy::SetSupportedTargetsForTest(0);
}

void one_by_one(benchmark::State& state, const std::string& name) {
  Deformed muscle;
  const auto effect = make_scalar_effect(name, muscle.input, defaults(name));
  const std::vector<Vec3> start = muscle.predicted;
  time_projections(
      state, name, [&] { muscle.predicted = start; },
      [&] { effect->project(muscle.predicted, muscle.inverse_masses, muscle.substep); });
}

std::vector<published::Length> published_lengths(const TriangleMesh& mesh) {
  std::vector<published::Length> constraints;
  for (const SurfaceEdge& edge : surface_edges(mesh)) {
    constraints.push_back({{edge.start, edge.end}, (mesh.vertices[edge.end] - mesh.vertices[edge.start]).norm()});
  }
  return constraints;
}

std::vector<published::Angle> published_angles(const TriangleMesh& mesh) {
  std::vector<published::Angle> constraints;
  for (const SurfaceEdge& edge : surface_edges(mesh)) {
    if (edge.left < 0 || edge.right < 0) continue;
    const auto normal = [&](int a, int b, int c) {
      return (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).normalized().eval();
    };
    const double cosine = normal(edge.left, edge.start, edge.end).dot(normal(edge.right, edge.end, edge.start));
    constraints.push_back({{edge.left, edge.right, edge.start, edge.end}, std::acos(std::clamp(cosine, -1.0, 1.0))});
  }
  return constraints;
}

template <typename Constraint>
void as_published(benchmark::State& state, const std::string& name, const std::vector<Constraint>& constraints) {
  Deformed muscle;
  const double stiffness = defaults(name).number("stiffness");
  const std::vector<Vec3> start = muscle.predicted;
  std::vector<Vec3>& x = muscle.predicted;
  time_projections(
      state, name, [&] { x = start; },
      [&] {
        for (const Constraint& constraint : constraints) {
          published::project(constraint, stiffness, x.data(), muscle.inverse_masses.data());
        }
        benchmark::DoNotOptimize(x.data());
      });
}

/// A simulation that is at a quarter of its motion, where the muscle touches the bones.
template <typename Loop>
void time_frames(benchmark::State& state, Loop& loop, int motion_frames) {
  const int first = motion_frames / 4;
  for (int frame = 1; frame <= first; ++frame) loop.step_frame(frame);
  move_to_huge_pages();
  int frame = first;
  for (auto _ : state) {
    frame = frame % motion_frames + 1;
    loop.step_frame(frame);
  }
  state.counters["frames_a_second"] = benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}

/// `threads` 0: the scalar loop.
void run_loop(benchmark::State& state, const std::string& preset, const std::string& name, int threads) {
  Scene scene = load_micro_scene(preset);
  scene.muscle_pairs.clear();  // the scalar loop has no contact between muscles
  const BackendEntry& entry = find_backend(name);
  const auto backend = built_backend(name, run_settings(name), scene.bones, scene.muscle_mesh, std::max(threads, 1));
  if (threads == 0) {
    ScalarLoop loop(scene, *backend, entry.default_response);
    time_frames(state, loop, scene.loop.frames);
  } else {
    const PreparedSimulation prepared = prepare_simulation(scene, *backend, {entry.default_response}, threads);
    time_frames(state, *prepared.simulation, scene.loop.frames);
  }
}

void register_loops(const std::string& backend, const std::string& preset, int timed_frames) {
  const std::string stem = fmt::format("loop/{}/{}/", preset, backend);
  for (const int threads : {0, 1, 2}) {
    const std::string name = stem + (threads == 0 ? "scalar" : std::to_string(threads));
    benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& s) { run_loop(s, preset, backend, threads); })
        ->Iterations(timed_frames)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
  }
}

/// Frames of a scene whose muscles touch each other, with its own preset.
void run_muscles(benchmark::State& state, const std::string& name, int threads) {
  const Scene scene = load_micro_scene("");
  if (scene.muscle_pairs.empty()) {
    state.SkipWithError("needs a scene whose muscles touch each other");
    return;
  }
  const BackendEntry& entry = find_backend(name);
  const auto backend = built_backend(name, run_settings(name), scene.bones, scene.muscle_mesh, threads);
  const PreparedSimulation prepared =
      prepare_simulation(scene, *backend, {entry.default_response}, threads,
                         make_contact_methods(scene, choose_collider_backends({}, scene, entry), threads));
  time_frames(state, *prepared.simulation, scene.loop.frames);
}

}  // namespace

void register_constraint_kernels() {
  for (const std::string name : {"edge_length", "bending", "volume"}) {
    const std::string stem = "constraints/" + name + "/";
    benchmark::RegisterBenchmark((stem + "lanes").c_str(), [=](benchmark::State& s) { by_lanes(s, name); });
    benchmark::RegisterBenchmark((stem + "scalar").c_str(), [=](benchmark::State& s) { one_by_one(s, name); });
  }
  benchmark::RegisterBenchmark("constraints/bending/lanes_of_avx2",
                               [](benchmark::State& s) { by_lanes_of_avx2(s, "bending"); });
  benchmark::RegisterBenchmark("constraints/edge_length/published", [](benchmark::State& s) {
    as_published(s, "edge_length", published_lengths(micro_scene().muscle_mesh));
  });
  benchmark::RegisterBenchmark("constraints/bending/published", [](benchmark::State& s) {
    as_published(s, "bending", published_angles(micro_scene().muscle_mesh));
  });
}

void register_loop_kernels() {
  std::vector<std::string> backends = raced_backends();
  backends.push_back(control_backend());
  for (const std::string& backend : backends) {
    constexpr int paper_frames = 60;
    constexpr int standard_frames = 10;
    register_loops(backend, "paper", paper_frames);
    register_loops(backend, "standard", standard_frames);
    for (const int threads : {1, 2}) {
      benchmark::RegisterBenchmark(fmt::format("muscles/{}/{}", backend, threads).c_str(),
                                   [=](benchmark::State& s) { run_muscles(s, backend, threads); })
          ->Iterations(standard_frames)
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace musclebench

// How the cost of a step grows with the nodes of the muscle and with the triangles of a bone. A step is what it is in a
// run: the bones turn on by a frame and every node moves by a few tenths of a millimetre.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "bench/micro/micro_kernels.hpp"
#include "bench/micro/micro_scene.hpp"
#include "core/base/huge_pages.hpp"
#include "core/base/scoped_timer.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/surface_sampler.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

constexpr double node_step_m = 3e-4;
constexpr std::array<std::int64_t, 4> muscle_sizes{1000, 10000, 100000, 1000000};
constexpr int coarsest = 4;  // 5,120 triangles
constexpr int finest = 8;    // 1,310,720
constexpr std::size_t near_rows = 200;

/// `count` points of the muscle's surface, neighbours close to each other as in a mesh; no triangles.
TriangleMesh sampled_muscle(std::size_t count) {
  const TriangleMesh& mesh = micro_scene().muscle_mesh;
  const SurfaceSampler sampler(mesh);
  RandomNumbers random(1);
  std::vector<SurfaceSample> samples(count);
  std::generate(samples.begin(), samples.end(), [&] { return sampler.draw(random); });
  std::stable_sort(samples.begin(), samples.end(),
                   [](const SurfaceSample& a, const SurfaceSample& b) { return a.triangle < b.triangle; });
  TriangleMesh muscle;
  for (const SurfaceSample& sample : samples) {
    muscle.vertices.push_back(sample.point);
  }
  return muscle;
}

const TriangleMesh& kept_muscle(std::int64_t nodes) {
  static std::map<std::int64_t, TriangleMesh> muscles;
  TriangleMesh& muscle = muscles[nodes];
  if (muscle.vertices.empty()) {
    muscle = sampled_muscle(static_cast<std::size_t>(nodes));
  }
  return muscle;
}

/// Nodes that swing about where they started while `poses` goes on from step to step.
class MovingNodes {
 public:
  explicit MovingNodes(const std::vector<Vec3>& start) : m_start(start), m_positions(start), m_nodes(start.size()) {
    std::iota(m_nodes.begin(), m_nodes.end(), 0);
  }

  void move() {
    ++m_step;
    for (std::size_t i = 0; i < m_start.size(); ++i) {
      const double phase = 0.3 * m_step + static_cast<double>(i % 64);
      m_positions[i] = m_start[i] + node_step_m * Vec3(std::sin(phase), std::cos(phase), std::sin(2 * phase));
    }
  }
  /// There and back by 20 frames.
  [[nodiscard]] double frame_from(double first) const { return first + std::abs(m_step % 40 - 20); }
  [[nodiscard]] const std::vector<Vec3>& positions() const { return m_positions; }
  [[nodiscard]] const std::vector<int>& nodes() const { return m_nodes; }

 private:
  const std::vector<Vec3>& m_start;
  std::vector<Vec3> m_positions;
  std::vector<int> m_nodes;
  int m_step = 0;
};

/// Times update and detection only; `poses_at` sets the poses of a step.
template <typename PosesAt>
void run_steps(benchmark::State& state, CollisionBackend& backend, const std::vector<Vec3>& start,
               const PosesAt& poses_at) {
  MovingNodes moving(start);
  std::vector<RigidMotion> poses;
  std::vector<Contact> contacts;
  Nanoseconds taken_ns = 0;
  const auto step = [&] {
    moving.move();
    poses_at(moving, poses);
    const ScopedTimer timer(taken_ns);
    backend.update(poses, moving.positions());
    backend.detect(moving.positions(), moving.nodes(), contacts);
  };
  step();  // the first finds nothing that it could build upon
  move_to_huge_pages();
  for (auto _ : state) {
    taken_ns = 0;
    step();
    state.SetIterationTime(static_cast<double>(taken_ns) * 1e-9);
  }
  state.counters["contacts"] = static_cast<double>(contacts.size());
}

void muscle_size(benchmark::State& state, const std::string& backend_name) {
  const TriangleMesh& muscle = kept_muscle(state.range(0));
  const Scene& scene = micro_scene();
  const std::unique_ptr<CollisionBackend> backend =
      built_backend(backend_name, run_settings(backend_name), scene.bones, muscle);
  run_steps(state, *backend, muscle.vertices, [&](const MovingNodes& moving, std::vector<RigidMotion>& poses) {
    scene.poses_at(moving.frame_from(scene.loop.frames / 9.0), poses);
  });
  state.counters["nodes"] = static_cast<double>(state.range(0));
}

/// About as long as wide as a bone's end, with knobs; the same shape for any number of triangles.
Vec3 knobbly(const Vec3& direction) {
  const double angle = std::atan2(direction.y(), direction.x());
  const double radius_m =
      0.05 * (1 + 0.2 * std::sin(3 * angle) * (1 - direction.z() * direction.z()) + 0.1 * std::sin(9 * direction.z()));
  return radius_m * Vec3(direction.x(), direction.y(), 3 * direction.z());
}

const Bone& knobbly_bone(int subdivisions) {
  static std::map<int, Bone> bones;
  Bone& bone = bones[subdivisions];
  if (bone.name.empty()) {
    TriangleMesh mesh = make_sphere(1, subdivisions);
    for (Vec3& vertex : mesh.vertices) {
      vertex = knobbly(vertex);
    }
    bone = {"knobbly", repair_mesh(mesh, "knobbly")};
  }
  return bone;
}

/// About the surface, up to some millimetres off, neighbours close to each other.
const std::vector<Vec3>& points_at_knobbly_bone() {
  static const std::vector<Vec3> points = [] {
    RandomNumbers random(3);
    std::vector<Vec3> made;
    for (std::size_t i = 0; i < near_rows * near_rows; ++i) {
      const double z = 2 * (static_cast<double>(i / near_rows) + 0.5) / near_rows - 1;
      const double angle = 2 * std::numbers::pi * static_cast<double>(i % near_rows) / near_rows;
      const double across = std::sqrt(1 - z * z);
      const double off = 1 + 0.1 * (random.share() - 0.3);
      made.push_back(off * knobbly({across * std::cos(angle), across * std::sin(angle), z}));
    }
    return made;
  }();
  return points;
}

int subdivisions_for(std::int64_t triangles) {
  return static_cast<int>(std::lround(std::log(static_cast<double>(triangles) / 20) / std::log(4.0)));
}

void bvh_locate(benchmark::State& state) {
  const SignedSurface surface(knobbly_bone(subdivisions_for(state.range(0))).surface);
  const std::vector<Vec3>& points = points_at_knobbly_bone();
  double sum = 0;
  move_to_huge_pages();
  for (auto _ : state) {
    for (const Vec3& point : points) {
      sum += surface.locate(point).signed_distance_m();
    }
    benchmark::DoNotOptimize(sum);
  }
  state.counters["ns_a_point"] =
      benchmark::Counter(static_cast<double>(points.size()) * 1e-9,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void bvh_step(benchmark::State& state) {
  const Bone& bone = knobbly_bone(subdivisions_for(state.range(0)));
  const TriangleMesh muscle{points_at_knobbly_bone(), {}};
  const std::string& exact = exact_backend().name;
  const std::unique_ptr<CollisionBackend> backend = built_backend(exact, run_settings(exact), {&bone, 1}, muscle);
  run_steps(state, *backend, muscle.vertices, [](const MovingNodes& moving, std::vector<RigidMotion>& poses) {
    const double angle = 0.01 * moving.frame_from(0);
    poses.assign(1, RigidMotion{});
    poses[0].rotation = Eigen::AngleAxisd(angle, Vec3::UnitX()).toRotationMatrix();
  });
}

}  // namespace

void register_size_kernels() {
  for (const std::string& name : raced_backends()) {
    auto* kernel = benchmark::RegisterBenchmark(("muscle_size/" + name).c_str(),
                                                [name](benchmark::State& s) { muscle_size(s, name); });
    for (const std::int64_t size : muscle_sizes) {
      kernel->Arg(size);
    }
    kernel->UseManualTime()->Unit(benchmark::kMicrosecond);
  }
  auto* locate = benchmark::RegisterBenchmark("bone_size/bvh_locate", bvh_locate)->Unit(benchmark::kMicrosecond);
  auto* step =
      benchmark::RegisterBenchmark("bone_size/bvh_step", bvh_step)->UseManualTime()->Unit(benchmark::kMicrosecond);
  for (int subdivisions = coarsest; subdivisions <= finest; ++subdivisions) {
    const std::int64_t triangles = 20LL << (2 * subdivisions);
    locate->Arg(triangles);
    step->Arg(triangles);
  }
}

}  // namespace musclebench

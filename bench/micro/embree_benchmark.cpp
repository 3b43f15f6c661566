// The exact closest point with sign (SignedSurface) against Embree's point query, which has no sign, on the same points
// and in one process: near the surface, where a run asks, and anywhere in the bone's box. The bone is the first of
// synthetic/iliacus, or of the scene in MUSCLEBENCH_MICRO_SCENE. One thread.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <embree3/rtcore.h>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <benchmark/benchmark.h>

#include "bench/cases/scene_source.hpp"
#include "core/base/huge_pages.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/morton_order.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

constexpr std::size_t point_count = 40000;
constexpr double jitter_m = 0.002;
constexpr double enlarged = 1.1;
/// What single precision may cost Embree, as a share of the bone's largest coordinate.
constexpr double float_share = 1e-5;

using Points = std::vector<Vec3>;
using Vec3f = Eigen::Vector3f;

const Scene& scene() {
  static const Scene loaded = [] {
    const char* name = std::getenv("MUSCLEBENCH_MICRO_SCENE");
    return load_scene({name != nullptr ? name : "synthetic/iliacus", "", "", {}});
  }();
  return loaded;
}

const TriangleMesh& bone_mesh() { return scene().bones.front().surface.mesh; }

const SignedSurface& surface() {
  static const SignedSurface built(scene().bones.front().surface);
  return built;
}

/// Vertices of the muscle, each several times, jittered, in the order of the mesh.
const Points& near_points() {
  static const Points made = [] {
    std::mt19937 random(1);
    std::normal_distribution<double> jitter(0, jitter_m);
    const std::vector<Vec3>& vertices = scene().muscle_mesh.vertices;
    Points points;
    for (std::size_t i = 0; i < point_count; ++i) {
      const Vec3& vertex = vertices[i * vertices.size() / point_count];
      const double x = jitter(random);
      const double y = jitter(random);
      points.emplace_back(vertex + Vec3(x, y, jitter(random)));
    }
    return points;
  }();
  return made;
}

const Points& far_points() {
  static const Points made = [] {
    const Eigen::AlignedBox3d box = bounding_box(bone_mesh().vertices);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> share(-0.5 * enlarged, 0.5 * enlarged);
    Points points;
    for (std::size_t i = 0; i < point_count; ++i) {
      const double x = share(random);
      const double y = share(random);
      points.emplace_back(box.center() + box.sizes().cwiseProduct(Vec3(x, y, share(random))));
    }
    return points;
  }();
  return made;
}

Points shuffled(Points points) {
  std::shuffle(points.begin(), points.end(), std::mt19937(3));
  return points;
}

/// Far points in an order in which neighbours are close.
Points in_morton_order(const Points& points) {
  Points ordered;
  ordered.reserve(points.size());
  for (const int index : morton_order(points)) {
    ordered.push_back(points[static_cast<std::size_t>(index)]);
  }
  return ordered;
}

/// The bone in Embree, and the closest distance that its point query finds with a call-back as Embree's own tutorials
/// have it.
class EmbreeSurface {
 public:
  explicit EmbreeSurface(const TriangleMesh& mesh)
      : m_device(rtcNewDevice("threads=1,set_affinity=0")), m_scene(rtcNewScene(m_device)) {
    RTCGeometry geometry = rtcNewGeometry(m_device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(unsigned), mesh.triangles.size()));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const Vec3f position = mesh.vertices[i].cast<float>();
      std::copy_n(position.data(), 3, vertices + 3 * i);
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      std::array<Vec3f, 3> corners;
      for (std::size_t i = 0; i < 3; ++i) {
        indices[3 * t + i] = static_cast<unsigned>(mesh.triangles[t][i]);
        corners[i] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])].cast<float>();
      }
      m_corners.push_back(corners);
    }
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(m_scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneBuildQuality(m_scene, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(m_scene);
  }
  EmbreeSurface(const EmbreeSurface&) = delete;
  EmbreeSurface& operator=(const EmbreeSurface&) = delete;
  ~EmbreeSurface() {
    rtcReleaseScene(m_scene);
    rtcReleaseDevice(m_device);
  }

  [[nodiscard]] float distance(const Vec3& point) const {
    RTCPointQuery query{};
    query.x = static_cast<float>(point.x());
    query.y = static_cast<float>(point.y());
    query.z = static_cast<float>(point.z());
    query.radius = std::numeric_limits<float>::infinity();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    Closest closest{m_corners.data(), std::numeric_limits<float>::infinity(), Vec3f::Zero(), 0};
    rtcPointQuery(m_scene, &query, &context, look_at, &closest);
    benchmark::DoNotOptimize(closest.point.data());
    benchmark::DoNotOptimize(closest.triangle);
    return closest.distance;
  }

 private:
  struct Closest {
    const std::array<Vec3f, 3>* corners;
    float distance;
    Vec3f point;
    unsigned triangle;
  };

  static bool look_at(RTCPointQueryFunctionArguments* arguments) {
    auto& closest = *static_cast<Closest*>(arguments->userPtr);
    const Vec3f point(arguments->query->x, arguments->query->y, arguments->query->z);
    const auto& [a, b, c] = closest.corners[arguments->primID];
    const Vec3f on_triangle = closest_point(point, a, b, c);
    const float distance = (point - on_triangle).norm();
    if (!(distance < closest.distance)) {
      return false;
    }
    closest.distance = distance;
    closest.point = on_triangle;
    closest.triangle = arguments->primID;
    arguments->query->radius = distance;
    return true;
  }

  /// By the Voronoi regions of the triangle's features (Ericson, Real-Time Collision Detection, 5.1.5).
  static Vec3f closest_point(const Vec3f& p, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const Vec3f ab = b - a;
    const Vec3f ac = c - a;
    const Vec3f ap = p - a;
    const float d1 = ab.dot(ap);
    const float d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) {
      return a;
    }
    const Vec3f bp = p - b;
    const float d3 = ab.dot(bp);
    const float d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) {
      return b;
    }
    const Vec3f cp = p - c;
    const float d5 = ab.dot(cp);
    const float d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) {
      return c;
    }
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
      return a + d1 / (d1 - d3) * ab;
    }
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
      return a + d2 / (d2 - d6) * ac;
    }
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
      return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    }
    const float scale = 1 / (va + vb + vc);
    return a + vb * scale * ab + vc * scale * ac;
  }

  RTCDevice m_device;
  RTCScene m_scene;
  std::vector<std::array<Vec3f, 3>> m_corners;
};

const EmbreeSurface& embree() {
  static const EmbreeSurface built(bone_mesh());
  return built;
}

template <typename Query>
void ask(benchmark::State& state, const Points& points, Query&& query) {
  std::size_t next = 0;
  move_to_huge_pages();
  for (auto _ : state) {
    benchmark::DoNotOptimize(query(points[next]));
    next = next + 1 < points.size() ? next + 1 : 0;
  }
}

void embree_closest(benchmark::State& state, const Points& points) {
  ask(state, points, [&](const Vec3& point) { return embree().distance(point); });
}

void our_closest(benchmark::State& state, const Points& points) {
  const TriangleBvh& tree = surface().tree();
  ask(state, points, [&](const Vec3& point) { return tree.closest_point(point)->distance_m; });
}

void our_signed(benchmark::State& state, const Points& points) {
  ask(state, points, [&](const Vec3& point) { return surface().locate(point).signed_distance_m(); });
}

/// Each search starts from the last one's triangle, as in the build of a distance field.
void our_closest_from(benchmark::State& state, const Points& points) {
  const TriangleBvh& tree = surface().tree();
  int triangle = 0;
  ask(state, points, [&](const Vec3& point) {
    const ClosestPoint found = tree.closest_point_from(point, triangle);
    triangle = found.triangle;
    return found.distance_m;
  });
}

void our_winding(benchmark::State& state, const Points& points) {
  const TriangleBvh& tree = surface().tree();
  ask(state, points, [&](const Vec3& point) { return tree.winding_number(point); });
}

/// Both must answer the same question.
bool agree(const Points& points) {
  double reach = 0;
  for (const Vec3& vertex : bone_mesh().vertices) {
    reach = std::max(reach, vertex.cwiseAbs().maxCoeff());
  }
  return std::all_of(points.begin(), points.end(), [&](const Vec3& point) {
    const double difference = embree().distance(point) - surface().locate(point).closest.distance_m;
    return std::abs(difference) <= float_share * reach;
  });
}

int register_and_run(int argc, char** argv) {
  std::vector<std::string> arguments = {argv[0], "--benchmark_enable_random_interleaving=true",
                                        "--benchmark_repetitions=7", "--benchmark_min_time=0.1",
                                        "--benchmark_report_aggregates_only=true"};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) {
    pointers.push_back(argument.data());
  }
  int count = static_cast<int>(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) {
    return 2;
  }
  const std::array<std::pair<std::string, Points>, 4> regions = {{{"near/coherent", near_points()},
                                                                  {"near/random", shuffled(near_points())},
                                                                  {"far/coherent", in_morton_order(far_points())},
                                                                  {"far/random", far_points()}}};
  for (const auto& [name, points] : regions) {
    if (!agree(points)) {
      fprintf(stderr, "Embree and SignedSurface disagree at points of %s\n", name.c_str());
      return 1;
    }
    const auto add = [&region = name, &of = points](const std::string& what, auto function) {
      benchmark::RegisterBenchmark(std::string(what).append("/").append(region).c_str(),
                                   [function, &of](benchmark::State& state) { function(state, of); });
    };
    add("embree", embree_closest);
    add("signed", our_signed);
    add("closest", our_closest);
    add("closest_from", our_closest_from);
    add("winding", our_winding);
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

}  // namespace
}  // namespace musclebench

int main(int argc, char** argv) { return musclebench::register_and_run(argc, argv); }

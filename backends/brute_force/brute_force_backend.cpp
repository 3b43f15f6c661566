#include "backends/brute_force/brute_force_backend.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/geometry/triangle_distance.hpp"

namespace musclebench {

namespace {

struct SurfacePoint {
  bool inside = false;
  double distance_m = 0;
  Vec3 normal = Vec3::Zero();  ///< outward, unit
};

SurfacePoint locate(const TriangleMesh& mesh, const Vec3& point) {
  ClosestOnTriangle closest;
  closest.squared_distance_m2 = std::numeric_limits<double>::infinity();
  Vec3 face_normal = Vec3::UnitZ();
  double angle_sum = 0;
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3& a = mesh.vertices[triangle[0]];
    const Vec3& b = mesh.vertices[triangle[1]];
    const Vec3& c = mesh.vertices[triangle[2]];
    const ClosestOnTriangle candidate = closest_on_triangle(point, a, b, c);
    if (candidate.squared_distance_m2 < closest.squared_distance_m2) {
      closest = candidate;
      face_normal = (b - a).cross(c - a);
    }
    angle_sum += solid_angle(point, a, b, c);
  }
  SurfacePoint result;
  result.inside = angle_sum > 2 * std::numbers::pi;  // winding number above one half
  result.distance_m = std::sqrt(closest.squared_distance_m2);
  const Vec3 towards = closest.point - point;
  const double length = towards.norm();
  // On the surface the way to the closest point has no direction left; the face's normal still has.
  if (length > 1e-12 * closest.point.cwiseAbs().maxCoeff()) {
    result.normal = (result.inside ? 1.0 : -1.0) / length * towards;
  } else if (const double norm = face_normal.norm(); norm > 0) {
    result.normal = face_normal / norm;
  } else {
    result.normal = Vec3::UnitZ();
  }
  return result;
}

class BruteForceBackend final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  void do_build() override {}

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_points.resize(nodes.size());
    const auto count = static_cast<std::ptrdiff_t>(nodes.size());
    for (std::size_t bone = 0; bone < bones().size(); ++bone) {
      const TriangleMesh& mesh = bones()[bone].surface.mesh;
      const RigidMotion& pose = poses()[bone];
#pragma omp parallel for num_threads(threads()) schedule(dynamic, 16)
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        m_points[i] = locate(mesh, pose.apply_inverse(positions[nodes[i]]));
      }
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (m_points[i].inside) {
          contacts.push_back(
              {nodes[i], static_cast<int>(bone), m_points[i].distance_m, pose.apply_to_direction(m_points[i].normal)});
        }
      }
    }
  }

  std::vector<SurfacePoint> m_points;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_brute_force_backend(const Parameters& /*parameters*/) {
  return std::make_unique<BruteForceBackend>();
}

std::vector<ParameterSpec> brute_force_parameters() { return {}; }

}  // namespace musclebench

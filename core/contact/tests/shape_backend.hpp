#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// A bone with a formula: signed distance and outward unit direction of a point in its rest frame.
struct Shape {
  std::function<double(const Vec3&)> signed_distance_m;
  std::function<Vec3(const Vec3&)> outward;
  double step_m = 0.1;        ///< of the backtracking out of it
  double reported_depth = 1;  ///< share of the true depth that contacts carry
};

inline Shape half_space(const Vec3& outward, double height_m = 0) {
  return {[=](const Vec3& point) { return outward.dot(point) - height_m; }, [=](const Vec3&) { return outward; }};
}

inline Shape ball(const Vec3& centre_m, double radius_m) {
  return {[=](const Vec3& point) { return (point - centre_m).norm() - radius_m; },
          [=](const Vec3& point) { return (point - centre_m).normalized(); }};
}

/// Answers exactly for shapes, a bone each, and records its queries.
class ShapeBackend final : public CollisionBackend {
 public:
  explicit ShapeBackend(std::vector<Shape> shapes, bool point_queries = true)
      : m_shapes(std::move(shapes)), m_shape_bones(m_shapes.size()), m_point_queries(point_queries) {
    build(m_shape_bones, m_no_muscle, 1);
  }

  [[nodiscard]] Capabilities capabilities() const override { return {true, m_point_queries}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }
  [[nodiscard]] double step_m(int bone) const override { return m_shapes[static_cast<std::size_t>(bone)].step_m; }

  /// Of the muscles that it was built for.
  [[nodiscard]] const TriangleMesh& surface() const { return muscle(); }

  /// The nodes of every detection, in the order of the calls.
  std::vector<std::vector<int>> queried;
  /// The positions of every detection.
  std::vector<std::vector<Vec3>> asked_at;

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    queried.emplace_back(nodes.begin(), nodes.end());
    asked_at.emplace_back(positions.begin(), positions.end());
    for (std::size_t bone = 0; bone < m_shapes.size(); ++bone) {
      for (const int node : nodes) {
        const Vec3 point = poses()[bone].apply_inverse(positions[static_cast<std::size_t>(node)]);
        const double distance_m = m_shapes[bone].signed_distance_m(point);
        if (distance_m < 0) {
          contacts.push_back({node, static_cast<int>(bone), -m_shapes[bone].reported_depth * distance_m,
                              poses()[bone].apply_to_direction(m_shapes[bone].outward(point))});
        }
      }
    }
  }

  std::vector<Shape> m_shapes;
  std::vector<Bone> m_shape_bones;
  TriangleMesh m_no_muscle;
  bool m_point_queries;
};

}  // namespace musclebench

// A backend as a user would write one outside the project: each bone is taken for a capsule. It is fast, small and far
// from the bone, and says how far. A folder with this file, its CMakeLists.txt and its study.toml is all that it takes.
#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "core/clearance/point_backend.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

/// All points no farther than `radius_m` from a segment, in the bone's rest frame.
struct Capsule {
  Vec3 middle = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  double half_length_m = 0;
  double radius_m = 0;

  [[nodiscard]] Vec3 closest_on_segment(const Vec3& point) const {
    return middle + std::clamp(axis.dot(point - middle), -half_length_m, half_length_m) * axis;
  }
  [[nodiscard]] double signed_distance_m(const Vec3& point) const {
    return (point - closest_on_segment(point)).norm() - radius_m;
  }
};

/// Along the direction in which the vertices spread most, as thick as they are far from it on average.
Capsule fit_capsule(const std::vector<Vec3>& vertices, double radius_share) {
  const auto count = static_cast<double>(vertices.size());
  Capsule capsule;
  for (const Vec3& vertex : vertices) {
    capsule.middle += vertex / count;
  }
  Mat3 spread = Mat3::Zero();
  for (const Vec3& vertex : vertices) {
    spread += (vertex - capsule.middle) * (vertex - capsule.middle).transpose();
  }
  capsule.axis = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(2);
  double reach_m = 0;
  for (const Vec3& vertex : vertices) {
    const double along_m = capsule.axis.dot(vertex - capsule.middle);
    reach_m = std::max(reach_m, std::abs(along_m));
    capsule.radius_m += (vertex - capsule.middle - along_m * capsule.axis).norm() / count;
  }
  capsule.radius_m *= radius_share;
  capsule.half_length_m = std::max(0.0, reach_m - capsule.radius_m);
  return capsule;
}

/// How far the capsule's signed distance is from the bone's anywhere within either: the largest difference at the
/// points of a grid, and what lies between them. Both distances grow by no more than the distance moved, so that is
/// twice the distance to the nearest grid point.
double error_bound_m(const Capsule& capsule, const RepairedMesh& bone) {
  constexpr int cells = 24;
  Eigen::AlignedBox3d box = bounding_box(bone.mesh.vertices);
  for (const double end_m : {-capsule.half_length_m, capsule.half_length_m}) {
    const Vec3 end = capsule.middle + end_m * capsule.axis;
    box.extend(Vec3(end.array() - capsule.radius_m)).extend(Vec3(end.array() + capsule.radius_m));
  }
  const SignedSurface surface(bone);
  const Vec3 step = box.sizes() / cells;
  double largest_m = 0;
  for (int i = 0; i < cells * cells * cells; ++i) {
    const Vec3 cell(i % cells + 0.5, i / cells % cells + 0.5, i / (cells * cells) + 0.5);
    const Vec3 point = box.min() + cell.cwiseProduct(step);
    const double difference_m = capsule.signed_distance_m(point) - surface.locate(point).signed_distance_m();
    largest_m = std::max(largest_m, std::abs(difference_m));
  }
  return largest_m + step.norm();
}

class CapsuleStructure final : public BoneStructure {
 public:
  CapsuleStructure(const Bone& bone, double radius_share)
      : m_capsule(fit_capsule(bone.surface.mesh.vertices, radius_share)),
        m_bound_m(error_bound_m(m_capsule, bone.surface)) {}

  [[nodiscard]] AnswerBound answer_bound() const override { return {m_bound_m, m_bound_m}; }
  [[nodiscard]] std::size_t bytes() const override { return sizeof(Capsule); }

  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) override {
    for (const int node : batch.nodes) {
      const Vec3 point = batch.pose.apply_inverse(batch.positions[static_cast<std::size_t>(node)]);
      const Vec3 out = point - m_capsule.closest_on_segment(point);
      const double distance_m = out.norm();
      if (distance_m > 0 && distance_m < m_capsule.radius_m) {
        contacts.push_back(
            {node, batch.bone, m_capsule.radius_m - distance_m, batch.pose.apply_to_direction(out / distance_m)});
      }
    }
  }

 private:
  Capsule m_capsule;
  double m_bound_m;
};

std::unique_ptr<CollisionBackend> make_capsule_backend(const Parameters& parameters) {
  return make_point_backend({.build = [radius_share = parameters.number("radius_share")](
                                          const Bone& bone, int /*threads*/, const ShareReport& /*report*/) {
    return std::make_unique<CapsuleStructure>(bone, radius_share);
  }});
}

}  // namespace

BackendEntry capsule_entry() {
  return {
      .name = "capsule",
      .help = "a capsule in place of each bone",
      .implementation = "capsule example 1.0, MIT",
      .default_response = ResponseKind::project,
      .parameters = {parameter::number({.name = "radius_share",
                                        .default_value = 1,
                                        .minimum = 0.1,
                                        .maximum = 2,
                                        .role = ParameterRole::resolution,
                                        .help = "radius over the mean distance of the bone's vertices from its axis"})},
      .make = make_capsule_backend};
}

}  // namespace musclebench

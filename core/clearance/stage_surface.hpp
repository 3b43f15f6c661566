#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

#include "core/contact/bone.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

/// The surface of a bone for a contact stage. Of a bone that no node is expected to touch it is built at the first
/// query that the distance to the bone's box does not answer, if there ever is one: a lower bound of the distance is a
/// clearance like any other, so that what the stage finds is the same.
template <typename Surface>
class StageSurface {
 public:
  using Make = std::function<std::shared_ptr<const Surface>(const Bone& bone)>;

  /// The bone outlives it; one that is `untouched` is closed.
  StageSurface(const Bone& bone, bool untouched, Make make)
      : m_bone(&bone), m_make(std::move(make)), m_surface(untouched ? nullptr : m_make(bone)) {
    if (!untouched) return;
    m_box = bounding_box(bone.surface.mesh.vertices);
    m_slack_m = 0.01 * m_box.diagonal().norm();  // far more than rounding
  }

  /// Lower bound of the distance of a point in the rest frame, m; 0 as soon as the surface is built.
  [[nodiscard]] double box_distance_m(const Vec3& point) const {
    return m_surface ? 0 : std::max(0.0, m_box.exteriorDistance(point) - m_slack_m);
  }

  [[nodiscard]] const Surface& get() {
    if (!m_surface) m_surface = m_make(*m_bone);
    return *m_surface;
  }
  [[nodiscard]] bool is_built() const { return m_surface != nullptr; }

 private:
  const Bone* m_bone;
  Make m_make;
  std::shared_ptr<const Surface> m_surface;
  Eigen::AlignedBox3d m_box;
  double m_slack_m = 0;
};

/// The exact signed distance for a stage.
using ExactStageSurface = StageSurface<SignedSurface>;

inline ExactStageSurface exact_stage_surface(const Bone& bone, bool untouched) {
  return {bone, untouched, &Bone::kept_signed_distance};
}

}  // namespace musclebench

// Knows FCL's types: for the .cpp files of this folder only.
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <span>

#include <fcl/narrowphase/collision_object.h>

#include "backends/fcl/fcl_model.hpp"

namespace musclebench {

/// A muscle's surface as an FCL model whose tree follows its vertices as the options say.
template <typename BoundingVolume>
class DeformingModel {
 public:
  DeformingModel(const FclOptions& options, std::span<const Vec3> rest_positions, std::span<const Triangle> triangles)
      : m_options(options),
        m_model(make_fcl_model<BoundingVolume>(rest_positions, triangles)),
        m_object(std::make_unique<fcl::CollisionObjectd>(m_model)) {
    m_object->setUserData(nullptr);
  }

  /// World frame, m; one a vertex.
  void update(std::span<const Vec3> positions) {
    double sum = 0;
    for (const Vec3& position : positions) {
      sum += position.squaredNorm();
    }
    // FCL never prunes volumes that are not numbers: it would test every triangle against every triangle.
    m_finite = std::isfinite(sum);
    if (m_finite) {
      deform(positions);
      m_model->computeLocalAABB();
      m_object->computeAABB();
    }
  }

  /// Whether the positions of the last update are: else there is nothing to collide.
  [[nodiscard]] bool finite() const { return m_finite; }
  [[nodiscard]] fcl::CollisionObjectd& object() const { return *m_object; }

  [[nodiscard]] std::size_t bytes() const {
    std::size_t sum = model_bytes(*m_model) + sizeof(fcl::CollisionObjectd);
    if (m_options.vertex_update == VertexUpdate::update) {
      sum += static_cast<std::size_t>(m_model->num_vertices) * sizeof(Vec3);
    }
    return sum;
  }

 private:
  void deform(std::span<const Vec3> positions) {
    const bool refit = m_options.tree_update != TreeUpdate::rebuild;
    const bool bottom_up = m_options.tree_update == TreeUpdate::refit;
    FclModel<BoundingVolume>& model = *m_model;
    if (m_options.vertex_update == VertexUpdate::replace) {
      model.beginReplaceModel();
      for (const Vec3& position : positions) {
        model.replaceVertex(position);
      }
      model.endReplaceModel(refit, bottom_up);
    } else {
      model.beginUpdateModel();
      for (const Vec3& position : positions) {
        model.updateVertex(position);
      }
      model.endUpdateModel(refit, bottom_up);
    }
  }

  FclOptions m_options;
  std::shared_ptr<FclModel<BoundingVolume>> m_model;
  std::unique_ptr<fcl::CollisionObjectd> m_object;
  bool m_finite = true;
};

}  // namespace musclebench

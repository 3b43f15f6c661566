// Knows FCL's types: for the .cpp files of this folder only.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <fcl/broadphase/broadphase_collision_manager.h>

#include "backends/fcl/fcl_options.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// The bones as FCL's objects, each moved by its pose, in a broad-phase manager (or none).
class BoneObjects {
 public:
  BoneObjects(BroadPhase kind, std::vector<std::shared_ptr<fcl::CollisionGeometryd>> models);

  [[nodiscard]] std::size_t size() const { return m_objects.size(); }
  [[nodiscard]] const fcl::CollisionObjectd& object(std::size_t bone) const { return *m_objects[bone]; }

  void move(std::span<const RigidMotion> poses);

  /// The bones whose boxes overlap that of `object` (with `BroadPhase::none`: all), ascending, into `bones`, which is
  /// overwritten. The user data of `object` must be null (FCL leaves them unset). Several threads may ask at once, each
  /// with its own arguments.
  void overlapping(fcl::CollisionObjectd& object, std::vector<std::size_t>& bones) const;

  /// Bytes of the objects and the manager, without the models.
  [[nodiscard]] std::size_t bytes() const;

 private:
  void refresh();

  BroadPhase m_kind;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> m_objects;
  std::vector<fcl::CollisionObjectd*> m_managed;
  std::vector<std::size_t> m_indices;  ///< what the objects' user data point to
  std::unique_ptr<fcl::BroadPhaseCollisionManagerd> m_manager;
};

}  // namespace musclebench

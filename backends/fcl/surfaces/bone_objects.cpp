#include "backends/fcl/surfaces/bone_objects.hpp"

#include <algorithm>
#include <utility>

#include <fcl/broadphase/broadphase_SaP.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision_object.h>

#include "backends/fcl/fcl_model.hpp"

namespace musclebench {

namespace {

std::unique_ptr<fcl::BroadPhaseCollisionManagerd> make_manager(BroadPhase kind) {
  switch (kind) {
    case BroadPhase::dynamic_aabb_tree:
      return std::make_unique<fcl::DynamicAABBTreeCollisionManagerd>();
    case BroadPhase::sweep_and_prune:
      return std::make_unique<fcl::SaPCollisionManagerd>();
    case BroadPhase::none:
      break;
  }
  return nullptr;
}

/// The managers hand over the two objects in either order; a bone has user data, what it is compared with has none.
bool note_bone(fcl::CollisionObjectd* first, fcl::CollisionObjectd* second, void* data) {
  const fcl::CollisionObjectd* bone = first->getUserData() != nullptr ? first : second;
  static_cast<std::vector<std::size_t>*>(data)->push_back(*static_cast<const std::size_t*>(bone->getUserData()));
  return false;
}

}  // namespace

BoneObjects::BoneObjects(BroadPhase kind, std::vector<std::shared_ptr<fcl::CollisionGeometryd>> models)
    : m_kind(kind), m_indices(models.size()), m_manager(make_manager(kind)) {
  for (std::size_t bone = 0; bone < models.size(); ++bone) {
    m_indices[bone] = bone;
    m_objects.push_back(std::make_unique<fcl::CollisionObjectd>(std::move(models[bone])));
    m_objects.back()->setUserData(&m_indices[bone]);
    m_managed.push_back(m_objects.back().get());
  }
  if (m_manager != nullptr) {
    m_manager->registerObjects(m_managed);
    m_manager->setup();
  }
}

void BoneObjects::move(std::span<const RigidMotion> poses) {
  for (std::size_t bone = 0; bone < m_objects.size(); ++bone) {
    m_objects[bone]->setTransform(to_fcl(poses[bone]));
    m_objects[bone]->computeAABB();
  }
  refresh();
}

void BoneObjects::refresh() {
  if (m_kind == BroadPhase::dynamic_aabb_tree) {
    m_manager->update();
  } else if (m_kind == BroadPhase::sweep_and_prune) {
    // FCL 0.7's SaPCollisionManager::update() is right only for boxes that move and keep their size: one that grows at
    // both ends links an end point to itself (the next update never ends), one that grows at its upper end alone is
    // left as it was. The box of a bone that turns does both, so the sorted lists are made anew.
    m_manager->clear();
    m_manager->registerObjects(m_managed);
    m_manager->setup();
  }
}

void BoneObjects::overlapping(fcl::CollisionObjectd& object, std::vector<std::size_t>& bones) const {
  bones.clear();
  if (m_kind == BroadPhase::none) {
    bones.assign(m_indices.begin(), m_indices.end());
    return;
  }
  m_manager->collide(&object, &bones, &note_bone);
  std::sort(bones.begin(), bones.end());
}

std::size_t BoneObjects::bytes() const {
  const std::size_t count = m_objects.size();
  std::size_t sum = count * (sizeof(fcl::CollisionObjectd) + sizeof(fcl::CollisionObjectd*) + sizeof(std::size_t));
  if (m_kind == BroadPhase::sweep_and_prune) {
    // An interval (object, two end points, box) and two end points (flag, owner, 3 links each way) an object, in
    // three sorted lists; FCL keeps the types private.
    const std::size_t interval = 3 * sizeof(void*) + sizeof(fcl::AABBd);
    const std::size_t end_point = 8 * sizeof(void*);
    sum += sizeof(fcl::SaPCollisionManagerd) + count * (interval + 2 * end_point + 6 * sizeof(void*));
  } else if (m_kind == BroadPhase::dynamic_aabb_tree) {
    using Node = fcl::DynamicAABBTreeCollisionManagerd::DynamicAABBNode;
    const std::size_t nodes = count == 0 ? 0 : 2 * count - 1;
    sum += sizeof(fcl::DynamicAABBTreeCollisionManagerd) + nodes * sizeof(Node) + count * 4 * sizeof(void*);
  }
  return sum;
}

}  // namespace musclebench

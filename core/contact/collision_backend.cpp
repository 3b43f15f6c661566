#include "core/contact/collision_backend.hpp"

#include <cassert>

namespace musclebench {

void CollisionBackend::build(std::span<const Bone> bones, const TriangleMesh& muscle, int threads) {
  assert(threads >= 1);
  m_bones = bones;
  m_muscle = &muscle;
  m_threads = threads;
  m_poses.assign(bones.size(), RigidMotion{});
  do_build();
}

void CollisionBackend::update(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions) {
  assert(bone_poses.size() == m_bones.size());
  m_poses.assign(bone_poses.begin(), bone_poses.end());
  do_update(positions);
}

void CollisionBackend::detect(std::span<const Vec3> positions, std::span<const int> nodes,
                              std::vector<Contact>& contacts) {
  contacts.clear();
  do_detect(positions, nodes, contacts);
}

}  // namespace musclebench

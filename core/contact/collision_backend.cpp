#include "core/contact/collision_backend.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

void CollisionBackend::build(std::span<const Bone> bones, const TriangleMesh& muscle, int threads) {
  assert(threads >= 1);
  m_bones = bones;
  m_muscle = &muscle;
  m_threads = threads;
  m_poses.assign(bones.size(), RigidMotion{});
  m_pair_ns.assign(capabilities().times_pairs ? bones.size() * m_muscles.size() : 0, 0);
  start_watch();
  do_build();
}

void CollisionBackend::expect_within(std::vector<Eigen::AlignedBox3d> boxes) {
  m_untouched.clear();
  for (const Eigen::AlignedBox3d& box : boxes) m_untouched.push_back(box.isEmpty() ? 1 : 0);
  m_expected = std::move(boxes);
}

void CollisionBackend::start_watch() {
  assert(m_untouched.empty() || m_untouched.size() == m_bones.size());
  m_watch = {};
  for (std::size_t bone = 0; bone < m_untouched.size(); ++bone) {
    if (m_untouched[bone] == 0) continue;
    const double reach_m = contact_reach_m(m_bones[bone]);
    if (!std::isfinite(reach_m)) continue;
    m_watch.add(static_cast<int>(bone), bounding_box(m_bones[bone].surface.mesh.vertices), reach_m);
  }
}

void CollisionBackend::bring_back(std::span<const int> bones) {
  for (const int bone : bones) {
    const ScopedTimer timer(m_watch.bring_back(bone).build_ns);
    do_bring_back(static_cast<std::size_t>(bone));
  }
}

void CollisionBackend::update(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions) {
  assert(bone_poses.size() == m_bones.size());
  m_poses.assign(bone_poses.begin(), bone_poses.end());
  if (m_watch.is_active()) {
    m_watch.move(m_poses);
    if (!capabilities().point_queries) bring_back(m_watch.find_near(positions, m_muscle->triangles));
  }
  do_update(positions);
}

void CollisionBackend::detect(std::span<const Vec3> positions, std::span<const int> nodes,
                              std::vector<Contact>& contacts) {
  contacts.clear();
  std::ranges::fill(m_pair_ns, Nanoseconds{0});
  if (m_watch.is_active()) {
    if (capabilities().point_queries) bring_back(m_watch.find_near(positions, nodes));
    m_watch.count_saved_queries(nodes.size());
  }
  do_detect(positions, nodes, contacts);
}

}  // namespace musclebench

#include "backends/fcl/node_queries.hpp"

#include <fcl/geometry/shape/sphere.h>

#include "backends/fcl/bone_objects.hpp"
#include "backends/fcl/fcl_model.hpp"
#include "backends/fcl/node_surface.hpp"

namespace musclebench {

namespace {

/// In the rest frame.
struct Answer {
  double depth_m = -1;  ///< negative: no contact
  Vec3 normal = Vec3::Zero();
};

Answer ask(const NodeSurface& surface, Query query, const Vec3& point) {
  if (query == Query::node_distance && surface.is_outside_box(point)) {
    return {};
  }
  const ClosestPoint closest = query == Query::node_distance ? surface.closest(point) : surface.closest_met(point);
  if (closest.triangle < 0 || !surface.contains(point, closest)) {
    return {};
  }
  const ClosestPoint settled = query == Query::node_distance ? surface.settled(point, closest) : closest;
  if (!surface.contains(point, settled)) {
    return {};
  }
  return {settled.distance_m, surface.outward(point, settled)};
}

}  // namespace

struct NodeQueries::Implementation {
  Implementation(const FclOptions& options, std::span<const Bone> bones, int thread_count)
      : query(options.query),
        threads(thread_count),
        // Only inside the bone's box can a node be inside the bone; a sphere may also touch it from outside.
        reach_m(options.query == Query::node_distance ? 0 : options.node_radius_m),
        poses(bones.size()) {
    std::vector<std::shared_ptr<fcl::CollisionGeometryd>> models;
    surfaces.reserve(bones.size());
    for (const Bone& bone : bones) {
      const TriangleMesh& mesh = bone.surface.mesh;
      with_bounding_volume(options.bounding_volume, [&](auto volume) {
        auto model = make_fcl_model<typename decltype(volume)::type>(mesh.vertices, mesh.triangles);
        structure_bytes += model_bytes(*model);
        models.push_back(std::move(model));
      });
      structure_bytes += surfaces.emplace_back(options, bone, models.back()).bytes();
    }
    objects = std::make_unique<BoneObjects>(options.broad_phase, std::move(models));
    structure_bytes += objects->bytes();
  }

  Query query;
  int threads;
  double reach_m;
  std::vector<RigidMotion> poses;
  std::vector<NodeSurface> surfaces;
  std::unique_ptr<BoneObjects> objects;
  std::vector<Answer> answers;  ///< by bone, then by index into `nodes`
  std::size_t structure_bytes = 0;
};

NodeQueries::NodeQueries(const FclOptions& options, std::span<const Bone> bones, int threads)
    : m_implementation(std::make_unique<Implementation>(options, bones, threads)) {}

NodeQueries::~NodeQueries() = default;

void NodeQueries::move_bones(std::span<const RigidMotion> poses) {
  m_implementation->poses.assign(poses.begin(), poses.end());
  m_implementation->objects->move(poses);
}

void NodeQueries::append(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) {
  Implementation& all = *m_implementation;
  all.answers.assign(all.surfaces.size() * nodes.size(), {});
  const auto count = static_cast<std::ptrdiff_t>(nodes.size());
#pragma omp parallel num_threads(all.threads)
  {
    // What FCL writes to is each thread's own.
    fcl::CollisionObjectd object(std::make_shared<fcl::Sphered>(all.reach_m));
    object.setUserData(nullptr);
    std::vector<std::size_t> near;
#pragma omp for schedule(dynamic, 16)
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const Vec3& position = positions[static_cast<std::size_t>(nodes[static_cast<std::size_t>(i)])];
      if (!position.allFinite()) {
        continue;
      }
      object.setTranslation(position);
      object.computeAABB();
      all.objects->overlapping(object, near);
      for (const std::size_t bone : near) {
        all.answers[bone * nodes.size() + static_cast<std::size_t>(i)] =
            ask(all.surfaces[bone], all.query, all.poses[bone].apply_inverse(position));
      }
    }
  }
  for (std::size_t bone = 0; bone < all.surfaces.size(); ++bone) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Answer& answer = all.answers[bone * nodes.size() + i];
      if (answer.depth_m >= 0) {
        contacts.push_back(
            {nodes[i], static_cast<int>(bone), answer.depth_m, all.poses[bone].apply_to_direction(answer.normal)});
      }
    }
  }
}

double NodeQueries::touching_m(int bone) const {
  return m_implementation->surfaces[static_cast<std::size_t>(bone)].touching_m();
}

std::size_t NodeQueries::bytes() const { return m_implementation->structure_bytes; }

}  // namespace musclebench

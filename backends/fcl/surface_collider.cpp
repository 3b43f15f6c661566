#include "backends/fcl/surface_collider.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

#include <fcl/broadphase/broadphase_SaP.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

// The library was compiled for the baseline CPU. A wider alignment here (-march=native without
// EIGEN_MAX_ALIGN_BYTES=16) would give CollisionObject another layout than it has inside the library.
static_assert(alignof(fcl::Transform3d) == 16, "compile with EIGEN_MAX_ALIGN_BYTES=16, as FCL was");

fcl::Transform3d to_fcl(const RigidMotion& motion) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.linear() = motion.rotation;
  transform.translation() = motion.translation_m;
  return transform;
}

/// A broad-phase manager and what it manages.
class ObjectManager {
 public:
  explicit ObjectManager(BroadPhase kind) : m_kind(kind) {
    if (kind == BroadPhase::dynamic_aabb_tree) {
      m_manager = std::make_unique<fcl::DynamicAABBTreeCollisionManagerd>();
    } else {
      m_manager = std::make_unique<fcl::SaPCollisionManagerd>();
    }
  }

  void fill(std::vector<fcl::CollisionObjectd*> objects) {
    m_objects = std::move(objects);
    m_manager->registerObjects(m_objects);
    m_manager->setup();
  }

  /// Takes over the boxes of the objects.
  void refresh() {
    if (m_kind == BroadPhase::dynamic_aabb_tree) {
      m_manager->update();
      return;
    }
    // FCL 0.7's SaPCollisionManager::update() is right only for boxes that move and keep their size: one that grows at
    // both ends links an end point to itself (the next update never ends), one that grows at its upper end alone is
    // left as it was. A muscle does both, so the sorted lists are made anew.
    m_manager->clear();
    m_manager->registerObjects(m_objects);
    m_manager->setup();
  }

  void collide(ObjectManager& other, void* data, fcl::CollisionCallBack<double> callback) {
    m_manager->collide(other.m_manager.get(), data, callback);
  }

  [[nodiscard]] std::size_t bytes() const {
    const std::size_t count = m_objects.size();
    const std::size_t listed = count * sizeof(fcl::CollisionObjectd*);
    if (m_kind == BroadPhase::sweep_and_prune) {
      // An interval (object, two end points, box) and two end points (flag, owner, 3 links each way) an object, in
      // three sorted lists; FCL keeps the types private.
      const std::size_t interval = 3 * sizeof(void*) + sizeof(fcl::AABBd);
      const std::size_t end_point = 8 * sizeof(void*);
      return sizeof(fcl::SaPCollisionManagerd) + listed + count * (interval + 2 * end_point + 6 * sizeof(void*));
    }
    using Node = fcl::DynamicAABBTreeCollisionManagerd::DynamicAABBNode;
    const std::size_t nodes = count == 0 ? 0 : 2 * count - 1;
    return sizeof(fcl::DynamicAABBTreeCollisionManagerd) + listed + nodes * sizeof(Node) + count * 4 * sizeof(void*);
  }

 private:
  BroadPhase m_kind;
  std::unique_ptr<fcl::BroadPhaseCollisionManagerd> m_manager;
  std::vector<fcl::CollisionObjectd*> m_objects;
};

template <typename BoundingVolume>
using Model = fcl::BVHModel<BoundingVolume>;

template <typename BoundingVolume>
std::shared_ptr<Model<BoundingVolume>> make_model(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  const std::vector<Vec3> points(vertices.begin(), vertices.end());
  std::vector<fcl::Triangle> corners;
  corners.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    corners.emplace_back(static_cast<std::size_t>(triangle[0]), static_cast<std::size_t>(triangle[1]),
                         static_cast<std::size_t>(triangle[2]));
  }
  auto model = std::make_shared<Model<BoundingVolume>>();
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
  model->addSubModel(points, corners);
  model->endModel();
  return model;
}

/// BVHModel::memUsage() answers an error code, so its arrays are counted here. A model of n triangles allocates 2 n - 1
/// nodes and as many primitive indices, though only n of these are used.
template <typename BoundingVolume>
std::size_t model_bytes(const Model<BoundingVolume>& model) {
  const auto triangles = static_cast<std::size_t>(model.num_tris);
  const auto vertices = static_cast<std::size_t>(model.num_vertices);
  const std::size_t nodes = 2 * triangles - 1;
  return sizeof(Model<BoundingVolume>) + nodes * (sizeof(fcl::BVNode<BoundingVolume>) + sizeof(unsigned int)) +
         triangles * sizeof(fcl::Triangle) + vertices * sizeof(Vec3) + sizeof(fcl::detail::BVSplitter<BoundingVolume>) +
         sizeof(fcl::detail::BVFitter<BoundingVolume>);
}

template <typename BoundingVolume>
class FclSurfaceCollider final : public SurfaceCollider {
 public:
  FclSurfaceCollider(const ColliderOptions& options, std::span<const Bone> bones, std::span<const Vec3> rest_positions,
                     std::span<const Triangle> muscle_triangles)
      : m_options(options),
        m_request(std::numeric_limits<std::size_t>::max()),
        m_muscle_model(make_model<BoundingVolume>(rest_positions, muscle_triangles)),
        m_muscle(m_muscle_model),
        m_muscle_manager(options.broad_phase),
        m_bone_manager(options.broad_phase),
        m_bone_indices(bones.size()) {
    m_muscle.setUserData(nullptr);
    m_muscle_manager.fill({&m_muscle});
    std::vector<fcl::CollisionObjectd*> objects;
    for (std::size_t i = 0; i < bones.size(); ++i) {
      const TriangleMesh& mesh = bones[i].surface.mesh;
      m_bone_models.push_back(make_model<BoundingVolume>(mesh.vertices, mesh.triangles));
      m_bones.push_back(std::make_unique<fcl::CollisionObjectd>(m_bone_models.back()));
      m_bone_indices[i] = i;
      m_bones.back()->setUserData(&m_bone_indices[i]);
      objects.push_back(m_bones.back().get());
    }
    m_bone_manager.fill(std::move(objects));
  }

  void update(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions) override {
    for (std::size_t i = 0; i < m_bones.size(); ++i) {
      m_bones[i]->setTransform(to_fcl(bone_poses[i]));
      m_bones[i]->computeAABB();
    }
    m_bone_manager.refresh();

    double sum = 0;
    for (const Vec3& position : positions) {
      sum += position.squaredNorm();
    }
    // FCL never prunes volumes that are not numbers: it would test every triangle against every triangle.
    m_finite = std::isfinite(sum);
    if (m_finite) {
      deform_muscle(positions);
      m_muscle_model->computeLocalAABB();
      m_muscle.computeAABB();
      m_muscle_manager.refresh();
    }
  }

  void collide(std::vector<std::vector<TrianglePair>>& pairs_by_bone) override {
    pairs_by_bone.resize(m_bones.size());
    for (auto& pairs : pairs_by_bone) {
      pairs.clear();
    }
    if (m_finite) {
      Call call{*this, pairs_by_bone};
      m_muscle_manager.collide(m_bone_manager, &call, &on_overlap);
    }
  }

  [[nodiscard]] std::size_t bytes() const override {
    std::size_t sum = model_bytes(*m_muscle_model) + (m_bones.size() + 1) * sizeof(fcl::CollisionObjectd) +
                      m_muscle_manager.bytes() + m_bone_manager.bytes();
    if (m_options.vertex_update == VertexUpdate::update) {
      sum += static_cast<std::size_t>(m_muscle_model->num_vertices) * sizeof(Vec3);
    }
    for (const auto& model : m_bone_models) {
      sum += model_bytes(*model);
    }
    return sum;
  }

 private:
  struct Call {
    FclSurfaceCollider& self;
    std::vector<std::vector<TrianglePair>>& pairs_by_bone;
  };

  void deform_muscle(std::span<const Vec3> positions) {
    const bool refit = m_options.tree_update != TreeUpdate::rebuild;
    const bool bottom_up = m_options.tree_update == TreeUpdate::refit;
    Model<BoundingVolume>& model = *m_muscle_model;
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

  /// The managers hand over the two objects in either order; a bone has user data, the muscle none.
  static bool on_overlap(fcl::CollisionObjectd* first, fcl::CollisionObjectd* second, void* data) {
    const Call& call = *static_cast<Call*>(data);
    fcl::CollisionObjectd* bone = first->getUserData() != nullptr ? first : second;
    const std::size_t index = *static_cast<const std::size_t*>(bone->getUserData());
    call.self.collide_bone(*bone, call.pairs_by_bone[index]);
    return false;
  }

  void collide_bone(const fcl::CollisionObjectd& bone, std::vector<TrianglePair>& pairs) {
    m_result.clear();
    fcl::collide(&m_muscle, &bone, m_request, m_result);
    for (std::size_t i = 0; i < m_result.numContacts(); ++i) {
      // Only the indices: with boxes that are not oriented, o1 and o2 point to copies that FCL has deleted by now.
      const fcl::Contactd& contact = m_result.getContact(i);
      pairs.push_back({static_cast<int>(contact.b1), static_cast<int>(contact.b2)});
    }
  }

  ColliderOptions m_options;
  fcl::CollisionRequestd m_request;
  fcl::CollisionResultd m_result;
  std::shared_ptr<Model<BoundingVolume>> m_muscle_model;
  fcl::CollisionObjectd m_muscle;
  ObjectManager m_muscle_manager;
  ObjectManager m_bone_manager;
  std::vector<std::shared_ptr<Model<BoundingVolume>>> m_bone_models;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> m_bones;
  std::vector<std::size_t> m_bone_indices;
  bool m_finite = true;
};

using Maker = std::unique_ptr<SurfaceCollider> (*)(const ColliderOptions&, std::span<const Bone>, std::span<const Vec3>,
                                                   std::span<const Triangle>);

template <typename BoundingVolume>
std::unique_ptr<SurfaceCollider> make(const ColliderOptions& options, std::span<const Bone> bones,
                                      std::span<const Vec3> rest_positions, std::span<const Triangle> triangles) {
  return std::make_unique<FclSurfaceCollider<BoundingVolume>>(options, bones, rest_positions, triangles);
}

struct NamedMaker {
  const char* name;
  Maker make;
};

constexpr NamedMaker named_makers[] = {
    {"OBBRSS", &make<fcl::OBBRSSd>}, {"OBB", &make<fcl::OBBd>},   {"RSS", &make<fcl::RSSd>},
    {"kIOS", &make<fcl::kIOSd>},     {"AABB", &make<fcl::AABBd>}, {"KDOP24", &make<fcl::KDOPd<24>>},
};

}  // namespace

const std::vector<std::string>& bounding_volumes() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const NamedMaker& maker : named_makers) {
      all.emplace_back(maker.name);
    }
    return all;
  }();
  return names;
}

void check_collider_options(const ColliderOptions& options) {
  if (options.bounding_volume == "RSS" && options.tree_update == TreeUpdate::refit) {
    throw InputError(
        "fcl: update",
        "FCL 0.7 merges RSS volumes wrongly in a bottom-up refit and then finds no contacts; take update = "
        "rebuild or refit_top_down, or another bounding_volume");
  }
}

std::unique_ptr<SurfaceCollider> make_surface_collider(const ColliderOptions& options, std::span<const Bone> bones,
                                                       std::span<const Vec3> rest_positions,
                                                       std::span<const Triangle> muscle_triangles) {
  check_collider_options(options);
  for (const NamedMaker& maker : named_makers) {
    if (options.bounding_volume == maker.name) {
      return maker.make(options, bones, rest_positions, muscle_triangles);
    }
  }
  throw InputError("fcl: bounding_volume", "'" + options.bounding_volume + "' is unknown; did you mean '" +
                                               nearest_word(options.bounding_volume, bounding_volumes()) + "'?");
}

}  // namespace musclebench

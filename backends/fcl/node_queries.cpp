#include "backends/fcl/node_queries.hpp"

#include <cmath>
#include <limits>

#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include "backends/fcl/bone_objects.hpp"
#include "backends/fcl/fcl_model.hpp"
#include "core/geometry/pseudo_normals.hpp"

namespace musclebench {

namespace {

constexpr std::size_t all_contacts = std::numeric_limits<std::size_t>::max();

/// As a share of the bone's diagonal: above the rounding of a position, far below any depth that matters.
constexpr double touching_share = 1e-12;

/// What FCL answers for a node in a bone's rest frame.
struct Nearest {
  int triangle = -1;  ///< -1: none
  double distance_m = 0;
  Vec3 point = Vec3::Zero();
};

struct Answer {
  double depth_m = -1;  ///< negative: no contact
  Vec3 normal = Vec3::Zero();
};

double diagonal_m(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) {
    box.extend(vertex);
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

/// One bone's model, asked about points in its rest frame. All questions may be asked by several threads at once.
class BoneQueries {
 public:
  BoneQueries(const FclOptions& options, const TriangleMesh& mesh, std::shared_ptr<fcl::CollisionGeometryd> model)
      : m_mesh(mesh),
        m_normals(mesh),
        m_model(std::move(model)),
        m_solver(to_fcl(options.narrow_phase)),
        m_touching_m(touching_share * diagonal_m(mesh)),
        m_by_distance(options.query == Query::node_distance),
        m_sphere(m_by_distance ? 0 : options.node_radius_m),
        m_touching_sphere(m_touching_m) {}

  [[nodiscard]] double touching_m() const { return m_touching_m; }
  /// Without the model.
  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + m_normals.bytes(); }

  [[nodiscard]] Answer ask(const Vec3& point) const {
    const Nearest nearest = m_by_distance ? closest_triangle(point) : closest_met(point, m_sphere);
    if (nearest.triangle < 0 || !(nearest.distance_m > m_touching_m) || !is_inside(point, nearest.triangle)) {
      return {};
    }
    // Where a point lies in a triangle, FCL 0.7 leaves that triangle's distance unset, and names another one or this
    // one with any distance. FCL's collision is sound there.
    if (m_by_distance && closest_met(point, m_touching_sphere).triangle >= 0) {
      return {};
    }
    return {nearest.distance_m, (nearest.point - point) / (nearest.point - point).norm()};
  }

 private:
  [[nodiscard]] Nearest closest_triangle(const Vec3& point) const {
    const fcl::DistanceRequestd request(true, false, 0, 0, 1e-6, m_solver);
    fcl::DistanceResultd result;
    fcl::distance(m_model.get(), fcl::Transform3d::Identity(), &m_sphere, at(point), request, result);
    return {static_cast<int>(result.b1), result.min_distance, result.nearest_points[0]};
  }

  /// The closest of the triangles that `sphere` about `point` meets; at equal distances the smallest index.
  [[nodiscard]] Nearest closest_met(const Vec3& point, const fcl::Sphered& sphere) const {
    fcl::CollisionRequestd request(all_contacts, true);
    request.gjk_solver_type = m_solver;
    fcl::CollisionResultd result;
    fcl::collide(m_model.get(), fcl::Transform3d::Identity(), &sphere, at(point), request, result);
    Nearest nearest{-1, std::numeric_limits<double>::infinity(), Vec3::Zero()};
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      const fcl::Contactd& contact = result.getContact(i);
      const auto triangle = static_cast<int>(contact.b1);
      const double distance_m = (contact.pos - point).norm();
      if (distance_m < nearest.distance_m || (distance_m == nearest.distance_m && triangle < nearest.triangle)) {
        nearest = {triangle, distance_m, contact.pos};
      }
    }
    return nearest;
  }

  [[nodiscard]] bool is_inside(const Vec3& point, int triangle) const {
    const Triangle& corners = m_mesh.triangles[static_cast<std::size_t>(triangle)];
    const auto corner = [&](std::size_t i) { return m_mesh.vertices[static_cast<std::size_t>(corners[i])]; };
    const ClosestOnTriangle closest = closest_on_triangle(point, corner(0), corner(1), corner(2));
    return m_normals.is_inside(point, closest.point, triangle, closest.feature);
  }

  [[nodiscard]] static fcl::Transform3d at(const Vec3& point) {
    fcl::Transform3d transform = fcl::Transform3d::Identity();
    transform.translation() = point;
    return transform;
  }

  const TriangleMesh& m_mesh;
  PseudoNormals m_normals;
  std::shared_ptr<fcl::CollisionGeometryd> m_model;
  fcl::GJKSolverType m_solver;
  double m_touching_m;
  bool m_by_distance;
  fcl::Sphered m_sphere;
  fcl::Sphered m_touching_sphere;
};

}  // namespace

struct NodeQueries::Implementation {
  Implementation(const FclOptions& options, std::span<const Bone> bones, int thread_count)
      : threads(thread_count),
        // Only inside the bone's box can a node be inside the bone; a sphere may also touch it from outside.
        reach_m(options.query == Query::node_distance ? 0 : options.node_radius_m),
        poses(bones.size()) {
    std::vector<std::shared_ptr<fcl::CollisionGeometryd>> models;
    for (const Bone& bone : bones) {
      const TriangleMesh& mesh = bone.surface.mesh;
      with_bounding_volume(options.bounding_volume, [&](auto volume) {
        auto model = make_fcl_model<typename decltype(volume)::type>(mesh.vertices, mesh.triangles);
        structure_bytes += model_bytes(*model);
        models.push_back(std::move(model));
      });
      queries.push_back(std::make_unique<BoneQueries>(options, mesh, models.back()));
      structure_bytes += queries.back()->bytes();
    }
    objects = std::make_unique<BoneObjects>(options.broad_phase, std::move(models));
    structure_bytes += objects->bytes();
  }

  int threads;
  double reach_m;
  std::vector<RigidMotion> poses;
  std::vector<std::unique_ptr<BoneQueries>> queries;
  std::unique_ptr<BoneObjects> objects;
  std::vector<Answer> answers;  ///< by bone, then place in `nodes`
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
  all.answers.assign(all.queries.size() * nodes.size(), {});
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
            all.queries[bone]->ask(all.poses[bone].apply_inverse(position));
      }
    }
  }
  for (std::size_t bone = 0; bone < all.queries.size(); ++bone) {
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
  return m_implementation->queries[static_cast<std::size_t>(bone)]->touching_m();
}

std::size_t NodeQueries::bytes() const { return m_implementation->structure_bytes; }

}  // namespace musclebench

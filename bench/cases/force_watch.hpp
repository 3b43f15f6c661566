#pragma once

#include <string>
#include <vector>

#include "core/contact/response.hpp"
#include "core/measure/force_record.hpp"
#include "core/pbd/simulation.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// Why forces of a run would mean nothing; empty where they mean something. Each is a sentence that names the cure.
struct ForceObstacles {
  std::string contacts;     ///< of the contacts' forces
  std::string attachments;  ///< of the attachments' forces

  /// Of both, one after the other, without repetition.
  [[nodiscard]] std::string text() const;
};

/// The obstacles in a scene, given the kinds of its responses (`Scene::responses`).
ForceObstacles force_obstacles(const Scene& scene, const std::vector<ResponseKind>& responses);

/// The contact of nodes in one frame.
struct NodeForces {
  std::vector<Vec3> forces_n;  ///< by node, of all contacts, world frame
  std::vector<double>
      pressures_pa;  ///< by node: its pushes along normals over its area, which faces them; 0 for an attached node
};

/// Tells the forces of each frame of a coupled run. It looks on and changes no bit of the motion.
class ForceWatch {
 public:
  /// `scene` outlives this. `bound`: the attached nodes. From here on the simulation records its impulses.
  ForceWatch(const Scene& scene, const std::vector<BoundNode>& bound, const ForceObstacles& obstacles,
             Simulation& simulation);

  /// The forces of the frame that the simulation has just done: contacts of each muscle, its attachments, then joints.
  /// Without those that have an obstacle.
  [[nodiscard]] std::vector<ForceRow> frame(int number, const Simulation& simulation) const;
  /// The same at nodes; before the first frame there are no forces. Empty where contacts have an obstacle.
  [[nodiscard]] NodeForces at_nodes(const Simulation& simulation) const;

 private:
  /// Nodes of one muscle that one bone carries.
  struct Carried {
    std::string name;
    std::size_t muscle;
    int bone;
    std::vector<int> nodes;
  };
  /// A line in the world.
  struct Axis {
    Vec3 centre_m;
    Vec3 direction;
  };

  void carry(const std::vector<BoundNode>& bound);
  [[nodiscard]] std::optional<double> torque_n_m(int bone, const Vec3& moment_n_m, const Vec3& force_n) const;
  void list_triangles_of_nodes();
  /// A third of the triangles about a node, as seen along its push: those beside a rim do not count.
  [[nodiscard]] double area_facing_m2(int node, const Vec3& push_n, std::span<const Vec3> positions) const;

  const Scene& m_scene;
  ForceObstacles m_obstacles;
  std::vector<Body> m_bodies;
  std::vector<Carried> m_carried;
  std::vector<std::optional<Axis>> m_axes;  ///< by bone
  /// The triangles about a node are those from `m_first_triangle[node]` on in `m_triangles`.
  std::vector<std::size_t> m_first_triangle;
  std::vector<std::size_t> m_triangles;
};

}  // namespace musclebench

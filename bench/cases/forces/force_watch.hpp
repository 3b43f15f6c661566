#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/cases/forces/facing_areas.hpp"
#include "bench/cases/forces/force_obstacles.hpp"
#include "core/measure/force_record.hpp"
#include "core/pbd/simulation.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// The contact of nodes in one frame.
struct NodeForces {
  std::vector<Vec3> forces_n;  ///< by node, of all contacts, world frame
  /// By node: the sum over colliders of its push along normals over the area that faces it.
  std::vector<double> pressures_pa;
};

/// Tells the forces of each frame of a coupled run. It looks on and changes no bit of the motion.
class ForceWatch {
 public:
  /// `scene` outlives this. `bound`: the attached nodes. From here on the simulation records its impulses.
  ForceWatch(const Scene& scene, const std::vector<BoundNode>& bound, const ForceObstacles& obstacles,
             Simulation& simulation);

  /// The forces of the frame that the simulation has just done: contacts of each muscle, its attachments, retinacula,
  /// then joints. Without those that have an obstacle.
  [[nodiscard]] std::vector<ForceRow> frame(int number, const Simulation& simulation) const;
  /// The same at nodes; before the first frame there are no forces. Empty where contacts have an obstacle.
  [[nodiscard]] NodeForces at_nodes(const Simulation& simulation) const;
  /// The pushes at nodes, carried over to the vertices of bones: those that are pressed, by bone. Empty where contacts
  /// have an obstacle.
  [[nodiscard]] std::vector<BoneVertexRow> on_bones(const Simulation& simulation) const;

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

  /// A force and its moment about the origin of the world.
  struct Load {
    Vec3 force_n = Vec3::Zero();
    Vec3 moment_n_m = Vec3::Zero();
    double size_n = 0;  ///< sum of the sizes of its parts
    Vec3 at_sum_n_m = Vec3::Zero();

    void add(const Vec3& at_m, const Vec3& part_n);
    void add(const Load& other);
    /// The mean of where its parts act, by their sizes.
    [[nodiscard]] Vec3 at_m() const { return size_n > 0 ? Vec3(at_sum_n_m / size_n) : Vec3::Zero(); }
  };
  /// A row, and what the force that it tells does to the other side.
  struct Told {
    ForceRow row;
    Load on_other;
  };

  void carry(const std::vector<BoundNode>& bound);
  [[nodiscard]] Told contact(std::size_t muscle, std::size_t collider, const Simulation& simulation) const;
  [[nodiscard]] Told attachment(const Carried& carried, const Simulation& simulation) const;
  /// Of all retinacula, in their order; nothing where no effect holds tendons in them.
  [[nodiscard]] std::vector<Told> retinacula(const Simulation& simulation) const;
  [[nodiscard]] std::optional<double> torque_n_m(int bone, const Load& load) const;

  const Scene& m_scene;
  ForceObstacles m_obstacles;
  std::vector<Body> m_bodies;
  std::vector<Carried> m_carried;
  std::vector<std::optional<Axis>> m_axes;  ///< by bone
  FacingAreas m_areas;                      ///< of muscles
};

}  // namespace musclebench

#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/stage_surface.hpp"
#include "core/contact/surface_queries.hpp"
#include "core/effects/effect_registry.hpp"
#include "core/effects/surface_contact/sharp_vertices.hpp"

namespace musclebench {

/// A point of a muscle's triangle in or near a bone, and the plane that keeps it out, in the bone's rest frame.
struct FaceContact {
  std::size_t triangle = 0;
  std::size_t bone = 0;
  Vec3 weights = Vec3::Zero();  ///< barycentric, of the point in the triangle
  Vec3 point = Vec3::Zero();    ///< of the plane, m
  Vec3 normal = Vec3::UnitZ();  ///< unit, out of the bone
  bool is_at_sharp_vertex = false;
};

/// Finds where the faces of muscles are deepest in bones, or within a skin about them. Of each triangle near a bone the
/// deepest points are found by projected descent on the signed distance (Macklin, Erleben, Mueller, Chentanez,
/// Jeschke and Corse 2020, "Local optimization for robust signed distance field collision"), from its middle and, where
/// that ends near the bone, from near its corners and from where it was deepest last: a ridge cuts a triangle along
/// a line, and what keeps one end of it out leaves the other one in. A spike may be narrower than what lies between
/// those points: sharp vertices of the bone are held against the triangle themselves.
///
/// A point is kept out of the tangent plane at its closest point where that is a minimum by its gradient. Where a ridge
/// or a spike of the bone pokes through the face, the distance has a kink, and the way to the closest point leads
/// sideways; there the plane is the one through the exit of the face's normal.
class FaceContactFinder {
 public:
  /// Asks `input.make_surface_queries`. Points closer to a bone than `skin_m` are found, too.
  FaceContactFinder(const StageInput& input, double skin_m);

  /// The contacts at `positions` (of all nodes, world frame, m), by bone, then triangle; the same for any number of
  /// threads. Valid until the next call.
  std::span<const FaceContact> find(std::span<const Vec3> positions, std::span<const RigidMotion> bone_poses);

  /// The same of what was found last, with those at sharp vertices found anew: a spike that slides along the muscle
  /// has soon left the point where it was met, while the tangent planes of a smooth surface hold for longer.
  std::span<const FaceContact> follow(std::span<const Vec3> positions, std::span<const RigidMotion> bone_poses);

 private:
  struct BoneSurface {
    StageSurface<SurfaceQueries> surface;
    SharpVertices sharp_vertices;
    std::vector<int> near;               ///< for the next query, by the muscle's triangle
    std::vector<int> pointed_triangles;  ///< of the muscle, that the last search saw sharp vertices about, ascending
  };
  /// Triangles that one thread searches, and what it found.
  struct Chunk {
    std::vector<FaceContact> found;
    std::vector<int> pointed_triangles;
    std::vector<PathCrossing> crossings;
  };

  [[nodiscard]] bool has_free_node(std::size_t triangle, std::span<const double> inverse_masses) const;
  [[nodiscard]] bool is_attached_to(std::size_t triangle, std::size_t bone) const;
  void measure(std::size_t triangle, std::span<const Vec3> positions);
  void build_if_near(std::size_t bone, std::span<const int> triangles, const RigidMotion& pose);
  void search_all(std::size_t bone, std::span<const Vec3> positions, const RigidMotion& pose);
  void follow_all(std::size_t bone, std::span<const Vec3> positions, const RigidMotion& pose);
  void search(std::size_t triangle, std::size_t bone, std::span<const Vec3> positions, const RigidMotion& pose,
              Chunk& chunk);
  [[nodiscard]] std::span<const FaceContact> known(std::size_t bone, std::size_t triangle) const;

  std::span<const Triangle> m_triangles;
  double m_skin_m;
  int m_threads;
  std::vector<int> m_carriers;  ///< by node: the bone that it is attached to; -1: free
  std::vector<int> m_searched;  ///< triangles that have a free node
  ClearanceCache m_clearances;  ///< of triangles, by their middles
  std::vector<BoneSurface> m_bones;
  std::vector<Vec3> m_centres;      ///< by triangle
  std::vector<double> m_reaches_m;  ///< by triangle: radius about its middle that its clearances allow for
  std::vector<Chunk> m_chunks;
  std::vector<FaceContact> m_found;
  std::vector<FaceContact> m_known;  ///< of the search before
};

}  // namespace musclebench

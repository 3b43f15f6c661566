#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "core/base/parallel_chunks.hpp"
#include "core/contact/bone.hpp"
#include "core/effects/no_passage/near_pairs.hpp"
#include "core/effects/no_passage/passage_surfaces.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/bound_node.hpp"
#include "core/mesh/triangles_at_vertices.hpp"

namespace musclebench {

/// All surfaces of a run on straight paths through a substep, and what comes close on them: bones against muscles, in
/// the bone's frame, muscles against each other and, if asked for, each against itself.
class PassagePaths {
 public:
  /// `mesh`: of all muscles, at rest. Bones and mesh are kept by reference.
  PassagePaths(const TriangleMesh& mesh, std::span<const Body> bodies, std::span<const Bone> bones,
               std::span<const BoundNode> bound_nodes, bool with_itself, int threads);
  PassagePaths(const PassagePaths&) = delete;
  PassagePaths& operator=(const PassagePaths&) = delete;

  [[nodiscard]] std::size_t bones() const { return m_bones.size(); }
  [[nodiscard]] const TriangleMesh& mesh() const { return m_mesh; }
  [[nodiscard]] const std::vector<int>& carriers() const { return m_carriers; }
  [[nodiscard]] std::size_t body_of_node(int node) const { return body_of(m_bodies, node); }

  /// From `start` to `end` of all nodes, in the world, both kept by reference; and of all bones.
  void set(std::span<const Vec3> start, std::span<const Vec3> end, std::span<const RigidMotion> previous_poses,
           std::span<const RigidMotion> poses);
  /// The ends of these nodes' paths, ascending, have moved since; only their triangles are visited then.
  void change(std::span<const int> nodes);
  /// The start of the next paths is where these end.
  void move_on();

  /// Calls `visit(found, bone, triangle, other, enough_m)` once for each pair of triangles that may come closer than
  /// `least_m`: of a muscle's triangle and one of a bone, or of a muscle where `bone` is -1. It returns how far apart
  /// they are at least where the paths start, m; from `enough_m` on they can't come closer than `least_m`. `found` has
  /// an element for each part that a thread works on; they are in the same order for any number of threads.
  template <typename Found, typename Visit>
  void for_each_near(double least_m, std::vector<Found>& found, const Visit& visit);

  /// Calls `visit(stencil)` with those of two triangles that the guard can hold apart: not what a bone moves on both
  /// sides, nor what has a node that is bound to this bone.
  template <typename Visit>
  void for_each_stencil_of(int bone, std::size_t triangle, std::size_t other, const Visit& visit) const;

  /// Of a pair that is visited, in the frame of its paths.
  [[nodiscard]] TrianglePath path_of(int bone, std::size_t triangle) const;
  [[nodiscard]] TrianglePath path_of_other(int bone, std::size_t triangle) const;
  /// Corners where the paths start.
  using Corners = std::array<Vec3, 3>;
  [[nodiscard]] Corners corners_of(int bone, std::size_t triangle) const;
  [[nodiscard]] Corners corners_of_other(int bone, std::size_t triangle) const;
  /// Corners where the paths start and end, in their frame.
  [[nodiscard]] StencilCorners starts_of(const PassageStencil& stencil) const;
  [[nodiscard]] StencilCorners ends_of(const PassageStencil& stencil) const;
  /// Unit normal of a corner's surface where the paths start, in their frame.
  [[nodiscard]] Vec3 normal_of(const PassageStencil& stencil, std::size_t corner) const;
  /// Of the triangles at a side's node or edge, or at the corners of its face, the most that a unit normal has along
  /// `direction`, in the frame of the paths where they start.
  [[nodiscard]] double most_facing(const PassageStencil& stencil, bool of_first_side, const Vec3& direction) const;

 private:
  struct Muscle {
    Muscle(const TriangleMesh& mesh, const Body& body, int levels);

    TriangleTree tree;
    GivenPaths paths;
  };
  struct BoneSurface {
    BoneSurface(const TriangleMesh& surface, int levels);

    const TriangleMesh& mesh;
    Vec3 origin;
    OwnedFeatures features;
    TrianglesAtVertices around;
    TriangleTree tree;
    std::vector<VertexPath> vertices;
    GivenPaths still;
    std::deque<PathsInBone> muscles;  ///< by body
  };
  /// Two surfaces that may meet.
  struct Meeting {
    int bone;  ///< or -1
    const TriangleTree& first;
    const TriangleTree& second;
    NearPairs pairs;
  };
  struct FoundPair {
    const Meeting* meeting;
    NearPair* pair;
  };

  template <typename Work>
  void for_each_meeting(const Work& work) {
    for_each_chunk(m_meetings.size(), 1, m_threads,
                   [&](std::size_t i, std::size_t, std::size_t) { work(m_meetings[i].pairs); });
  }
  [[nodiscard]] const PathsInBone& paths_in(int bone, int node) const {
    return m_bones[static_cast<std::size_t>(bone)].muscles[body_of(m_bodies, node)];
  }
  [[nodiscard]] bool is_held(const PassageStencil& stencil) const;
  /// In the frame of the stencil's paths.
  [[nodiscard]] StencilCorners corners_of(const PassageStencil& stencil, std::span<const Vec3> in_world,
                                          Vec3 (PathsInBone::*in_bone)(int) const) const;

  const TriangleMesh& m_mesh;
  std::vector<Body> m_bodies;
  std::vector<int> m_carriers;  ///< by node: the bone that it is bound to, or -1
  int m_threads;
  OwnedFeatures m_features;
  TrianglesAtVertices m_around;
  Vec3 m_origin = Vec3::Zero();  ///< of `m_vertices`
  std::span<const Vec3> m_start;
  std::span<const Vec3> m_end;
  std::vector<VertexPath> m_vertices;  ///< by node
  std::deque<Muscle> m_muscles;        ///< by body
  std::deque<BoneSurface> m_bones;
  std::deque<Meeting> m_meetings;
  std::vector<FoundPair> m_found;
};

template <typename Found, typename Visit>
void PassagePaths::for_each_near(double least_m, std::vector<Found>& found, const Visit& visit) {
  for_each_meeting([&](NearPairs& pairs) { pairs.find(least_m); });
  m_found.clear();
  for (Meeting& meeting : m_meetings) {
    for (NearPair& pair : meeting.pairs.found()) m_found.push_back({&meeting, &pair});
  }
  constexpr std::size_t pairs_at_once = 16;
  found.resize(chunk_count(m_found.size(), pairs_at_once));
  for_each_chunk(m_found.size(), pairs_at_once, m_threads, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Meeting& meeting = *m_found[i].meeting;
      NearPair& pair = *m_found[i].pair;
      const double enough_m = pair.approach_m + static_cast<float>(least_m);
      const double apart_m = visit(found[chunk], meeting.bone, meeting.first.triangle(pair.first),
                                   meeting.second.triangle(pair.second), enough_m);
      pair.left_m = std::max(pair.left_m, (1 - lane_rounding) * static_cast<float>(apart_m));
    }
  });
  for_each_meeting([](NearPairs& pairs) { pairs.tell(); });
}

template <typename Visit>
void PassagePaths::for_each_stencil_of(int bone, std::size_t triangle, std::size_t other, const Visit& visit) const {
  const BoneSurface* surface = bone < 0 ? nullptr : &m_bones[static_cast<std::size_t>(bone)];
  const OwnedFeatures& features = surface == nullptr ? m_features : surface->features;
  const Triangle& face = (surface == nullptr ? m_mesh : surface->mesh).triangles[other];
  for_each_stencil(m_features.of[triangle], m_mesh.triangles[triangle], features.of[other], face,
                   [&](StencilKind kind, bool first_is_mine, const std::array<int, 4>& corners) {
                     const PassageStencil stencil{kind, bone, bone >= 0 && !first_is_mine, corners};
                     if (is_held(stencil)) visit(stencil);
                   });
}

}  // namespace musclebench

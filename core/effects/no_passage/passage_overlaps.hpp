#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/contact/bone.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/bound_node.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

class PassagePaths;

/// Two triangles that go through each other, or may.
struct TrianglePair {
  int bone;              ///< of the other, or -1: both are muscles'
  std::size_t triangle;  ///< a muscle's, in the mesh of all
  std::size_t other;     ///< in the bone's mesh, or that of all muscles
};

/// Whether triangles of paths go through each other where these start. What reaches through by less than `touching_m`
/// only touches, as do triangles with a common vertex.
bool go_through_each_other(const PassagePaths& paths, const TrianglePair& pair, double touching_m);

/// All of these pairs, in the order of their numbers.
std::vector<TrianglePair> find_overlaps(PassagePaths& paths, double touching_m);

/// What a run can't keep apart because it begins so: all overlaps of a scene at its poses, but for triangles with a
/// node that is bound to the bone. `gap_m`: the parameter of no_passage.
std::vector<TrianglePair> overlaps_at_start(const TriangleMesh& mesh, std::span<const Body> bodies,
                                            std::span<const Bone> bones, std::span<const BoundNode> bound_nodes,
                                            std::span<const RigidMotion> poses, double gap_m);

/// What is closer than this share of the gap touches: its direction apart is rounding.
inline constexpr double touching_share = 1e-3;

}  // namespace musclebench

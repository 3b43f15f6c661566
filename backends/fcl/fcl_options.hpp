#pragma once

#include <string>
#include <vector>

#include "core/base/parameters.hpp"

namespace musclebench {

/// What is asked of FCL: the muscle's surface against each bone's, or each node against each bone's tree, by distance
/// or by collision of a small sphere.
enum class Query { surfaces, node_distance, node_collide };

/// How the muscle's tree follows its vertices: new volumes from the leaves up or from the root down in the tree as
/// built at rest, or a new tree.
enum class TreeUpdate { refit, refit_top_down, rebuild };

/// Which of FCL's two functions gives the model its new vertices: `replace` forgets the old ones, `update` keeps them
/// and makes each volume enclose old and new (meant for continuous collision; slower, and the answers are the same).
enum class VertexUpdate { replace, update };

/// What finds the objects whose boxes overlap; `none`: every object meets every other.
enum class BroadPhase { dynamic_aabb_tree, sweep_and_prune, none };

/// Whose convex-shape algorithms FCL uses: libccd's or its own.
enum class NarrowPhase { libccd, indep };

struct FclOptions {
  std::string bounding_volume = "OBBRSS";  ///< one of `bounding_volumes()`
  Query query = Query::surfaces;
  BroadPhase broad_phase = BroadPhase::dynamic_aabb_tree;
  TreeUpdate tree_update = TreeUpdate::refit;
  VertexUpdate vertex_update = VertexUpdate::replace;
  NarrowPhase narrow_phase = NarrowPhase::libccd;
  double node_radius_m = 5e-4;       ///< of the spheres of `Query::node_collide`
  bool uses_clearance_cache = true;  ///< of queries of nodes
};

/// The names that `FclOptions::bounding_volume` may have.
const std::vector<std::string>& bounding_volumes();

std::vector<ParameterSpec> fcl_parameters();

/// `parameters` as `fcl_parameters` describes them. Throws InputError for a combination that FCL cannot answer, or that
/// has no meaning. One that FCL answers wrongly is let through: how wrong is what is measured.
FclOptions fcl_options(const Parameters& parameters);

}  // namespace musclebench

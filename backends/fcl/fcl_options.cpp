#include "backends/fcl/fcl_options.hpp"

#include "core/base/input_error.hpp"
#include "core/clearance/clearance_cache.hpp"

namespace musclebench {

namespace {

Query query_of(const std::string& word) {
  return word == "surfaces" ? Query::surfaces : word == "node_distance" ? Query::node_distance : Query::node_collide;
}

BroadPhase broad_phase_of(const std::string& word) {
  return word == "dynamic_aabb_tree" ? BroadPhase::dynamic_aabb_tree
         : word == "sweep_and_prune" ? BroadPhase::sweep_and_prune
                                     : BroadPhase::none;
}

TreeUpdate tree_update_of(const std::string& word) {
  return word == "refit" ? TreeUpdate::refit : word == "rebuild" ? TreeUpdate::rebuild : TreeUpdate::refit_top_down;
}

/// A parameter that would do nothing is refused, so that no row of a study bears a choice that was none.
void check_for_meaning(const FclOptions& options) {
  const FclOptions defaults;
  const char* of_surfaces = options.tree_update != defaults.tree_update       ? "fcl: update"
                            : options.vertex_update != defaults.vertex_update ? "fcl: model"
                            : options.broad_phase != defaults.broad_phase     ? "fcl: manager"
                                                                              : nullptr;
  if (options.query != Query::surfaces && of_surfaces != nullptr) {
    throw InputError(of_surfaces,
                     "applies to queries of the muscle's surface, and this query is of single nodes; leave it out, or "
                     "take query = surfaces");
  }
  if (options.query != Query::node_collide && options.node_radius_m != defaults.node_radius_m) {
    throw InputError("fcl: node_radius_m", "is the radius of the spheres of query = node_collide; leave it out");
  }
}

void check_for_support(const FclOptions& options) {
  const std::string& volume = options.bounding_volume;
  if (options.query == Query::node_distance && (volume == "OBB" || volume == "AABB" || volume == "KDOP24")) {
    throw InputError("fcl: bounding_volume", "unsupported: FCL 0.7 has no distance between a sphere and a tree of " +
                                                 volume + "; query = node_distance can have OBBRSS, RSS or kIOS");
  }
}

}  // namespace

const std::vector<std::string>& bounding_volumes() {
  static const std::vector<std::string> names = {"OBBRSS", "OBB", "RSS", "kIOS", "AABB", "KDOP24"};
  return names;
}

std::vector<ParameterSpec> fcl_parameters() {
  return {
      parameter::choice(
          {.name = "query",
           .choices = {"surfaces", "node_distance", "node_collide"},
           .help = "surfaces: collide the muscle's triangles with the bones'; misses nodes deep inside. node_distance: "
                   "exact distance of each node to the bone's triangles. node_collide: collide a small sphere at each "
                   "node with the bone's triangles; misses nodes deeper than the radius"}),
      parameter::choice(
          {.name = "bounding_volume",
           .choices = bounding_volumes(),
           .help =
               "bounding volume of the trees. OBB gives the same contacts as OBBRSS in less time and memory. AABB and "
               "KDOP24 are slow: they copy the bone in every query of a node, and rebuild a moved bone in every "
               "detection of surfaces. node_distance works with OBBRSS, RSS and kIOS only"}),
      parameter::choice(
          {.name = "manager",
           .choices = {"dynamic_aabb_tree", "sweep_and_prune", "none"},
           .help =
               "broad phase, which finds bones whose boxes overlap the muscle's box; none: all bones (surfaces only)"}),
      parameter::choice(
          {.name = "update",
           .choices = {"refit", "refit_top_down", "rebuild"},
           .help =
               "how the muscle's tree follows the nodes (surfaces only): refit (from the leaves up), "
               "refit_top_down, or rebuild. Do not use refit with RSS: FCL 0.7 merges RSS volumes wrongly and misses "
               "contacts"}),
      parameter::choice(
          {.name = "model",
           .choices = {"replace", "update"},
           .help = "replace: give FCL the new vertices of the muscle; update: FCL also encloses the previous vertices, "
                   "which is slower (surfaces only)"}),
      parameter::number({.name = "node_radius_m",
                         .unit = "m",
                         .default_value = FclOptions{}.node_radius_m,
                         .minimum = 1e-9,
                         .maximum = 1,
                         .help = "radius of the spheres of node_collide; the query misses deeper nodes"}),
      parameter::choice(
          {.name = "solver",
           .choices = {"libccd", "indep"},
           .help = "FCL's narrow phase for convex shapes. Both give the same contacts here, because FCL has special "
                   "formulas for two triangles and for sphere and triangle"}),
      clearance_cache_parameter(),
  };
}

FclOptions fcl_options(const Parameters& parameters) {
  FclOptions options;
  options.bounding_volume = parameters.word("bounding_volume");
  options.query = query_of(parameters.word("query"));
  options.broad_phase = broad_phase_of(parameters.word("manager"));
  options.tree_update = tree_update_of(parameters.word("update"));
  options.vertex_update = parameters.word("model") == "update" ? VertexUpdate::update : VertexUpdate::replace;
  options.narrow_phase = parameters.word("solver") == "libccd" ? NarrowPhase::libccd : NarrowPhase::indep;
  options.node_radius_m = parameters.number("node_radius_m");
  options.uses_clearance_cache = uses_clearance_cache(parameters);
  check_for_meaning(options);
  check_for_support(options);
  return options;
}

}  // namespace musclebench

#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/effects/fibres.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "core/pbd/effect.hpp"
#include "core/pbd/node_order.hpp"

namespace musclebench {

/// A node that is attached to a bone.
struct BoundNode {
  int node = 0;
  int bone = 0;
};

/// What effects are constructed from, by reference.
struct EffectInput {
  const TriangleMesh& mesh;  ///< of all muscles, at rest; its vertices are the nodes
  const std::vector<Body>& bodies;
  const NodeOrder& order;                                ///< of the nodes in `NodeRows`
  const std::vector<std::vector<FibreSegment>>& fibres;  ///< by body
  const std::vector<BoundNode>& bound_nodes;
  const std::vector<RigidMotion>& rest_poses;
};

/// An effect that scenes can name.
struct EffectEntry {
  std::string name;
  std::string help;
  std::vector<ParameterSpec> parameters;
  std::function<std::unique_ptr<Effect>(const EffectInput&, const Parameters&)> make;
};

/// All effects, in the order in which a solver iteration applies them.
const std::vector<EffectEntry>& effect_registry();

/// The entry of `name`, or nullptr.
const EffectEntry* find_effect(std::string_view name);

}  // namespace musclebench

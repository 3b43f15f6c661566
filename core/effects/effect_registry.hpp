#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/bone.hpp"
#include "core/contact/contact_properties.hpp"
#include "core/contact/response.hpp"
#include "core/contact/surface_queries.hpp"
#include "core/effects/requirement.hpp"
#include "core/fibres/end_nodes.hpp"
#include "core/fibres/fibre_segments.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/bound_node.hpp"
#include "core/mesh/retinaculum.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "core/pbd/contact_stage.hpp"
#include "core/pbd/effect.hpp"
#include "core/pbd/node_order.hpp"

namespace musclebench {

/// What effects are constructed from, by reference.
struct EffectInput {
  const TriangleMesh& mesh;  ///< of all muscles, at rest; its vertices are the nodes
  const std::vector<Body>& bodies;
  const NodeOrder& order;                                ///< of the nodes in `NodeRows`
  const std::vector<std::vector<FibreSegment>>& fibres;  ///< by body
  const std::vector<BoundNode>& bound_nodes;
  const std::vector<RigidMotion>& rest_poses;
  std::span<const EndNodes> ends = {};  ///< by body; empty: none is known
  std::span<const Retinaculum> retinacula = {};
};

/// What contact stages are constructed from. Outlives them unless said otherwise.
struct StageInput {
  std::span<const Bone> bones;
  std::size_t nodes = 0;  ///< of all muscles
  std::span<const Triangle> triangles = {};
  std::span<const double> inverse_masses = {};   ///< by node, 1/kg; needed while the stage is made only
  std::span<const BoundNode> bound_nodes = {};   ///< as these
  int threads = 1;                               ///< that a stage may use; they change no bit of its results
  const TriangleMesh* mesh = nullptr;            ///< of all muscles, at rest
  std::span<const Body> bodies = {};             ///< muscles in it
  std::span<const char> untouched = {};          ///< by bone, whether no node is expected near it; empty: none is known
  ContactProperties contacts = {};               ///< of all contacts that a stage finds itself
  MakeSurfaceQueries make_surface_queries = {};  ///< that contact of faces asks; empty: the exact ones

  [[nodiscard]] bool is_untouched(std::size_t bone) const { return bone < untouched.size() && untouched[bone] != 0; }
};

/// An effect that scenes can name: a force or constraints, a stage of the collision step, or another response.
struct EffectEntry {
  std::string name;
  std::string help;
  std::vector<ParameterSpec> parameters;
  std::function<std::unique_ptr<Effect>(const EffectInput&, const Parameters&)> make = {};
  std::function<std::unique_ptr<ContactStage>(const StageInput&, const Parameters&)> make_stage = {};  ///< or this
  std::function<void(Response&, const Parameters&)> set_response = {};                                 ///< or this
  /// With one of these: what it makes of contacts that other stages find.
  std::function<void(ContactProperties&, const Parameters&)> set_contacts = {};
  bool needs_normals = false;     ///< of contacts with bones
  bool needs_projection = false;  ///< the response that moves nodes by their depths
  /// What it helps a run to hold. None: it is a part of what a scene asks about, such as a load, and no trial adds it.
  std::vector<Remedy> remedies = {};
  std::vector<std::string> inert_at_zero = {};  ///< parameters: where one of them is 0, it changes nothing
  /// In figures, "#rrggbb": forces are grey, what keeps the form blue, the volume green, contact warm. Empty: any.
  std::string colour = {};
};

/// The folder of an effect and what it gives.
struct EffectSource {
  std::string_view name;
  EffectEntry (*entry)();
};

/// Of the effects that a program is built with, as CMake lists them (core/effects/CMakeLists.txt).
std::span<const EffectSource> effect_table();

/// All effects, in the order in which a solver iteration applies them; contact stages come last.
const std::vector<EffectEntry>& effect_registry();

/// The entry of `name`, or nullptr.
const EffectEntry* find_effect(std::string_view name);

}  // namespace musclebench

#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/clearance/bone_structure.hpp"
#include "core/contact/backend_entry.hpp"
#include "core/contact/bone.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

/// Where a point is to the surface of one bone, as a library tells it.
struct LocatedPoint {
  bool inside = false;
  double depth_m = 0;           ///< of a point inside: its distance to the surface
  Vec3 outward = Vec3::Zero();  ///< of a point inside: the unit direction of the shortest way out, rest frame
  double clearance_m = 0;       ///< of a point outside: radius of a sphere around it without any contact; 0: unknown
};

/// What a library has to offer about one bone to become a backend: closest points, or the value and gradient of a
/// field. Points are finite, in the bone's rest frame, in metres.
///
/// - `answer_bound()`: see BoneStructure. Contacts are at most `false_distance_m` outside the bone's box.
/// - `bytes()`: memory of the structure.
/// - `error()`: the error of an approximate structure, or nothing.
/// - `session()`: what one thread queries through, in one batch. It may hold what a library wants to have once a thread
///   (an accessor, a query object). Several threads call it at once.
/// - `session.locate(point, near)`: the answer. `near` belongs to the node: it is -1 at first, then what the last query
///   of this node left there. Store what makes the next query faster, such as the closest triangle. It must change no
///   bit of an answer.
template <typename Locator>
concept PointLocator = requires(const Locator& locator, const Vec3& point, int& near) {
  { locator.answer_bound() } -> std::same_as<AnswerBound>;
  { locator.bytes() } -> std::same_as<std::size_t>;
  { locator.error() } -> std::same_as<std::optional<StructureError>>;
  { locator.session().locate(point, near) } -> std::same_as<LocatedPoint>;
};

/// Whether points that are surely outside are told by the bone's bounding box, without asking the library.
enum class BoxCulling { none, bone_box };

/// A BoneStructure over a PointLocator: it finds contacts of single nodes, stores their clearances and keeps `near` for
/// each node. Several threads may call `detect` at once with different nodes.
template <PointLocator Locator>
class LocatedNodes final : public BoneStructure {
 public:
  /// Culls by the box of closed bones only: the inside of an open one may be larger.
  LocatedNodes(std::unique_ptr<const Locator> locator, const Bone& bone, BoxCulling culling)
      : m_locator(std::move(locator)), m_culls(culling == BoxCulling::bone_box && is_closed(bone.surface.mesh)) {
    if (!m_culls) return;
    m_box = bounding_box(bone.surface.mesh.vertices);
    const Vec3 reach = Vec3::Constant(m_locator->answer_bound().false_distance_m);
    m_box = Eigen::AlignedBox3d(m_box.min() - reach, m_box.max() + reach);
  }

  [[nodiscard]] AnswerBound answer_bound() const override { return m_locator->answer_bound(); }
  [[nodiscard]] std::optional<StructureError> error() const override { return m_locator->error(); }
  [[nodiscard]] std::size_t bytes() const override { return m_locator->bytes() + m_near.size() * sizeof(int); }
  void reset_nodes(std::size_t nodes) override { m_near.assign(nodes, -1); }

  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) override {
    auto&& session = m_locator->session();
    for (const int node : batch.nodes) {
      const Vec3 point = batch.pose.apply_inverse(batch.positions[static_cast<std::size_t>(node)]);
      if (!point.allFinite()) continue;
      LocatedPoint found;
      if (m_culls) found.clearance_m = m_box.exteriorDistance(point);
      if (found.clearance_m == 0) {
        int unknown = -1;
        found = session.locate(point, m_near.empty() ? unknown : m_near[static_cast<std::size_t>(node)]);
      }
      if (found.inside) {
        contacts.push_back({node, batch.bone, found.depth_m, batch.pose.apply_to_direction(found.outward)});
      } else if (batch.clearances != nullptr) {
        batch.clearances->store(batch.bone, node, point, found.clearance_m);
      }
    }
  }

 private:
  std::unique_ptr<const Locator> m_locator;
  bool m_culls;
  Eigen::AlignedBox3d m_box;
  std::vector<int> m_near;  ///< by node; empty without a clearance cache
};

/// PointMethod::build of a backend over a PointLocator that has `cull_parameter()`. `make(bone, threads, report)`
/// returns the locator over a bone: std::unique_ptr<const Locator>.
template <typename Make>
auto build_located(const Parameters& parameters, Make make) {
  const BoxCulling culling = parameters.flag("cull") ? BoxCulling::bone_box : BoxCulling::none;
  return [culling, make](const Bone& bone, int threads, const ShareReport& report) -> std::unique_ptr<BoneStructure> {
    auto locator = make(bone, threads, report);
    using Locator = std::remove_const_t<typename decltype(locator)::element_type>;
    return std::make_unique<LocatedNodes<Locator>>(std::move(locator), bone, culling);
  };
}

}  // namespace musclebench

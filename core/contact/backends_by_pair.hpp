#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/contact/collision_backend.hpp"
#include "core/mesh/body.hpp"

namespace musclebench {

/// A backend of its own for some pairs of a muscle and a bone, so that a scene pays for a fine structure only where it
/// needs one. To the loop it is one backend, which can do what all of its parts can.
class BackendsByPair final : public CollisionBackend {
 public:
  /// Answers for the nodes of some muscles and consecutive bones.
  struct Part {
    std::unique_ptr<CollisionBackend> backend;
    std::size_t first_bone = 0;
    std::size_t bones = 1;
    std::vector<Body> muscles = {};  ///< in the order of their nodes; empty: all
  };

  /// The parts have not been built. Each pair of a muscle and a bone is in one of them.
  explicit BackendsByPair(std::vector<Part> parts);

  [[nodiscard]] Capabilities capabilities() const override;
  /// The loosest of those that answer for the bone.
  [[nodiscard]] AnswerBound answer_bound(int bone) const override;
  [[nodiscard]] std::size_t structure_bytes() const override;
  /// Whether all parts were, which have something to read.
  [[nodiscard]] StructureOrigin structure_origin() const override;
  [[nodiscard]] std::vector<StructureError> structure_errors() const override;
  /// The smallest of those that answer for the bone and have cells.
  [[nodiscard]] double step_m(int bone) const override;
  /// The parts watch their bones.
  void expect_within(std::vector<Eigen::AlignedBox3d> boxes) override;
  /// A bone once a part that answers for it.
  [[nodiscard]] std::vector<PrunedBone> pruned_bones() const override;

 private:
  /// Calls `look` with each part that answers for a bone of the scene, and the bone's index there.
  template <typename Look>
  void for_each_part_of(int bone, const Look& look) const;
  [[nodiscard]] std::span<const int> nodes_of(const Part& part, std::span<const int> nodes);

  /// Of its last detection.
  void add_times_of(const Part& part);

  void do_build() override;
  void do_update(std::span<const Vec3> positions) override;
  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override;

  std::vector<Part> m_parts;
  std::vector<TriangleMesh> m_surfaces;  ///< by part that has some muscles only: the mesh of all without the others
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<int> m_nodes;
  std::vector<Contact> m_found;
};

}  // namespace musclebench

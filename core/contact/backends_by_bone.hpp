#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/contact/collision_backend.hpp"

namespace musclebench {

/// A backend of its own for some bones, so that a scene pays for a fine structure only where it needs one. To the loop
/// it is one backend, which can do what all of its parts can.
class BackendsByBone final : public CollisionBackend {
 public:
  /// Answers for `bones` of the scene's bones, after those of the part before.
  struct Part {
    std::unique_ptr<CollisionBackend> backend;
    std::size_t bones = 0;
  };

  /// The parts have not been built; together they answer for all bones, in their order.
  explicit BackendsByBone(std::vector<Part> parts);

  [[nodiscard]] Capabilities capabilities() const override;
  [[nodiscard]] AnswerBound answer_bound(int bone) const override;
  [[nodiscard]] std::size_t structure_bytes() const override;
  /// Whether all parts were, which have something to read.
  [[nodiscard]] bool built_from_file() const override;
  [[nodiscard]] std::vector<StructureError> structure_errors() const override;
  [[nodiscard]] double step_m(int bone) const override;

 private:
  /// The backend that answers for a bone of the scene, and the bone's index there.
  struct Assignment {
    const CollisionBackend& backend;
    int bone;
  };
  [[nodiscard]] Assignment assignment_of(int bone) const;

  void do_build() override;
  void do_update(std::span<const Vec3> positions) override;
  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override;

  std::vector<Part> m_parts;
  std::vector<Contact> m_found;
};

}  // namespace musclebench

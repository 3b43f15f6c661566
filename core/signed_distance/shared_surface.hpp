#pragma once

#include <memory>

#include "core/base/scoped_timer.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// The BVH and the exact signed distance of one surface. Each is built at its first use and shared by all later users:
/// reader, checks and backends. A copy starts empty, because its owner may change the copied surface. Not safe from
/// several threads while a call may build or release.
class SharedSurface {
 public:
  SharedSurface() = default;
  SharedSurface(const SharedSurface& /*other*/) {}
  SharedSurface& operator=(const SharedSurface& /*other*/) {
    release();
    return *this;
  }
  SharedSurface(SharedSurface&&) = default;
  SharedSurface& operator=(SharedSurface&&) = default;
  ~SharedSurface() = default;

  /// The tree of `surface`, which must be the same surface at every call and have triangles. The reference is valid
  /// until the first call of `signed_distance`, or until `release`.
  [[nodiscard]] const TriangleBvh& tree(const RepairedMesh& surface) const;
  /// The exact signed distance of `surface`, as above. The reference is valid until `release`.
  [[nodiscard]] const SignedSurface& signed_distance(const RepairedMesh& surface) const;
  /// The same, for a caller that needs it after `release`.
  [[nodiscard]] std::shared_ptr<const SignedSurface> kept_signed_distance(const RepairedMesh& surface) const;
  /// Frees the structures that no caller of `kept_signed_distance` still holds.
  void release() const;

  /// Starts counting `reused_build_ns`: the build time of structures that were built before this call and are used
  /// after it. It is added to the build time of the backend that uses them. That time then does not depend on which
  /// backend was built first.
  void start_accounting() const;
  [[nodiscard]] Nanoseconds reused_build_ns() const { return m_reused_build_ns; }

 private:
  template <typename Structure>
  struct Part {
    std::shared_ptr<Structure> structure;
    Nanoseconds build_ns = 0;
    bool is_counted = false;
  };
  template <typename Structure>
  void account(Part<Structure>& part) const;

  mutable Part<TriangleBvh> m_tree;  ///< its structure moves into `m_signed`
  mutable Part<SignedSurface> m_signed;
  mutable Nanoseconds m_reused_build_ns = 0;
};

}  // namespace musclebench

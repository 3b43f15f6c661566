#pragma once

#include <memory>

#include "core/base/scoped_timer.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// The tree over a surface and its exact signed distance, each built at its first use and shared by all later ones:
/// reader, checks and backends. A copy starts empty, because the copied surface may be changed. The calls that build or
/// release must not race.
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

  /// `surface` is the same one at every call, and has triangles. What is returned holds until `signed_distance` builds
  /// on it, or `release`.
  [[nodiscard]] const TriangleBvh& tree(const RepairedMesh& surface) const;
  [[nodiscard]] const SignedSurface& signed_distance(const RepairedMesh& surface) const;
  /// The same for a caller that needs it beyond `release`.
  [[nodiscard]] std::shared_ptr<const SignedSurface> kept_signed_distance(const RepairedMesh& surface) const;
  /// Frees the structures that `kept_signed_distance` has not handed out.
  void release() const;

  /// Build time of the structures that were used since `start_accounting` but had been built before: it belongs to the
  /// build time of a backend that uses them, which must not depend on what was built first.
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

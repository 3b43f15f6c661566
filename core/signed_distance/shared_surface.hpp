#pragma once

#include <memory>

#include "core/base/scoped_timer.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

/// The tree over a surface and its exact signed distance, each built when it is first asked for and kept for whoever
/// asks next: reader, checks and backends need the same one. A copy starts empty, because whoever copies a surface may
/// change it. The calls that build or release must not race.
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
  /// Gives the memory back, but for what is kept elsewhere.
  void release() const;

  /// What building took of all that was asked for since `start_accounting`, no matter when it was built: the price of a
  /// backend that needs it must not depend on who came first.
  void start_accounting() const;
  [[nodiscard]] Nanoseconds spared_ns() const { return m_spared_ns; }

 private:
  template <typename Structure>
  struct Part {
    std::shared_ptr<Structure> structure;
    Nanoseconds build_ns = 0;
    bool is_paid = false;
  };
  template <typename Structure>
  void account(Part<Structure>& part) const;

  mutable Part<TriangleBvh> m_tree;  ///< its structure moves into `m_signed`
  mutable Part<SignedSurface> m_signed;
  mutable Nanoseconds m_spared_ns = 0;
};

}  // namespace musclebench

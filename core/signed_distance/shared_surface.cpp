#include "core/signed_distance/shared_surface.hpp"

#include <utility>

namespace musclebench {

const TriangleBvh& SharedSurface::tree(const RepairedMesh& surface) const {
  if (!m_tree.structure && !m_signed.structure) {
    m_tree = {};
    m_tree.is_counted = true;
    const ScopedTimer timer(m_tree.build_ns);
    m_tree.structure = std::make_shared<TriangleBvh>(surface.mesh);
  }
  account(m_tree);
  return m_signed.structure ? m_signed.structure->tree() : *m_tree.structure;
}

const SignedSurface& SharedSurface::signed_distance(const RepairedMesh& surface) const {
  (void)tree(surface);
  if (!m_signed.structure) {
    m_signed = {};
    m_signed.is_counted = true;
    const ScopedTimer timer(m_signed.build_ns);
    m_signed.structure = std::make_shared<SignedSurface>(surface, std::move(*m_tree.structure));
    m_tree.structure.reset();
  }
  account(m_signed);
  return *m_signed.structure;
}

std::shared_ptr<const SignedSurface> SharedSurface::kept_signed_distance(const RepairedMesh& surface) const {
  (void)signed_distance(surface);
  return m_signed.structure;
}

void SharedSurface::release() const {
  m_tree = {};
  m_signed = {};
}

void SharedSurface::start_accounting() const {
  m_reused_build_ns = 0;
  m_tree.is_counted = false;
  m_signed.is_counted = false;
}

template <typename Structure>
void SharedSurface::account(Part<Structure>& part) const {
  m_reused_build_ns += part.is_counted ? 0 : part.build_ns;
  part.is_counted = true;
}

}  // namespace musclebench

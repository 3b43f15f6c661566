#include "core/signed_distance/shared_surface.hpp"

#include <utility>

namespace musclebench {

const TriangleBvh& SharedSurface::tree(const RepairedMesh& surface) const {
  if (!m_tree.structure && !m_signed.structure) {
    m_tree = {};
    m_tree.is_paid = true;
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
    m_signed.is_paid = true;
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
  m_spared_ns = 0;
  m_tree.is_paid = false;
  m_signed.is_paid = false;
}

template <typename Structure>
void SharedSurface::account(Part<Structure>& part) const {
  m_spared_ns += part.is_paid ? 0 : part.build_ns;
  part.is_paid = true;
}

}  // namespace musclebench

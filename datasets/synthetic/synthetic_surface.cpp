#include "datasets/synthetic/synthetic_surface.hpp"

#include <cstdint>
#include <unordered_map>

#include <Eigen/Geometry>

namespace musclebench {

EditableSurface::EditableSurface(const TriangleMesh& mesh)
    : m_position(mesh.vertices),
      m_first(mesh.vertices.size(), -1),
      m_corner(3 * mesh.triangles.size()),
      m_opposite(3 * mesh.triangles.size(), -1),
      m_vertex_count(static_cast<int>(mesh.vertices.size())) {
  const auto key = [](int from, int to) { return static_cast<std::int64_t>(from) << 32 | to; };
  std::unordered_map<std::int64_t, int> half_edge_of;
  half_edge_of.reserve(m_corner.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    set_triangle(static_cast<int>(t), triangle[0], triangle[1], triangle[2]);
    for (int i = 0; i < 3; ++i) {
      const int h = 3 * static_cast<int>(t) + i;
      half_edge_of.emplace(key(origin(h), target(h)), h);
    }
  }
  for (int h = 0; h < half_edges(); ++h) {
    m_opposite[at(h)] = half_edge_of.at(key(target(h), origin(h)));
  }
}

TriangleMesh EditableSurface::mesh() const {
  TriangleMesh result;
  std::vector<int> new_index(m_position.size(), -1);
  for (std::size_t v = 0; v < m_position.size(); ++v) {
    if (m_first[v] >= 0) {
      new_index[v] = static_cast<int>(result.vertices.size());
      result.vertices.push_back(m_position[v]);
    }
  }
  for (int h = 0; h < half_edges(); h += 3) {
    if (alive(h)) {
      result.triangles.push_back(
          {new_index[at(origin(h))], new_index[at(origin(h + 1))], new_index[at(origin(h + 2))]});
    }
  }
  return result;
}

int EditableSurface::valence(int v) const {
  int count = 0;
  int h = first_from(v);
  do {
    ++count;
    h = next_from(h);
  } while (h != first_from(v));
  return count;
}

Vec3 EditableSurface::normal(int h) const {
  const Vec3& a = position(origin(h));
  return (position(target(h)) - a).cross(position(tip(h)) - a);
}

bool EditableSurface::connected(int v, int w) const {
  int h = first_from(v);
  do {
    if (target(h) == w) {
      return true;
    }
    h = next_from(h);
  } while (h != first_from(v));
  return false;
}

void EditableSurface::set_triangle(int t, int a, int b, int c) {
  const std::array<int, 3> corners = {a, b, c};
  for (int i = 0; i < 3; ++i) {
    m_corner[at(3 * t + i)] = corners[at(i)];
    m_first[at(corners[at(i)])] = 3 * t + i;
  }
}

void EditableSurface::link(int h, int o) {
  m_opposite[at(h)] = o;
  m_opposite[at(o)] = h;
}

int EditableSurface::split(int h, const Vec3& to) {
  const int o = opposite(h);
  const int a = origin(h);
  const int b = target(h);
  const int c = tip(h);
  const int d = tip(o);
  const int beyond_bc = opposite(next(h));
  const int beyond_ca = opposite(previous(h));
  const int beyond_ad = opposite(next(o));
  const int beyond_db = opposite(previous(o));
  const int middle = vertex_slots();
  m_position.push_back(to);
  m_first.push_back(-1);
  ++m_vertex_count;
  const int t1 = h / 3;
  const int t2 = o / 3;
  const int t3 = half_edges() / 3;
  const int t4 = t3 + 1;
  m_corner.resize(m_corner.size() + 6);
  m_opposite.resize(m_opposite.size() + 6);
  set_triangle(t1, a, middle, c);
  set_triangle(t2, b, middle, d);
  set_triangle(t3, middle, b, c);
  set_triangle(t4, middle, a, d);
  link(3 * t1, 3 * t4);
  link(3 * t1 + 1, 3 * t3 + 2);
  link(3 * t1 + 2, beyond_ca);
  link(3 * t3, 3 * t2);
  link(3 * t3 + 1, beyond_bc);
  link(3 * t2 + 1, 3 * t4 + 2);
  link(3 * t2 + 2, beyond_db);
  link(3 * t4 + 1, beyond_ad);
  return middle;
}

bool EditableSurface::flip(int h) {
  const int o = opposite(h);
  const int a = origin(h);
  const int b = target(h);
  const int c = tip(h);
  const int d = tip(o);
  if (c == d || connected(c, d) || valence(a) <= 3 || valence(b) <= 3) {
    return false;
  }
  const int beyond_bc = opposite(next(h));
  const int beyond_ca = opposite(previous(h));
  const int beyond_ad = opposite(next(o));
  const int beyond_db = opposite(previous(o));
  const int t1 = h / 3;
  const int t2 = o / 3;
  set_triangle(t1, a, d, c);
  set_triangle(t2, d, b, c);
  link(3 * t1, beyond_ad);
  link(3 * t1 + 1, 3 * t2 + 2);
  link(3 * t1 + 2, beyond_ca);
  link(3 * t2, beyond_db);
  link(3 * t2 + 1, beyond_bc);
  return true;
}

bool EditableSurface::collapse(int h, const Vec3& to) {
  const int o = opposite(h);
  const int a = origin(h);
  const int b = target(h);
  const int c = tip(h);
  const int d = tip(o);
  if (c == d || valence(c) <= 3 || valence(d) <= 3) {
    return false;
  }
  for (int ring = next_from(h); ring != h; ring = next_from(ring)) {
    const int neighbour = target(ring);
    if (neighbour != b && neighbour != c && neighbour != d && connected(neighbour, b)) {
      return false;
    }
  }
  const int beyond_bc = opposite(next(h));
  const int beyond_ca = opposite(previous(h));
  const int beyond_ad = opposite(next(o));
  const int beyond_db = opposite(previous(o));
  for (int ring = next_from(h); ring != h;) {
    const int following = next_from(ring);
    m_corner[at(ring)] = b;
    ring = following;
  }
  link(beyond_bc, beyond_ca);
  link(beyond_ad, beyond_db);
  for (const int triangle : {h / 3, o / 3}) {
    for (int i = 0; i < 3; ++i) {
      m_opposite[at(3 * triangle + i)] = -1;
    }
  }
  m_first[at(a)] = -1;
  m_first[at(b)] = beyond_ca;
  m_first[at(c)] = beyond_bc;
  m_first[at(d)] = beyond_ad;
  m_position[at(b)] = to;
  --m_vertex_count;
  return true;
}

}  // namespace musclebench

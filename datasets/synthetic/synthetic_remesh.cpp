#include "datasets/synthetic/synthetic_remesh.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "datasets/synthetic/synthetic_surface.hpp"

namespace musclebench {

namespace {

constexpr int passes = 5;
constexpr int final_passes = 4;
constexpr int newton_steps = 3;

class Remesher {
 public:
  Remesher(const TriangleMesh& rough, const Field& field, int vertices)
      : m_surface(rough), m_field(field), m_vertices(vertices), m_edge_m(edge_for_count()) {}

  TriangleMesh run() {
    for (int pass = 0; pass < passes; ++pass) {
      split_long_edges();
      collapse_short_edges();
      even_out_valences();
      relax(1);
      m_edge_m = edge_for_count();
    }
    reach_count();
    for (int pass = 0; pass < final_passes; ++pass) {
      make_delaunay();
      relax(newton_steps);
    }
    make_delaunay();
    return m_surface.mesh();
  }

 private:
  /// A surface of area A with V vertices has 2 V triangles; were all equilateral, their edge would be this.
  [[nodiscard]] double edge_for_count() const {
    double doubled_area = 0;
    for (int h = 0; h < m_surface.half_edges(); h += 3) {
      if (m_surface.alive(h)) {
        doubled_area += m_surface.normal(h).norm();
      }
    }
    return std::sqrt(doubled_area / (std::sqrt(3.0) * m_vertices));
  }

  [[nodiscard]] Vec3 middle(int h) const {
    return 0.5 * (m_surface.position(m_surface.origin(h)) + m_surface.position(m_surface.target(h)));
  }

  [[nodiscard]] bool canonical(int h) const { return m_surface.alive(h) && h < m_surface.opposite(h); }

  void split_long_edges() {
    const double limit = 4.0 / 3.0 * m_edge_m;
    for (int h = 0; h < m_surface.half_edges(); ++h) {
      if (canonical(h) && m_surface.length(h) > limit) {
        m_surface.split(h, middle(h));
      }
    }
  }

  void collapse_short_edges() {
    const double limit = 0.8 * m_edge_m;
    for (int h = 0; h < m_surface.half_edges(); ++h) {
      if (canonical(h) && m_surface.length(h) < limit) {
        collapse_carefully(h, 4.0 / 3.0 * m_edge_m);
      }
    }
  }

  bool collapse_carefully(int h, double longest_m) {
    const Vec3 position = middle(h);
    return stays_sound(h, position, longest_m) && stays_sound(m_surface.opposite(h), position, longest_m) &&
           m_surface.collapse(h, position);
  }

  /// The triangles around the origin of h keep their side and get no edge beyond `longest_m` when it moves to
  /// `position`.
  [[nodiscard]] bool stays_sound(int h, const Vec3& position, double longest_m) const {
    const int gone = m_surface.opposite(h) / 3;
    for (int ring = m_surface.next_from(h); ring != h; ring = m_surface.next_from(ring)) {
      if ((m_surface.position(m_surface.target(ring)) - position).norm() > longest_m) {
        return false;
      }
      if (ring / 3 == gone) {
        continue;
      }
      const Vec3 before = m_surface.normal(ring);
      const Vec3 after = (m_surface.position(m_surface.target(ring)) - position)
                             .cross(m_surface.position(m_surface.tip(ring)) - position);
      if (before.dot(after) < 0.5 * before.norm() * after.norm()) {
        return false;
      }
    }
    return true;
  }

  /// Flipping a sharp edge would cut into the solid.
  [[nodiscard]] bool flat_enough_to_flip(int h) const {
    const int o = m_surface.opposite(h);
    const Vec3 one = m_surface.normal(h);
    const Vec3 other = m_surface.normal(o);
    if (one.dot(other) < 0.7 * one.norm() * other.norm()) {
      return false;
    }
    const Vec3& a = m_surface.position(m_surface.origin(h));
    const Vec3& b = m_surface.position(m_surface.target(h));
    const Vec3& c = m_surface.position(m_surface.tip(h));
    const Vec3& d = m_surface.position(m_surface.tip(o));
    const Vec3 mean = one + other;
    const Vec3 new_one = (d - a).cross(c - a);
    const Vec3 new_other = (b - d).cross(c - d);
    const double limit = 0.7 * mean.norm();
    return new_one.dot(mean) > limit * new_one.norm() && new_other.dot(mean) > limit * new_other.norm();
  }

  void even_out_valences() {
    std::vector<int> valence(static_cast<std::size_t>(m_surface.vertex_slots()), 0);
    for (int h = 0; h < m_surface.half_edges(); ++h) {
      if (m_surface.alive(h)) {
        ++valence[static_cast<std::size_t>(m_surface.origin(h))];
      }
    }
    const auto of = [&](int v) -> int& { return valence[static_cast<std::size_t>(v)]; };
    const auto excess = [](int n) { return (n - 6) * (n - 6); };
    for (int h = 0; h < m_surface.half_edges(); ++h) {
      if (!canonical(h)) {
        continue;
      }
      const int a = m_surface.origin(h);
      const int b = m_surface.target(h);
      const int c = m_surface.tip(h);
      const int d = m_surface.tip(m_surface.opposite(h));
      const int before = excess(of(a)) + excess(of(b)) + excess(of(c)) + excess(of(d));
      const int after = excess(of(a) - 1) + excess(of(b) - 1) + excess(of(c) + 1) + excess(of(d) + 1);
      if (after < before && flat_enough_to_flip(h) && m_surface.flip(h)) {
        --of(a);
        --of(b);
        ++of(c);
        ++of(d);
      }
    }
  }

  [[nodiscard]] double cosine_opposite(int h) const {
    const Vec3& tip = m_surface.position(m_surface.tip(h));
    const Vec3 one = m_surface.position(m_surface.origin(h)) - tip;
    const Vec3 other = m_surface.position(m_surface.target(h)) - tip;
    return one.dot(other) / std::max(one.norm() * other.norm(), 1e-30);
  }

  /// An edge whose opposite angles add to more than 180 degrees is the worse diagonal.
  void make_delaunay() {
    for (int round = 0; round < 3; ++round) {
      for (int h = 0; h < m_surface.half_edges(); ++h) {
        if (canonical(h) && cosine_opposite(h) + cosine_opposite(m_surface.opposite(h)) < -1e-9 &&
            flat_enough_to_flip(h)) {
          m_surface.flip(h);
        }
      }
    }
  }

  /// Every vertex moves within the surface towards the centroid of its triangles, then back onto field = 0.
  void relax(int steps) {
    std::vector<Vec3> moved(static_cast<std::size_t>(m_surface.vertex_slots()));
    const int slots = m_surface.vertex_slots();
#pragma omp parallel for schedule(static)
    for (int v = 0; v < slots; ++v) {
      if (m_surface.vertex_alive(v)) {
        moved[static_cast<std::size_t>(v)] = onto_surface(relaxed(v), steps);
      }
    }
    for (int v = 0; v < slots; ++v) {
      if (m_surface.vertex_alive(v)) {
        m_surface.move(v, moved[static_cast<std::size_t>(v)]);
      }
    }
  }

  [[nodiscard]] Vec3 relaxed(int v) const {
    const Vec3& here = m_surface.position(v);
    Vec3 normal = Vec3::Zero();
    Vec3 weighted = Vec3::Zero();
    double weight = 0;
    int h = m_surface.first_from(v);
    do {
      const Vec3 triangle_normal = m_surface.normal(h);
      const double area = triangle_normal.norm();
      weighted += area * (here + m_surface.position(m_surface.target(h)) + m_surface.position(m_surface.tip(h))) / 3.0;
      weight += area;
      normal += triangle_normal;
      h = m_surface.next_from(h);
    } while (h != m_surface.first_from(v));
    const double size = normal.norm();
    if (weight <= 0 || size <= 1e-6 * weight) {
      return here;
    }
    const Vec3 step = weighted / weight - here;
    return here + step - step.dot(normal / size) * (normal / size);
  }

  /// Newton steps along the gradient, none longer than half an edge: near the rim of a thin wedge the gradient is weak.
  [[nodiscard]] Vec3 onto_surface(Vec3 point, int steps) const {
    const double reach = 1e-3 * m_edge_m;
    for (int iteration = 0; iteration < steps; ++iteration) {
      const double value = m_field(point);
      if (std::abs(value) < 1e-4 * m_edge_m) {
        break;
      }
      Vec3 gradient;
      for (int axis = 0; axis < 3; ++axis) {
        gradient[axis] = (m_field(point + reach * Vec3::Unit(axis)) - value) / reach;
      }
      const Vec3 step = -value / std::max(gradient.squaredNorm(), 0.05) * gradient;
      const double length = step.norm();
      point += length > 0.5 * m_edge_m ? Vec3(0.5 * m_edge_m / length * step) : step;
    }
    return point;
  }

  /// Splits the longest edges, or collapses the shortest ones, until the number of vertices is exact.
  void reach_count() {
    while (m_surface.vertex_count() != m_vertices) {
      const bool too_few = m_surface.vertex_count() < m_vertices;
      std::vector<std::pair<double, int>> edges;
      for (int h = 0; h < m_surface.half_edges(); ++h) {
        if (canonical(h)) {
          edges.emplace_back(too_few ? -m_surface.length(h) : m_surface.length(h), h);
        }
      }
      std::sort(edges.begin(), edges.end());
      // Few at a time: each change lengthens or shortens the edges around it.
      const int wanted = std::abs(m_surface.vertex_count() - m_vertices);
      int left = std::min(wanted, static_cast<int>(edges.size()) / 24 + 1);
      const int before = m_surface.vertex_count();
      for (auto edge = edges.begin(); edge != edges.end() && left > 0; ++edge) {
        const int h = edge->second;
        if (too_few && std::abs(m_surface.length(h) + edge->first) < 1e-15) {
          m_surface.split(h, middle(h));
          --left;
        } else if (!too_few && m_surface.alive(h) && collapse_carefully(h, 2.0 * m_edge_m)) {
          --left;
        }
      }
      if (m_surface.vertex_count() == before) {
        break;
      }
      make_delaunay();
      relax(1);
    }
  }

  EditableSurface m_surface;
  const Field& m_field;
  int m_vertices;
  double m_edge_m;
};

}  // namespace

TriangleMesh remesh_isotropic(const TriangleMesh& rough, const Field& field, int vertices) {
  return Remesher(rough, field, vertices).run();
}

}  // namespace musclebench

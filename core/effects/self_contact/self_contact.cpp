#include "core/effects/self_contact/self_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/parallel_chunks.hpp"
#include "core/bvh/moving_surface_tree.hpp"
#include "core/clearance/moving_clearances.hpp"
#include "core/contact/contact_rows.hpp"
#include "core/contact/muscle_contact.hpp"
#include "core/distance/triangle_distance.hpp"

namespace musclebench {

namespace {

/// Thickness over the mean length of an edge, where none is given: folds of a mesh are no sharper.
constexpr double thickness_over_edge = 0.2;
/// A node and a triangle that are farther apart than so many thicknesses do not meet within a substep.
constexpr double watched = 2;
/// A larger distance, over the thickness, need not be told: clearances last long enough.
constexpr double farthest = 20;
/// Below this share of the thickness the direction between two points is only rounding.
constexpr double least_distance = 1e-6;
constexpr std::size_t chunk_size = 32;

std::vector<MusclePair> each_with_itself(std::size_t bodies) {
  std::vector<MusclePair> pairs;
  for (int i = 0; i < static_cast<int>(bodies); ++i) pairs.push_back({i, i});
  return pairs;
}

double mean_edge_m(const TriangleMesh& mesh) {
  double sum_m = 0;
  double edges = 0;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum_m += (mesh.vertices[static_cast<std::size_t>(triangle[(k + 1) % 3])] -
                mesh.vertices[static_cast<std::size_t>(triangle[k])])
                   .norm();
      ++edges;
    }
  }
  return edges > 0 ? sum_m / edges : 0;
}

class SelfContact final : public ContactStage {
 public:
  SelfContact(const StageInput& input, double thickness_m, int steps)
      : m_bodies(input.bodies.begin(), input.bodies.end()),
        m_mesh(*input.mesh),
        m_thickness_m(thickness_m > 0 ? thickness_m : thickness_over_edge * mean_edge_m(m_mesh)),
        m_steps(steps),
        m_threads(input.threads),
        m_clearances({m_mesh, m_bodies, each_with_itself(m_bodies.size())}),
        m_left_out(m_mesh.vertices.size()),
        m_guesses(m_mesh.vertices.size(), -1),
        m_solver({input.inverse_masses.begin(), input.inverse_masses.end()}, input.contacts.friction_coefficient) {
    for (const Body& body : m_bodies) m_trees.emplace_back(m_mesh, body);
    for (std::size_t node = 0; node < m_left_out.size(); ++node) m_left_out[node] = near_at_rest(node);
  }

  [[nodiscard]] std::string_view name() const override { return "self_contact"; }

  std::span<const int> before_bones(const ContactStageInput& input) override {
    for (MovingSurfaceTree& tree : m_trees) tree.update(input.start, m_threads);
    m_clearances.update(input.start, m_threads);
    find_rows(input.start);
    m_solver.lay_out_slowly(m_rows, input.start, input.predicted, input.depenetration_m);
    m_solver.solve(m_rows, input.start, input.predicted, input.impulses);
    return m_solver.moved_nodes();
  }

  [[nodiscard]] int contact_count() const override { return m_solver.most_corrected(); }

 private:
  /// The triangles of the node's muscle that are no concern of it, ascending.
  [[nodiscard]] std::vector<int> near_at_rest(std::size_t node) const {
    const MovingSurfaceTree& tree = m_trees[body_of(m_bodies, static_cast<int>(node))];
    std::vector<int> near;
    for (;;) {
      const ClosestPoint next =
          tree.closest_point(m_mesh.vertices[node], -1, self_contact_rest_factor * m_thickness_m, near);
      if (next.triangle < 0) return near;
      near.insert(std::ranges::lower_bound(near, next.triangle), next.triangle);
    }
  }

  void find_rows(std::span<const Vec3> start) {
    const std::span<const int> expired = m_clearances.expired();
    const std::size_t chunks = chunk_count(expired.size(), chunk_size);
    if (m_chunks.size() < chunks) m_chunks.resize(chunks);
    for_each_chunk(expired.size(), chunk_size, m_threads, [&](std::size_t chunk, std::size_t first, std::size_t last) {
      m_chunks[chunk].clear();
      for (const int node : expired.subspan(first, last - first)) query(node, start, m_chunks[chunk]);
    });
    m_rows.clear();
    for (const auto& rows : std::span(m_chunks).first(chunks)) m_rows.insert(m_rows.end(), rows.begin(), rows.end());
  }

  void query(int node, std::span<const Vec3> start, std::vector<ContactRow>& rows) {
    const Vec3& point = start[static_cast<std::size_t>(node)];
    const MovingSurfaceTree& tree = m_trees[body_of(m_bodies, node)];
    const std::span<const int> left_out = m_left_out[static_cast<std::size_t>(node)];
    const double watched_m = watched * m_thickness_m;
    const double farthest_m = farthest * m_thickness_m;
    int& guess = m_guesses[static_cast<std::size_t>(node)];
    const ClosestPoint closest = tree.closest_point(point, guess, farthest_m, left_out);
    if (closest.triangle >= 0) guess = closest.triangle;
    const double distance_m = closest.triangle < 0 ? (point.allFinite() ? farthest_m : 0) : closest.distance_m;
    m_clearances.store(node, distance_m - watched_m);
    if (closest.triangle < 0 || distance_m > watched_m) return;
    rows.push_back(row_of(node, point, closest, start));
  }

  [[nodiscard]] ContactRow row_of(int node, const Vec3& point, const ClosestPoint& closest,
                                  std::span<const Vec3> start) const {
    const auto& [a, b, c] = m_mesh.triangles[static_cast<std::size_t>(closest.triangle)];
    const std::array<Vec3, 3> corners = {start[static_cast<std::size_t>(a)], start[static_cast<std::size_t>(b)],
                                         start[static_cast<std::size_t>(c)]};
    const MuscleContact contact =
        muscle_contact_at(node, 0, point, closest.triangle, corners,
                          {closest.point, closest.distance_m * closest.distance_m, closest.feature});
    const bool touches = closest.distance_m < least_distance * m_thickness_m;
    const Vec3 normal =
        touches ? (corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized() : Vec3(-contact.normal);
    return {.nodes = {node, a, b, c},
            .weights = {1, -contact.weights.x(), -contact.weights.y(), -contact.weights.z()},
            .normal = normal,
            .offset_m = m_thickness_m,
            .start_normal = normal,
            .start_offset_m = m_thickness_m,
            .steps = m_steps};
  }

  std::vector<Body> m_bodies;
  const TriangleMesh& m_mesh;
  double m_thickness_m;
  int m_steps;
  int m_threads;
  std::vector<MovingSurfaceTree> m_trees;  ///< by muscle
  MovingClearances m_clearances;
  std::vector<std::vector<int>> m_left_out;  ///< by node
  std::vector<int> m_guesses;                ///< by node: the triangle that was closest last
  std::vector<std::vector<ContactRow>> m_chunks;
  std::vector<ContactRow> m_rows;
  ContactRowSolver m_solver;
};

std::unique_ptr<ContactStage> make_self_contact(const StageInput& input, const Parameters& parameters) {
  return std::make_unique<SelfContact>(input, parameters.number("thickness_m"),
                                       static_cast<int>(parameters.integer("steps")));
}

std::vector<ParameterSpec> self_contact_parameters() {
  return {parameter::number({.name = "thickness_m",
                             .unit = "m",
                             .default_value = 0,
                             .minimum = 0,
                             .maximum = 0.1,
                             .help = "distance that a node keeps from its own muscle's surface; 0: a fifth of the mean "
                                     "edge"}),
          parameter::integer({.name = "steps",
                              .default_value = 5,
                              .minimum = 1,
                              .maximum = 1000,
                              .help = "corrections a collision step"})};
}

}  // namespace

EffectEntry self_contact_entry() {
  return {.name = "self_contact",
          .help = "a muscle does not fold through itself",
          .parameters = self_contact_parameters(),
          .make_stage = make_self_contact,
          .remedies = {{Requirement::self_passage}},
          .colour = "#CC79A7"};
}

}  // namespace musclebench

#include "backends/bvh/muscle_detector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/bvh/moving_surface_tree.hpp"
#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/moving_clearances.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// More than the relative rounding errors of the lengths that a clearance is made of.
constexpr double rounding = 1e-9;
/// A point closer to a surface than this, relative to the diagonal of all muscles, is on it.
constexpr double touching = 1e-12;
constexpr double unknown_m = std::numeric_limits<double>::infinity();

/// With the clearance cache only nodes that have used up their clearance are queried (MovingClearances). The cache
/// changes the time only.
class BvhMuscleDetector final : public MuscleContactDetector {
 public:
  BvhMuscleDetector(const TouchingMuscles& muscles, bool with_cache, int threads)
      : m_mesh(muscles.mesh),
        m_bodies(muscles.bodies),
        m_pairs(muscles.pairs),
        m_threads(threads),
        m_touching_m(touching * bounding_box(muscles.mesh.vertices).diagonal().norm()),
        m_pair_times(no_times(muscles.pairs)) {
    if (with_cache) m_clearances.emplace(muscles);
    for (int muscle = 0; muscle < static_cast<int>(m_bodies.size()); ++muscle) {
      const Body& body = m_bodies[static_cast<std::size_t>(muscle)];
      m_beside.push_back(muscles_beside(muscles.pairs, muscle));
      m_trees.emplace_back(muscles.mesh, body);
      m_most_beside = std::max(m_most_beside, m_beside.back().size());
      for (int node = body.first_node; node < body.last_node && !m_beside.back().empty(); ++node) {
        m_nodes.push_back(node);
      }
    }
    m_guesses.assign(muscles.mesh.vertices.size() * m_most_beside, -1);
  }

  void detect(std::span<const Vec3> positions, std::vector<MuscleContact>& contacts) override {
    contacts.clear();
    m_positions = positions;
    for (MovingSurfaceTree& tree : m_trees) tree.update(positions, m_threads);
    if (m_clearances) m_clearances->update(positions, m_threads);
    m_queried = m_clearances ? m_clearances->expired() : std::span<const int>(m_nodes);
    const std::size_t chunks = (m_queried.size() + chunk_size - 1) / chunk_size;
    if (m_chunks.size() < chunks) m_chunks.resize(chunks);
    if (m_threads > 1 && chunks > 1) {  // OpenMP allocates even a team of one
#pragma omp parallel for schedule(dynamic, 1) num_threads(m_threads)
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) query_chunk(chunk);
    } else {
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) query_chunk(chunk);
    }
    for (PairTime& time : m_pair_times) time.detect_ns = 0;
    for (const Chunk& chunk : std::span(m_chunks).first(chunks)) {
      contacts.insert(contacts.end(), chunk.found.begin(), chunk.found.end());
      for (std::size_t pair = 0; pair < m_pair_times.size(); ++pair) {
        m_pair_times[pair].detect_ns += chunk.pair_ns[pair];
      }
    }
    std::ranges::sort(contacts, {},
                      [](const MuscleContact& contact) { return std::pair(contact.node, contact.muscle); });
  }

  [[nodiscard]] std::span<const PairTime> pair_times() const override { return m_pair_times; }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = (m_nodes.capacity() + m_guesses.capacity()) * sizeof(int);
    if (m_clearances) bytes += m_clearances->bytes();
    for (const MovingSurfaceTree& tree : m_trees) bytes += tree.bytes();
    return bytes;
  }

 private:
  static constexpr std::size_t chunk_size = 32;

  /// Results of a chunk of nodes, which one thread queries.
  struct Chunk {
    std::vector<MuscleContact> found;
    std::vector<Nanoseconds> pair_ns;
  };

  void query_chunk(std::size_t index) {
    Chunk& chunk = m_chunks[index];
    chunk.found.clear();
    chunk.pair_ns.assign(m_pair_times.size(), 0);
    std::span<const int> rest = m_queried.subspan(index * chunk_size);
    rest = rest.first(std::min(rest.size(), chunk_size));
    while (!rest.empty()) {
      const std::size_t muscle = body_of(m_bodies, rest.front());
      const auto end = std::ranges::find_if_not(rest, [&](int node) { return m_bodies[muscle].has_node(node); });
      const auto count = static_cast<std::size_t>(end - rest.begin());
      query_nodes(muscle, rest.first(count), chunk);
      rest = rest.subspan(count);
    }
  }

  void query_nodes(std::size_t muscle, std::span<const int> nodes, Chunk& chunk) {
    std::array<double, chunk_size> clearance_m;
    clearance_m.fill(unknown_m);
    Nanoseconds before_ns = monotonic_now_ns();
    for (std::size_t beside = 0; beside < m_beside[muscle].size(); ++beside) {
      const int other = m_beside[muscle][beside];
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const double excess_travel_m = m_clearances ? m_clearances->excess_travel_m(nodes[i]) : unknown_m;
        // Search no farther than the best clearance so far, if that alone proves the node free.
        const double enough_m = clearance_m[i] > excess_travel_m ? clearance_m[i] : unknown_m;
        int& guess = m_guesses[static_cast<std::size_t>(nodes[i]) * m_most_beside + beside];
        clearance_m[i] =
            std::min(clearance_m[i], query_muscle(nodes[i], other, excess_travel_m, enough_m, guess, chunk.found));
      }
      const Nanoseconds now_ns = monotonic_now_ns();
      chunk.pair_ns[pair_index(m_pairs, static_cast<int>(muscle), other)] += now_ns - before_ns;
      before_ns = now_ns;
    }
    for (std::size_t i = 0; i < nodes.size() && m_clearances; ++i) m_clearances->store(nodes[i], clearance_m[i]);
  }

  /// Returns a lower bound of the node's distance to the muscle, or `enough_m` where that is less; 0 inside.
  double query_muscle(int node, int muscle, double excess_travel_m, double enough_m, int& guess,
                      std::vector<MuscleContact>& found) const {
    const Vec3& point = m_positions[static_cast<std::size_t>(node)];
    const MovingSurfaceTree& tree = m_trees[static_cast<std::size_t>(muscle)];
    if (const double box_m = tree.box_distance_m(point); box_m > 0) {
      return box_m;
    }
    const ClosestPoint closest = tree.closest_point(point, guess, enough_m);
    if (closest.triangle < 0) {
      return point.allFinite() ? enough_m : 0;
    }
    guess = closest.triangle;
    const bool is_free = closest.distance_m <= m_touching_m || closest.distance_m * (1 - rounding) > excess_travel_m ||
                         tree.winding_number(point) <= 0;
    if (is_free) {
      return closest.distance_m;
    }
    const auto& [a, b, c] = m_mesh.triangles[static_cast<std::size_t>(closest.triangle)];
    const std::array<Vec3, 3> corners = {m_positions[static_cast<std::size_t>(a)],
                                         m_positions[static_cast<std::size_t>(b)],
                                         m_positions[static_cast<std::size_t>(c)]};
    found.push_back(muscle_contact_at(node, muscle, point, closest.triangle, corners,
                                      {closest.point, closest.distance_m * closest.distance_m, closest.feature}));
    return 0;
  }

  const TriangleMesh& m_mesh;
  std::vector<Body> m_bodies;
  std::vector<MusclePair> m_pairs;
  int m_threads;
  double m_touching_m;
  std::vector<PairTime> m_pair_times;
  std::vector<std::vector<int>> m_beside;  ///< by muscle: those that it touches, ascending
  std::size_t m_most_beside = 0;
  std::vector<MovingSurfaceTree> m_trees;  ///< by muscle
  std::vector<int> m_nodes;                ///< of muscles that touch others
  std::optional<MovingClearances> m_clearances;
  std::vector<int> m_guesses;  ///< by node, then muscle beside: the triangle that was closest last
  std::span<const Vec3> m_positions;
  std::span<const int> m_queried;
  std::vector<Chunk> m_chunks;
};

}  // namespace

std::unique_ptr<MuscleContactDetector> make_bvh_muscle_detector(const Parameters& parameters,
                                                                const TouchingMuscles& muscles, int threads) {
  return std::make_unique<BvhMuscleDetector>(muscles, uses_clearance_cache(parameters), threads);
}

}  // namespace musclebench

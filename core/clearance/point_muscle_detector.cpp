#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/clearance/deforming_structure.hpp"
#include "core/clearance/moving_clearances.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// A point closer to a surface than this, relative to the diagonal of all muscles, is on it.
constexpr double touching = 1e-12;
constexpr double no_bound_m = std::numeric_limits<double>::infinity();

class PointMuscleDetector final : public MuscleContactDetector {
 public:
  PointMuscleDetector(const DeformingMethod& method, const TouchingMuscles& muscles, int threads)
      : m_mesh(muscles.mesh),
        m_bodies(muscles.bodies),
        m_pairs(muscles.pairs),
        m_threads(threads),
        m_touching_m(touching * bounding_box(muscles.mesh.vertices).diagonal().norm()),
        m_pair_times(no_times(muscles.pairs)) {
    if (method.has_cache) m_clearances.emplace(muscles);
    for (int muscle = 0; muscle < static_cast<int>(m_bodies.size()); ++muscle) {
      const Body& body = m_bodies[static_cast<std::size_t>(muscle)];
      m_beside.push_back(muscles_beside(muscles.pairs, muscle));
      m_structures.push_back(m_beside.back().empty() ? nullptr : method.build(muscles.mesh, body));
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
    for (const auto& structure : m_structures) {
      if (structure) structure->update(positions, m_threads);
    }
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
    for (const auto& structure : m_structures) {
      if (structure) bytes += structure->bytes();
    }
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
    clearance_m.fill(no_bound_m);
    Nanoseconds before_ns = monotonic_now_ns();
    for (std::size_t beside = 0; beside < m_beside[muscle].size(); ++beside) {
      const int other = m_beside[muscle][beside];
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const double excess_travel_m = m_clearances ? m_clearances->excess_travel_m(nodes[i]) : no_bound_m;
        // Search no farther than the best clearance so far, if that alone proves the node free.
        const double enough_m = clearance_m[i] > excess_travel_m ? clearance_m[i] : no_bound_m;
        int& guess = m_guesses[static_cast<std::size_t>(nodes[i]) * m_most_beside + beside];
        const MuscleQuery wanted{m_touching_m, excess_travel_m, enough_m};
        clearance_m[i] = std::min(clearance_m[i], query(nodes[i], other, wanted, guess, chunk.found));
      }
      const Nanoseconds now_ns = monotonic_now_ns();
      chunk.pair_ns[pair_index(m_pairs, static_cast<int>(muscle), other)] += now_ns - before_ns;
      before_ns = now_ns;
    }
    for (std::size_t i = 0; i < nodes.size() && m_clearances; ++i) m_clearances->store(nodes[i], clearance_m[i]);
  }

  /// Returns the clearance.
  double query(int node, int muscle, const MuscleQuery& wanted, int& guess, std::vector<MuscleContact>& found) const {
    const Vec3& point = m_positions[static_cast<std::size_t>(node)];
    const MuscleAnswer answer = m_structures[static_cast<std::size_t>(muscle)]->query(point, wanted, guess);
    if (answer.triangle >= 0) {
      const auto& [a, b, c] = m_mesh.triangles[static_cast<std::size_t>(answer.triangle)];
      const std::array<Vec3, 3> corners = {m_positions[static_cast<std::size_t>(a)],
                                           m_positions[static_cast<std::size_t>(b)],
                                           m_positions[static_cast<std::size_t>(c)]};
      found.push_back(muscle_contact_at(node, muscle, point, answer.triangle, corners, answer.closest));
    }
    return answer.clearance_m;
  }

  const TriangleMesh& m_mesh;
  std::vector<Body> m_bodies;
  std::vector<MusclePair> m_pairs;
  int m_threads;
  double m_touching_m;
  std::vector<PairTime> m_pair_times;
  std::vector<std::vector<int>> m_beside;  ///< by muscle: those that it touches, ascending
  std::size_t m_most_beside = 0;
  std::vector<std::unique_ptr<DeformingStructure>> m_structures;  ///< by muscle; none where it touches no other
  std::vector<int> m_nodes;                                       ///< of muscles that touch others
  std::optional<MovingClearances> m_clearances;
  std::vector<int> m_guesses;  ///< by node, then muscle beside: the triangle that was closest last
  std::span<const Vec3> m_positions;
  std::span<const int> m_queried;
  std::vector<Chunk> m_chunks;
};

}  // namespace

std::unique_ptr<MuscleContactDetector> make_point_muscle_detector(const DeformingMethod& method,
                                                                  const TouchingMuscles& muscles, int threads) {
  return std::make_unique<PointMuscleDetector>(method, muscles, threads);
}

}  // namespace musclebench

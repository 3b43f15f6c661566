#include "backends/brute_force/muscle_detector.hpp"

#include <limits>
#include <numbers>
#include <optional>

#include "core/mesh/mesh_size.hpp"

namespace musclebench {

namespace {

/// A point closer to a surface than this, relative to the diagonal of all muscles, is on it.
constexpr double touching = 1e-12;

class BruteForceMuscleDetector final : public MuscleContactDetector {
 public:
  BruteForceMuscleDetector(const TouchingMuscles& muscles, int threads)
      : m_muscles(muscles),
        m_threads(threads),
        m_touching_m(touching * bounding_box(muscles.mesh.vertices).diagonal().norm()),
        m_pair_times(no_times(muscles.pairs)) {
    for (int muscle = 0; muscle < static_cast<int>(muscles.bodies.size()); ++muscle) {
      const Body& body = muscles.bodies[static_cast<std::size_t>(muscle)];
      const std::vector<int> beside = muscles_beside(muscles.pairs, muscle);
      for (int node = body.first_node; node < body.last_node; ++node) {
        for (const int other : beside) m_queries.push_back({node, other, pair_index(muscles.pairs, muscle, other)});
      }
    }
    m_answers.resize(m_queries.size());
  }

  void detect(std::span<const Vec3> positions, std::vector<MuscleContact>& contacts) override {
    contacts.clear();
    m_boxes.clear();
    for (const Body& body : m_muscles.bodies) {
      m_boxes.push_back(bounding_box(positions.subspan(static_cast<std::size_t>(body.first_node),
                                                       static_cast<std::size_t>(body.last_node - body.first_node))));
    }
    const auto count = static_cast<std::ptrdiff_t>(m_queries.size());
#pragma omp parallel for num_threads(m_threads) schedule(dynamic, 16)
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      Answer& answer = m_answers[static_cast<std::size_t>(i)];
      answer.took_ns = 0;
      const ScopedTimer timer(answer.took_ns);
      answer.contact = query(m_queries[static_cast<std::size_t>(i)], positions);
    }
    for (PairTime& time : m_pair_times) time.detect_ns = 0;
    for (std::size_t i = 0; i < m_queries.size(); ++i) {
      m_pair_times[m_queries[i].pair].detect_ns += m_answers[i].took_ns;
      if (m_answers[i].contact) contacts.push_back(*m_answers[i].contact);
    }
  }

  [[nodiscard]] std::span<const PairTime> pair_times() const override { return m_pair_times; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  struct Query {
    int node;
    int muscle;
    std::size_t pair;
  };
  struct Answer {
    std::optional<MuscleContact> contact;
    Nanoseconds took_ns = 0;
  };

  [[nodiscard]] std::optional<MuscleContact> query(const Query& query, std::span<const Vec3> positions) const {
    const Vec3& point = positions[static_cast<std::size_t>(query.node)];
    if (!m_boxes[static_cast<std::size_t>(query.muscle)].contains(point)) {
      return std::nullopt;
    }
    const Body& body = m_muscles.bodies[static_cast<std::size_t>(query.muscle)];
    ClosestOnTriangle closest;
    closest.squared_distance_m2 = std::numeric_limits<double>::infinity();
    std::array<Vec3, 3> corners_of_closest;
    int triangle = -1;
    double angle_sum = 0;
    for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
      const auto& [ia, ib, ic] = m_muscles.mesh.triangles[t];
      const std::array<Vec3, 3> corners = {positions[static_cast<std::size_t>(ia)],
                                           positions[static_cast<std::size_t>(ib)],
                                           positions[static_cast<std::size_t>(ic)]};
      const ClosestOnTriangle found = closest_on_triangle(point, corners[0], corners[1], corners[2]);
      if (found.squared_distance_m2 < closest.squared_distance_m2) {
        closest = found;
        corners_of_closest = corners;
        triangle = static_cast<int>(t);
      }
      angle_sum += solid_angle(point, corners[0], corners[1], corners[2]);
    }
    const bool is_inside = angle_sum > 2 * std::numbers::pi;  // winding number above one half
    if (!is_inside || !(closest.squared_distance_m2 > m_touching_m * m_touching_m)) {
      return std::nullopt;
    }
    return muscle_contact_at(query.node, query.muscle, point, triangle, corners_of_closest, closest);
  }

  TouchingMuscles m_muscles;
  [[maybe_unused]] int m_threads;
  double m_touching_m;
  std::vector<Query> m_queries;              ///< by node, then by the other muscle
  std::vector<Eigen::AlignedBox3d> m_boxes;  ///< by muscle; beyond it nothing is inside
  std::vector<Answer> m_answers;             ///< by query
  std::vector<PairTime> m_pair_times;
};

}  // namespace

std::unique_ptr<MuscleContactDetector> make_brute_force_muscle_detector(const Parameters& /*parameters*/,
                                                                        const TouchingMuscles& muscles, int threads) {
  return std::make_unique<BruteForceMuscleDetector>(muscles, threads);
}

}  // namespace musclebench

#include "core/measure/passing_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "core/measure/tunnelling_tracker.hpp"
#include "core/mesh/mesh_size.hpp"

namespace musclebench {
namespace {

std::span<const Vec3> nodes_of(const Body& body, std::span<const Vec3> positions) {
  return positions.subspan(static_cast<std::size_t>(body.first_node),
                           static_cast<std::size_t>(body.last_node - body.first_node));
}

Vec3 mean_of(std::span<const Vec3> points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

}  // namespace

int PassingTracker::update(const MuscleReferee& referee, std::span<const Vec3> positions) {
  m_work = 0;
  int passed = 0;
  for (std::size_t i = 0; i < m_muscles.bodies.size() && !m_last.empty(); ++i) {
    const Body& body = m_muscles.bodies[i];
    std::vector<char> has_passed(static_cast<std::size_t>(body.last_node - body.first_node), 0);
    for (const int other : m_muscles.beside[i]) {
      const Body& beside = m_muscles.bodies[static_cast<std::size_t>(other)];
      const Vec3 moved = mean_of(nodes_of(beside, positions)) - mean_of(nodes_of(beside, m_last));
      const Eigen::AlignedBox3d box = bounding_box(nodes_of(beside, positions));
      const RefereeTree& tree = referee.tree(other);
      const double grazing_m = grazing_share * box.diagonal().norm();
      for (int node = body.first_node; node < body.last_node; ++node) {
        const Vec3 from = m_last[static_cast<std::size_t>(node)] + moved;
        const Vec3& to = positions[static_cast<std::size_t>(node)];
        if (!box.intersects(Eigen::AlignedBox3d(from.cwiseMin(to), from.cwiseMax(to)))) continue;
        if (went_through(tree, from - tree.centre_m(), to - tree.centre_m(), grazing_m)) {
          has_passed[static_cast<std::size_t>(node - body.first_node)] = 1;
        }
      }
    }
    passed += static_cast<int>(std::count(has_passed.begin(), has_passed.end(), 1));
  }
  m_last.assign(positions.begin(), positions.end());
  return passed;
}

bool PassingTracker::went_through(const RefereeTree& tree, const Vec3& from, const Vec3& to, double grazing_m) {
  tree.cross(from, to, m_crossings, &m_work);
  if (m_crossings.size() < 2 || !m_crossings.front().entering || m_crossings.back().entering) return false;
  int layers = 0;
  SurfaceCrossing entry;
  for (const SurfaceCrossing& crossing : m_crossings) {
    if (crossing.entering && layers == 0) entry = crossing;
    layers += crossing.entering ? 1 : -1;
    if (layers > 0) continue;
    const double opposed = tree.face_normal(entry.slot).dot(tree.face_normal(crossing.slot));
    const Vec3 middle = from + (entry.share + crossing.share) / 2 * (to - from);
    const double depth_m = std::sqrt(tree.closest(middle, -1, &m_work).squared_distance_m2);
    if (opposed < TunnellingTracker::opposed_cosine && depth_m > grazing_m) return true;
  }
  return false;
}

}  // namespace musclebench

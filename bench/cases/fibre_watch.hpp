#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/fibres/muscle_fibres.hpp"
#include "core/measure/fibre_record.hpp"
#include "core/scene/scene.hpp"

namespace musclebench {

/// How many fibres of a muscle are followed.
struct FollowedFibres {
  std::string muscle;
  int asked = 0;
  int followed = 0;
};

/// Follows the fibres that a scene asks for (`Scene::fibre_count`) through a coupled run. It looks on and changes
/// nothing.
class FibreWatch {
 public:
  /// Throws InputError where a muscle's fibres are not inside it or do not reach its attachments: measured fibres of
  /// another muscle, say, or more than one in twenty that loses its way.
  FibreWatch(const Scene& scene, const std::vector<BoundNode>& bound, int threads);

  /// The fibres of each muscle, given the positions of all nodes.
  [[nodiscard]] std::vector<std::vector<Vec3>> points(std::span<const Vec3> positions) const;
  /// Their lengths, given their points.
  [[nodiscard]] FibreFrame frame(int number, double angle_rad, std::span<const std::vector<Vec3>> points) const;

  [[nodiscard]] const std::vector<FollowedFibres>& followed() const { return m_followed; }
  [[nodiscard]] std::size_t points_per_fibre() const;
  [[nodiscard]] std::size_t bytes() const;

 private:
  std::vector<Body> m_bodies;
  std::vector<MuscleFibres> m_fibres;  // by body
  std::vector<FollowedFibres> m_followed;
};

}  // namespace musclebench

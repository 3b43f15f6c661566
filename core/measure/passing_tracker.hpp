#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/referee/muscle_referee.hpp"

namespace musclebench {

/// Counts nodes that went through another muscle between two judged frames, in which neither frame shows them inside:
/// two that change sides at speed touch in none.
///
/// A node's path is taken as straight, relative to the other muscle's mean displacement, and compared with that
/// muscle's surface as it is now. It went through where it enters by one face and leaves by one that faces the other
/// way (as TunnellingTracker says), and is deep enough halfway between.
class PassingTracker {
 public:
  /// Depth on the path below which a muscle was grazed, over its diagonal.
  static constexpr double grazing_share = 0.005;

  explicit PassingTracker(JudgedMuscles muscles) : m_muscles(std::move(muscles)) {}

  /// Takes the next frame: `referee` has judged `positions`. Returns the nodes that went through since the last call.
  int update(const MuscleReferee& referee, std::span<const Vec3> positions);

  /// Of the last call, in the unit of RefereeTree.
  [[nodiscard]] long last_work() const { return m_work; }

 private:
  [[nodiscard]] bool went_through(const RefereeTree& tree, const Vec3& from, const Vec3& to, double grazing_m);

  JudgedMuscles m_muscles;
  std::vector<Vec3> m_last;  // positions of the last call; none before the first
  long m_work = 0;
  std::vector<SurfaceCrossing> m_crossings;  // scratch memory
};

}  // namespace musclebench

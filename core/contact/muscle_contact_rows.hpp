#pragma once

#include <span>
#include <vector>

#include "core/contact/contact_rows.hpp"
#include "core/contact/muscle_contact.hpp"

namespace musclebench {

/// How often the contacts of a detection are corrected. A pair whose steps are done is left as it is while others go
/// on.
struct PairSteps {
  int most = 1;  ///< >= 1; of all pairs that are not told below
  std::vector<Body> bodies = {};
  std::vector<MusclePair> pairs = {};
  std::vector<int> of_pairs = {};  ///< >= 1; empty: `most` for all

  PairSteps(int steps) : most(steps) {}  // NOLINT(google-explicit-constructor)
  PairSteps(std::vector<Body> muscles, std::vector<MusclePair> touching, std::vector<int> steps);

  [[nodiscard]] int of(const MuscleContact& contact) const;
};

/// The rows of contacts between muscles, into `rows`, which is overwritten. A contact between a node p and the closest
/// point q = sum b_i q_i of a triangle is the constraint n . (p - q) >= 0: the node moves along the normal n and the
/// triangle's corners against it, each by its inverse mass and its weight (the point-triangle constraint of Mueller et
/// al. 2007, "Position based dynamics", sections 3.4 and 4.3). `triangles`: of the mesh of all muscles.
void rows_of(std::span<const MuscleContact> contacts, std::span<const Triangle> triangles, const PairSteps& steps,
             std::vector<ContactRow>& rows);

}  // namespace musclebench

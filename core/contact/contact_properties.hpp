#pragma once

namespace musclebench {

/// How all contacts of a scene behave, whatever finds them: nodes, faces and edges, with bones, other muscles and the
/// muscle itself.
struct ContactProperties {
  double friction_coefficient = 0;  ///< of Coulomb, >= 0
  double margin_m = 0;              ///< that muscles keep from bones, >= 0
};

/// Coulomb's law as a limit on displacements (Macklin et al. 2014, "Unified particle physics for real-time
/// applications"): the share, 0 to 1, of a slide of `slide_m` that friction undoes where the contact's points were
/// pushed apart by `push_m`.
inline double share_undone_by_friction(double slide_m, double push_m, double coefficient) {
  const double limit_m = coefficient * push_m;
  return slide_m <= limit_m ? 1 : limit_m / slide_m;
}

}  // namespace musclebench

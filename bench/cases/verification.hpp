#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/contact/collision_backend.hpp"

namespace musclebench {

struct VerificationSettings {
  /// Points at which the first exact backend and the Referee are compared. About a surface that is not closed 1/50 of
  /// them: there each winding number of the Referee costs time in proportion to the number of boundary edges.
  std::int64_t points = 1'000'000;
  std::int64_t brute_force_points =
      10'000;  ///< the first of them, where both are compared with the others that can judge the bone
  std::uint64_t seed = 1;
  int threads = 1;
};

/// How far two signed distances may lie apart, and how far from the surface their signs may differ: a share of the
/// surface's diagonal, and roundings of its largest coordinate, which not every backend subtracts before it computes.
constexpr double agreed_share = 1e-12;
constexpr double agreed_roundings = 64;

/// The largest difference of two signed distances to the mesh that rounding explains, m.
double agreed_difference_m(const TriangleMesh& mesh);

/// How two implementations of the same signed distance agree.
struct Agreement {
  std::string first;  ///< name of a backend, or "Referee"
  std::string second;
  std::int64_t points = 0;
  double largest_difference_m = 0;  ///< of the distances without their signs
  Vec3 worst_point_m = Vec3::Zero();
  std::int64_t sign_differences = 0;  ///< at points farther than `agreed_m` from the surface
  std::int64_t inside = 0;            ///< by the first of the two
};

struct SurfaceVerification {
  double diagonal_m = 0;
  double agreed_m = 0;  ///< largest difference between two answers
  std::vector<Agreement>
      pairs;  ///< the first exact backend and the Referee; then each of them and the others that can judge the bone
  double seconds = 0;

  [[nodiscard]] bool holds(const Agreement& agreement) const;
  [[nodiscard]] bool held() const;
};

/// `count` test points about a surface, hard ones among them, in the same mix at every length of the list, the same for
/// the same seed: anywhere in the box enlarged by 10 % on each side; on the surface, moved by about 1/200 of the
/// diagonal (2 mm at a hip), by 1e-6 and by 1e-12 of it; vertices and middles of edges as they are. Small triangles get
/// as many as large ones.
std::vector<Vec3> points_about(const TriangleMesh& mesh, std::int64_t count, std::uint64_t seed);

/// Work that has been done, of the whole of one stage.
using VerificationProgress = std::function<void(const std::string& stage, int done, int total)>;

/// Compares the exact backends of this build, those that are exact about this surface, and the Referee. The result does
/// not depend on the number of threads. Throws InputError where the surface has no triangles or the build no exact
/// backend.
SurfaceVerification verify_surface(const Bone& bone, const VerificationSettings& settings,
                                   const VerificationProgress& progress);

}  // namespace musclebench

#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// An implicit solid: an estimate of the signed distance in metres, negative inside. The estimates of this folder never
/// exceed the true distance outside (they are 1-Lipschitz up to a few per cent), so a clearance that is kept in the
/// estimate is kept in truth. Only +, -, *, / and square roots are used: the same bits on every platform.
using Field = std::function<double(const Vec3&)>;

/// Polynomial smooth minimum: differs from min(a, b) only where |a - b| < blend, by at most blend / 4.
double smooth_min(double a, double b, double blend);

/// Polynomial smooth maximum, the mirror image of smooth_min.
double smooth_max(double a, double b, double blend);

/// One station of a strand; millimetres, because these are tables for people.
struct Station {
  double x_mm = 0;
  double y_mm = 0;
  double z_mm = 0;
  double radius_mm = 0;
};

/// A tube of varying radius along the Catmull-Rom curve through its stations: a ridge of a bone, a bundle of a muscle.
class Strand {
 public:
  explicit Strand(std::span<const Station> stations);

  /// min(limit_m, signed distance to the strand): parts that cannot go below `limit_m` are skipped.
  [[nodiscard]] double distance(const Vec3& point, double limit_m) const;

 private:
  /// The hull of two spheres at the ends of a segment.
  struct RoundCone {
    Vec3 start_m;
    Vec3 direction;
    double length_m;
    double start_radius_m;
    double radius_drop;  ///< loss of radius over length, the sine of the cone's slope
    double slope_ratio;  ///< sine over cosine of the slope
    Vec3 centre_m;
    double reach_m;  ///< radius of a sphere around centre_m that holds the cone
  };

  std::vector<RoundCone> m_cones;
  Vec3 m_centre_m = Vec3::Zero();
  double m_reach_m = 0;
};

/// Several strands, blended into one another within `blend_m`.
class StrandBundle {
 public:
  StrandBundle(std::span<const std::vector<Station>> strands, double blend_m)
      : m_strands(strands.begin(), strands.end()), m_blend_m(blend_m) {}

  /// The smooth minimum of `start_m` and of all strands.
  [[nodiscard]] double distance(const Vec3& point, double start_m = 1e3) const;

 private:
  std::vector<Strand> m_strands;
  double m_blend_m;
};

}  // namespace musclebench

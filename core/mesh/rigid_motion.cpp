#include "core/mesh/rigid_motion.hpp"

#include "core/base/portable_math.hpp"

namespace musclebench {

RigidMotion RigidMotion::about_axis(const Vec3& axis, const Vec3& centre_m, double angle_rad) {
  const double sine = portable::sin(angle_rad);
  const double cosine = portable::cos(angle_rad);
  Mat3 across;  // axis x
  across << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  const Mat3 rotation = cosine * Mat3::Identity() + sine * across + (1 - cosine) * axis * axis.transpose();
  return {rotation, centre_m - rotation * centre_m};
}

}  // namespace musclebench

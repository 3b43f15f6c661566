#include "core/mesh/body.hpp"

#include "core/mesh/surface_volume.hpp"

namespace musclebench {

double body_volume_m3(std::span<const Vec3> positions, std::span<const Triangle> triangles, const Body& body) {
  return surface_volume_m3(positions, triangles.subspan(body.first_triangle, body.last_triangle - body.first_triangle),
                           positions[static_cast<std::size_t>(body.first_node)]);
}

}  // namespace musclebench

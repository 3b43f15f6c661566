#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "backends/simbody/simbody_mesh.hpp"
#include "core/base/unsupported_input.hpp"
#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

namespace {

std::unique_ptr<SimbodyMesh> to_simbody(const Bone& bone) {
  std::vector<std::array<double, 3>> vertices;
  for (const Vec3& vertex : bone.surface.mesh.vertices) vertices.push_back({vertex.x(), vertex.y(), vertex.z()});
  std::vector<int> corners;
  for (const Triangle& triangle : bone.surface.mesh.triangles) {
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  }
  try {
    return std::make_unique<SimbodyMesh>(vertices, corners);
  } catch (const std::runtime_error& refused) {
    std::string why = refused.what();
    why.erase(why.find_last_not_of(" \n") + 1);
    for (char& c : why) c = c == '\n' ? ' ' : c;
    throw UnsupportedInput(fmt::format("simbody: bone '{}'", bone.name),
                           fmt::format("Simbody takes closed manifold surfaces only; use another backend ({})", why));
  }
}

class SimbodyBone {
 public:
  explicit SimbodyBone(const Bone& bone)
      : m_mesh(to_simbody(bone)),
        m_touching_m(touching_distance_m(bone.surface.mesh)),
        m_is_clean(bone.surface.clean) {}

  /// Of surfaces where the normal of the nearest face tells the side; beside a sharp edge Simbody may err by any depth.
  [[nodiscard]] AnswerBound answer_bound() const {
    const double side_m = m_is_clean ? m_touching_m : std::numeric_limits<double>::infinity();
    return {side_m, side_m};
  }
  [[nodiscard]] std::size_t bytes() const { return sizeof(*this) + m_mesh->bytes(); }
  [[nodiscard]] static std::optional<StructureError> error() { return std::nullopt; }
  [[nodiscard]] const SimbodyBone& session() const { return *this; }

  [[nodiscard]] LocatedPoint locate(const Vec3& point, int& /*near*/) const {
    const SimbodyMesh::Nearest found = m_mesh->nearest({point.x(), point.y(), point.z()});
    const Vec3 out = Vec3(found.point[0], found.point[1], found.point[2]) - point;
    const double distance_m = out.norm();
    if (found.inside && distance_m > m_touching_m) {
      return {.inside = true, .depth_m = distance_m, .outward = out / distance_m};
    }
    return {.clearance_m = m_is_clean ? distance_m : 0};
  }

 private:
  std::unique_ptr<SimbodyMesh> m_mesh;
  double m_touching_m;
  bool m_is_clean;
};

std::unique_ptr<CollisionBackend> make_simbody_backend(const Parameters& parameters) {
  return make_point_backend(
      {.capabilities = {.has_cache = uses_clearance_cache(parameters)},
       .nodes_a_batch = 64,
       .contact_reach_m = [](const Bone& bone) { return touching_distance_m(bone.surface.mesh); },
       .build = build_located(parameters, [](const Bone& bone, int /*threads*/, const ShareReport& /*report*/) {
         return std::make_unique<const SimbodyBone>(bone);
       })});
}

}  // namespace

// How it is driven follows Simbody's reference of ContactGeometry::TriangleMesh: `smooth` false, as a bone is faceted.
BackendEntry simbody_entry() {
  return {.name = "simbody",
          .help = "nearest point by the contact mesh of Simbody, which OpenSim has under it",
          .implementation = fmt::format("Simbody {}, Apache-2.0", SimbodyMesh::version()),
          .default_response = ResponseKind::project,
          .parameters = {cull_parameter(), clearance_cache_parameter()},
          .make = make_simbody_backend};
}

}  // namespace musclebench

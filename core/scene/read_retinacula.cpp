#include "core/scene/read_retinacula.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/retinaculum.hpp"
#include "core/scene/read_contact.hpp"

namespace musclebench {

namespace {

constexpr double default_slide_m = 0.03;

/// What of a muscle is in the plane of a ring at rest.
struct Section {
  double nearest_m = std::numeric_limits<double>::infinity();  ///< of all nodes, to the centre
  double widest_m = 0;        ///< of the edges through the plane of the tendon, how far from the axis they pass it
  double longest_edge_m = 0;  ///< of these
  double radius_m = 0;        ///< of the tendon: about the middle of where they pass
};

Section section_of(const TriangleMesh& mesh, const Body& body, const Retinaculum& ring) {
  Section section;
  for (int node = body.first_node; node < body.last_node; ++node) {
    const Vec3& at = mesh.vertices[static_cast<std::size_t>(node)];
    section.nearest_m = std::min(section.nearest_m, (at - ring.centre_m).norm());
  }
  std::vector<Vec3> places_m;
  for (std::size_t t = body.first_triangle; t < body.last_triangle; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = mesh.triangles[t][k];
      const int to = mesh.triangles[t][(k + 1) % 3];
      if (!std::ranges::binary_search(ring.nodes, from) || !std::ranges::binary_search(ring.nodes, to)) continue;
      const Vec3& a = mesh.vertices[static_cast<std::size_t>(from)];
      const Vec3& b = mesh.vertices[static_cast<std::size_t>(to)];
      const auto crossing = crossing_of(ring, a, b);
      if (!crossing) continue;
      places_m.push_back(crossing->outwards_m * crossing->outwards);
      section.widest_m = std::max(section.widest_m, crossing->outwards_m);
      section.longest_edge_m = std::max(section.longest_edge_m, (b - a).norm());
    }
  }
  const Eigen::AlignedBox3d box = bounding_box(places_m);
  for (const Vec3& place_m : places_m) section.radius_m = std::max(section.radius_m, (place_m - box.center()).norm());
  return section;
}

Vec3 unit_axis(const TomlTable& table) {
  const Vec3 axis = table.point("axis");
  if (!(axis.cwiseAbs().maxCoeff() > 0)) {
    throw InputError(table.location("axis"), "has no length; give the direction of the tendon in the ring");
  }
  return (axis / axis.cwiseAbs().maxCoeff()).normalized();
}

void require_fit(const TomlTable& table, const std::string& muscle, const Retinaculum& ring, const Section& section) {
  if (ring.nodes.empty()) {
    throw InputError(
        table.location("centre_m"),
        fmt::format("nothing of {} passes through the ring at rest: its nearest node is {:.1f} mm from the "
                    "centre; move the ring to the tendon, or give a larger radius_m",
                    muscle, 1e3 * section.nearest_m));
  }
  constexpr double widest_ring = 20;  // tendons
  if (ring.radius_m > widest_ring * section.radius_m) {
    throw InputError(table.location("radius_m"),
                     fmt::format("is {:.3g} mm, and the tendon of {} is {:.3g} mm thick there, so that it would hold "
                                 "nothing; is it in metres?",
                                 1e3 * ring.radius_m, muscle, 2e3 * section.radius_m));
  }
  if (section.widest_m > ring.radius_m) {
    throw InputError(table.location("radius_m"),
                     fmt::format("is {:.2f} mm, and {} reaches {:.2f} mm from the ring's axis at rest; give at least "
                                 "that, or move the ring to where no other part of the muscle is beside it",
                                 1e3 * ring.radius_m, muscle, 1e3 * section.widest_m));
  }
  if (section.longest_edge_m > 2 * ring.half_width_m) {
    throw InputError(table.location(table.has("half_width_m") ? "half_width_m" : "radius_m"),
                     fmt::format("makes the ring {:.1f} mm wide, and edges of {} through it are up to {:.1f} mm long: "
                                 "one could pass without a node in it; give a half_width_m of {:.4f} or more",
                                 2e3 * ring.half_width_m, muscle, 1e3 * section.longest_edge_m,
                                 std::ceil(5e3 * section.longest_edge_m) / 1e4));
  }
}

}  // namespace

void read_retinacula(const TomlTable& root, Scene& scene) {
  if (!root.has("retinaculum")) return;
  for (const TomlTable& table : root.table_or_tables("retinaculum")) {
    table.allow_only({"name", "bone", "muscle", "centre_m", "axis", "radius_m", "half_width_m", "slide_m"});
    Retinaculum ring;
    ring.name = table.word("name");
    if (std::ranges::find(scene.retinacula, ring.name, &Retinaculum::name) != scene.retinacula.end()) {
      throw InputError(table.location("name"),
                       fmt::format("'{}' is the name of an earlier ring; choose another", ring.name));
    }
    ring.location = table.place();
    ring.bone = static_cast<int>(find_bone(scene, table.word("bone"), table.location("bone")));
    if (!table.has("muscle") && scene.muscles.size() > 1) {
      throw InputError(table.location("muscle"), "is missing: in a scene of several muscles a ring names its own");
    }
    ring.muscle = table.has("muscle") ? find_muscle(scene, table.word("muscle"), table.location("muscle")) : 0;
    ring.centre_m = table.point("centre_m");
    ring.axis = unit_axis(table);
    constexpr double least_m = 1e-6;
    ring.radius_m = table.number("radius_m", least_m, 10);
    ring.half_width_m = table.has("half_width_m") ? table.number("half_width_m", least_m, 10) : ring.radius_m;
    const double slide_m = table.has("slide_m") ? table.number("slide_m", 0, 10) : default_slide_m;
    const Body& body = scene.muscles[ring.muscle].body;
    ring.nodes = nodes_through_ring(scene.muscle_mesh, body, ring, slide_m);
    const Section section = section_of(scene.muscle_mesh, body, ring);
    require_fit(table, body.name, ring, section);
    ring.clearance_m = std::max(0.0, ring.radius_m - section.radius_m);
    scene.retinacula.push_back(std::move(ring));
  }
}

}  // namespace musclebench

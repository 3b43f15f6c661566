#include "datasets/simple_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/input_error.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/split_mesh.hpp"
#include "datasets/sharp_shapes.hpp"

namespace musclebench {

namespace {

TriangleMesh moved(TriangleMesh mesh, const Vec3& by_m) {
  for (Vec3& vertex : mesh.vertices) vertex += by_m;
  return mesh;
}

/// Turned by an angle about the y axis, given by its sine and cosine, so that no bit depends on a library's functions.
TriangleMesh turned(TriangleMesh mesh, double sine, double cosine) {
  for (Vec3& vertex : mesh.vertices) {
    vertex = Vec3(cosine * vertex.x() + sine * vertex.z(), vertex.y(), cosine * vertex.z() - sine * vertex.x());
  }
  return mesh;
}

TriangleMesh box(const Vec3& half_m, const Vec3& centre_m, int cells = 4) {
  return moved(make_box(half_m, cells), centre_m);
}

TriangleMesh ball(double height_m) { return moved(make_sphere(0.02, 3), Vec3(0, 0, height_m)); }

/// A capsule along x instead of z.
TriangleMesh lying_capsule(double radius_m, double half_length_m, int segments) {
  TriangleMesh mesh = make_capsule(radius_m, half_length_m, segments);
  for (Vec3& vertex : mesh.vertices) vertex = Vec3(vertex.z(), vertex.x(), vertex.y());
  return mesh;
}

/// Turned by a quarter about the z axis, so that what ran along y runs along x.
TriangleMesh quarter_turned(TriangleMesh mesh) {
  for (Vec3& vertex : mesh.vertices) vertex = Vec3(-vertex.y(), vertex.x(), vertex.z());
  return mesh;
}

/// Two bodies as one mesh.
TriangleMesh joined(TriangleMesh mesh, const TriangleMesh& other) {
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
  return mesh;
}

/// Two rails along x at y = -10 and 10 mm, 3 mm wide, their tops at z = 0.
TriangleMesh rails() {
  const auto rail = [](double y_m) { return box({0.19, 0.0015, 0.005}, {0, y_m, -0.005}, 1); };
  return joined(rail(-0.01), rail(0.01));
}

/// Two ridges along x at y = -5 and 5 mm, their sharp edges at z = 0.
TriangleMesh ridges() {
  const TriangleMesh one = quarter_turned(make_wedge(0.002, 0.01, 0.19, 1));
  return joined(moved(one, Vec3(0, -0.005, 0)), moved(one, Vec3(0, 0.005, 0)));
}

/// A square bar along x with an edge up and an edge down, nodes every 10 mm along them.
TriangleMesh bar_on_edge() {
  TriangleMesh mesh = make_box(Vec3(0.04, 0.005, 0.005), 8);
  const double half = std::sqrt(0.5);
  for (Vec3& vertex : mesh.vertices) {
    vertex = Vec3(vertex.x(), half * (vertex.y() - vertex.z()), half * (vertex.y() + vertex.z()));
  }
  return mesh;
}
constexpr double bar_half_height_m = 0.0070710678118654752;

/// A block whose top has a round hollow: 10 mm deep, its bottom at z = 0, a paraboloid of 30 mm radius of curvature.
TriangleMesh bowl() {
  constexpr double rim_m = 0.01;
  TriangleMesh mesh = box({0.04, 0.04, 0.0125}, {0, 0, rim_m - 0.0125}, 10);
  for (Vec3& vertex : mesh.vertices) {
    if (vertex.z() < rim_m) continue;
    vertex.z() = std::min(rim_m, vertex.head<2>().squaredNorm() / 0.06);
  }
  return mesh;
}

/// 1 mm square and 20 mm tall, its flat tip at z = 0, beside a base 1 mm below its foot.
TriangleMesh needle() {
  return joined(box({0.0005, 0.0005, 0.01}, {0.002, 0.002, -0.01}, 1), box({0.03, 0.03, 0.005}, {0, 0, -0.026}, 1));
}

/// Edges of 3 cm, its base on z = 0.
TriangleMesh tetrahedron() {
  constexpr double edge_m = 0.03;
  const double inner_m = edge_m / std::sqrt(12.0);  // centre of the base to its sides
  return {
      {{2 * inner_m, 0, 0}, {-inner_m, edge_m / 2, 0}, {-inner_m, -edge_m / 2, 0}, {0, 0, edge_m * std::sqrt(2.0 / 3)}},
      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

/// Two triangles in the plane z = 0 that share an edge along y; one lies at x < 0, the other at x > 0.
TriangleMesh hinge() { return {{{0, -0.015, 0}, {0, 0.015, 0}, {-0.03, 0, 0}, {0.03, 0, 0}}, {{0, 1, 2}, {1, 0, 3}}}; }

/// A sheet along x that is folded back over itself: its lower half on z = 0, the upper one `gap_m` above.
TriangleMesh folded_sheet(double gap_m) {
  constexpr double cell_m = 0.004;
  constexpr int columns = 10;  // of a half
  constexpr int rows = 6;
  TriangleMesh mesh;
  const auto add_row = [&](double x_m, double z_m) {
    for (int j = 0; j <= rows; ++j) mesh.vertices.emplace_back(x_m, cell_m * (j - 0.5 * rows), z_m);
  };
  for (int i = 0; i < columns; ++i) add_row(cell_m * (i - 0.5 * columns), 0);
  add_row(cell_m * 0.5 * columns, 0.5 * gap_m);
  for (int i = columns - 1; i >= 0; --i) add_row(cell_m * (i + 0.3 - 0.5 * columns), gap_m);  // not node above node
  for (int i = 0; i < 2 * columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const int corner = i * (rows + 1) + j;
      const int next = corner + rows + 1;
      mesh.triangles.push_back({corner, next + 1, next});
      mesh.triangles.push_back({corner, corner + 1, next + 1});
    }
  }
  return mesh;
}

/// A prism along y whose sharp edge is up, at z = 0.
TriangleMesh ridge() {
  constexpr double half_width_m = 0.008;
  constexpr double half_length_m = 0.05;
  constexpr double height_m = 0.02;
  return {{{-half_width_m, -half_length_m, -height_m},
           {half_width_m, -half_length_m, -height_m},
           {0, -half_length_m, 0},
           {-half_width_m, half_length_m, -height_m},
           {half_width_m, half_length_m, -height_m},
           {0, half_length_m, 0}},
          {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}, {0, 2, 5}, {0, 5, 3}}};
}

/// Sides of a groove along y: they fall by 3 in 4 towards x = 0, where they meet at z = 0 and go on into each other.
TriangleMesh groove_side(double side) {
  // The upper face of a box, turned about the edge that it shares with the other side.
  return turned(box({0.05, 0.05, 0.01}, {side * 0.04, 0, -0.01}), side * -0.6, 0.8);
}

struct NamedShape {
  std::string_view name;
  TriangleMesh (*make)();
};

constexpr std::array shapes = {
    // Muscles.
    NamedShape{"ball", [] { return ball(0.02); }},
    NamedShape{"upper_ball", [] { return ball(0.061); }},
    NamedShape{"raised_ball", [] { return ball(0.03); }},
    // Its lowest place between sides that fall by 3 in 4: radius over their cosine above the groove's bottom.
    NamedShape{"groove_ball", [] { return ball(0.02 / 0.8); }},
    NamedShape{"tetrahedron", tetrahedron},
    NamedShape{"hinge", hinge},
    NamedShape{"coarse_ball", [] { return moved(make_sphere(0.02, 2), Vec3(0, 0, 0.02)); }},
    NamedShape{"folded_sheet", [] { return folded_sheet(0.008); }},
    NamedShape{"block",
               [] {
                 return turned(box({0.02, 0.02, 0.01}, {0, 0, 0.01}, 6), 0.6, 0.8);
               }},
    NamedShape{"resting_block",
               [] {
                 return box({0.02, 0.02, 0.01}, {0, 0, 0.01}, 6);
               }},
    NamedShape{"slab",
               [] {
                 return box({0.02, 0.02, 0.003}, {0, 0, 0.003}, 6);
               }},
    NamedShape{"tube", [] { return moved(lying_capsule(0.01, 0.05, 32), Vec3(0, 0, 0.01)); }},
    NamedShape{"coarse_tube", [] { return moved(lying_capsule(0.01, 0.05, 12), Vec3(0, 0, 0.01)); }},
    // Their lowest corner, edge or face half a millimetre above z = 0.
    NamedShape{"soft_spike", [] { return moved(split_flat(make_cone(0.008, 0.025, 12, -1), 2), Vec3(0, 0, 0.0005)); }},
    NamedShape{"soft_wedge",
               [] { return moved(split_flat(make_wedge(0.008, 0.02, 0.015, -1), 3), Vec3(0, 0, 0.0005)); }},
    NamedShape{"soft_cube",
               [] {
                 return box({0.01, 0.01, 0.01}, {0, 0, 0.0105}, 6);
               }},
    // Fills the groove of grooved_block to the bit.
    NamedShape{"groove_filling",
               [] { return moved(split_flat(make_wedge(0.02, 0.02, 0.03, -1), 3), Vec3(0, 0, -0.02)); }},
    // Between sides that fall by 3 in 4, its lowest edge where they meet.
    NamedShape{"groove_wedge", [] { return split_flat(make_wedge(0.02, 0.015, 0.015, -1), 3); }},
    NamedShape{"skids", [] { return turned(make_skids(0.02), 0.6, 0.8); }},
    // Over edges between nodes: each is off the other's middle by half an edge.
    NamedShape{"lower_bar", [] { return moved(bar_on_edge(), Vec3(0, 0.005, -bar_half_height_m)); }},
    NamedShape{"upper_bar",
               [] { return moved(quarter_turned(bar_on_edge()), Vec3(0.005, 0, 0.001 + bar_half_height_m)); }},
    NamedShape{"ball_on_slab", [] { return moved(make_sphere(0.02, 2), Vec3(0, 0, 0.0265)); }},
    NamedShape{"left_ball", [] { return moved(make_sphere(0.02, 2), Vec3(-0.0205, 0, 0)); }},
    NamedShape{"right_ball", [] { return moved(make_sphere(0.02, 2), Vec3(0.0205, 0.012, 0.003)); }},
    NamedShape{"bowl_ball", [] { return moved(make_sphere(0.02, 2), Vec3(0, 0, 0.021)); }},
    NamedShape{"swept_ball", [] { return moved(make_sphere(0.015, 2), Vec3(0.04, 0, 0.021)); }},
    NamedShape{"overlapping_ball", [] { return moved(make_sphere(0.02, 2), Vec3(0.0175, 0, 0)); }},
    NamedShape{"ball_in_skin", [] { return moved(make_sphere(0.02, 2), Vec3(0, 0, 0.0205)); }},
    NamedShape{"flying_block",
               [] {
                 return box({0.02, 0.02, 0.01}, {0, 0, 0.011}, 6);
               }},
    NamedShape{"channel", [] { return make_channel(0.01); }},
    // Bones.
    NamedShape{"rails", [] { return turned(rails(), 0.6, 0.8); }},
    NamedShape{"ridges", [] { return turned(ridges(), 0.6, 0.8); }},
    NamedShape{"far_bone",
               [] {
                 return box({0.01, 0.01, 0.01}, {0, 0, -0.25});
               }},
    NamedShape{"bowl", bowl},
    NamedShape{"needle", needle},
    NamedShape{"steep_ridge", [] { return moved(make_wedge(0.011547, 0.02, 0.05, 1), Vec3(0.002, 0, 0)); }},
    NamedShape{"left_plate",
               [] {
                 return box({0.03, 0.06, 0.005}, {-0.035, 0, -0.005});
               }},
    NamedShape{"right_plate",
               [] {
                 return box({0.03, 0.06, 0.005}, {0.035, 0, -0.005});
               }},
    NamedShape{"press",
               [] {
                 return box({0.03, 0.03, 0.005}, {0, 0, 0.052});
               }},
    NamedShape{"lid",
               [] {
                 return box({0.03, 0.03, 0.0025}, {0, 0, 0.0275});
               }},
    // 1.2 mm above and below a tube; they end where its ends are bound.
    NamedShape{"low_ceiling",
               [] {
                 return box({0.055, 0.03, 0.005}, {-0.005, 0, 0.0262});
               }},
    NamedShape{"low_floor",
               [] {
                 return box({0.055, 0.03, 0.005}, {-0.005, 0, -0.0062});
               }},
    NamedShape{"paddle",
               [] {
                 return box({0.06, 0.03, 0.004}, {0, 0, 0});
               }},
    NamedShape{"poking_ball", [] { return moved(make_sphere(0.004, 2), Vec3(0, 0.003, 0.0245)); }},
    NamedShape{"left_jaw",
               [] {
                 return box({0.005, 0.02, 0.02}, {-0.02, 0, 0.015});
               }},
    NamedShape{"right_jaw",
               [] { return moved(quarter_turned(lying_capsule(0.005, 0.02, 16)), Vec3(0.0205, 0, 0.023)); }},
    NamedShape{"right_rod", [] { return moved(make_capsule(0.006, 0.02, 12), Vec3(0.03, 0, 0.0465)); }},
    NamedShape{"left_rod", [] { return moved(make_capsule(0.006, 0.02, 12), Vec3(-0.03, 0, 0.0465)); }},
    NamedShape{"middle_rod", [] { return moved(make_capsule(0.006, 0.02, 12), Vec3(0.002, 0, 0.0465)); }},
    NamedShape{"spike", [] { return make_cone(0.01, 0.04, 24, 1); }},
    NamedShape{"cracked_block", [] { return make_cracked_block(0.006, 0.02); }},
    NamedShape{"grooved_block", [] { return split_flat(make_cracked_block(0.02, 0.02), 2); }},
    NamedShape{"holed_plate", make_holed_plate},
    NamedShape{"fine_plate",
               [] {
                 return box({0.06, 0.06, 0.005}, {0, 0, -0.005}, 10);
               }},
    NamedShape{"cliff",
               [] {
                 return box({0.03, 0.05, 0.02}, {-0.03, 0, -0.02});
               }},
    NamedShape{"plate",
               [] {
                 return box({0.06, 0.06, 0.005}, {0, 0, -0.005});
               }},
    NamedShape{"plate_1mm_up",
               [] {
                 return box({0.06, 0.06, 0.005}, {0, 0, -0.004});
               }},
    NamedShape{"plate_5mm_up",
               [] {
                 return box({0.06, 0.06, 0.005}, Vec3::Zero());
               }},
    NamedShape{"lower_jaw", [] { return moved(make_sphere(0.012, 2), Vec3(0, 0, -0.012)); }},
    NamedShape{"upper_jaw", [] { return moved(make_sphere(0.012, 2), Vec3(0, 0, 0.02)); }},
    NamedShape{"cave",
               [] {
                 return box({0.1, 0.1, 0.1}, {0, 0, 0.02});
               }},
    NamedShape{"core", [] { return moved(make_sphere(0.005, 3), Vec3(0, 0, 0.02)); }},
    NamedShape{"wall",
               [] {
                 return box({0.005, 0.06, 0.06}, {-0.06, 0, 0});
               }},
    NamedShape{"shelf",
               [] {
                 return box({0.03, 0.03, 0.005}, {-0.031, 0, -0.005});
               }},
    NamedShape{"slope",
               [] {
                 return turned(box({0.2, 0.05, 0.01}, {0, 0, -0.01}), 0.6, 0.8);
               }},
    NamedShape{"thin_plate",
               [] {
                 return box({0.06, 0.06, 0.002}, {0, 0, -0.032});
               }},
    NamedShape{"ridge", ridge},
    NamedShape{"groove_left", [] { return groove_side(-1); }},
    NamedShape{"groove_right", [] { return groove_side(1); }},
    NamedShape{"rod", [] { return moved(make_capsule(0.006, 0.02, 24), Vec3(-0.045, 0, 0.046)); }},
    NamedShape{"left_block",
               [] {
                 return box({0.01, 0.02, 0.02}, {-0.07, 0, 0.01});
               }},
    NamedShape{"right_block",
               [] {
                 return box({0.01, 0.02, 0.02}, {0.07, 0, 0.01});
               }},
};

}  // namespace

TriangleMesh simple_shape(std::string_view name) {
  const auto found = std::ranges::find(shapes, name, &NamedShape::name);
  if (found == shapes.end()) {
    throw InputError("synthetic:" + std::string(name),
                     "is unknown; did you mean '" + nearest_word(name, simple_shape_names()) + "'?");
  }
  return found->make();
}

std::vector<std::string> simple_shape_names() {
  std::vector<std::string> names;
  for (const NamedShape& shape : shapes) names.emplace_back(shape.name);
  return names;
}

}  // namespace musclebench

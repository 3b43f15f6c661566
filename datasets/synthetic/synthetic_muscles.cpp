#include "datasets/synthetic/synthetic_muscles.hpp"

#include <cassert>
#include <utility>

#include "datasets/synthetic/synthetic_bones.hpp"

namespace musclebench {

namespace {

using Bundles = std::vector<std::vector<Station>>;

constexpr double hip_clearance_m = 0.0006;
constexpr double femur_clearance_m = 0.0010;

/// From the pubic body to the inner side of the upper shaft.
Bundles adductor_brevis_bundles() {
  return {{{79, -40, -38, 5.5}, {52, -20, -55, 8}, {18, 0, -68, 9}, {-10, 15, -74, 9.5}, {-22, 15, -76, 6}},
          {{73, -27, -46, 6}, {48, -12, -61, 8.5}, {16, 6, -75, 9}, {-8, 22, -84, 9.5}, {-20, 21, -87, 6}},
          {{66, -13, -50, 5.5}, {44, -2, -66, 8.5}, {14, 12, -82, 9}, {-9, 30, -94, 9}, {-20, 32, -97, 6}}};
}

/// From the back of the ilium and the sacrum to the gluteal tuberosity.
Bundles gluteus_maximus_bundles() {
  return {
      {{34, 62, 122, 9},
       {12, 64, 96, 14},
       {-24, 62, 40, 17},
       {-46, 58, -20, 17},
       {-48, 48, -62, 10},
       {-43, 41, -76, 6}},
      {{43, 71, 106, 11},
       {20, 70, 78, 16},
       {-18, 68, 24, 19},
       {-44, 60, -32, 18},
       {-47, 48, -72, 10},
       {-42, 41, -85, 6}},
      {{53, 80, 88, 12}, {28, 77, 58, 18}, {-10, 75, 8, 21}, {-41, 62, -45, 18}, {-46, 48, -82, 10}, {-42, 41, -94, 6}},
      {{64, 87, 68, 12},
       {38, 83, 36, 19},
       {-2, 79, -10, 21},
       {-37, 63, -58, 17},
       {-44, 47, -92, 9},
       {-41, 41, -103, 6}},
      {{74, 90, 47, 12},
       {48, 86, 14, 18},
       {8, 81, -27, 20},
       {-32, 63, -72, 16},
       {-43, 46, -102, 8},
       {-40, 40, -112, 5.5}},
      {{82, 90, 26, 11},
       {60, 86, -6, 16},
       {18, 79, -44, 18},
       {-27, 62, -86, 14},
       {-41, 45, -112, 7},
       {-39, 39, -121, 5}}};
}

/// From the outer face of the wing to the greater trochanter.
Bundles gluteus_medius_bundles() {
  return {{{-27, -45, 84, 8}, {-28, -34, 66, 13}, {-43, -10, 30, 13}, {-61, 14, 4, 7}, {-58, 16, -8, 5}},
          {{-25, -34, 108, 8}, {-28, -24, 82, 13}, {-42, -3, 38, 13}, {-60, 18, 5, 7}, {-57, 20, -7, 5}},
          {{-20, -17, 124, 8}, {-25, -12, 92, 13}, {-40, 6, 44, 13}, {-59, 23, 6, 7}, {-56, 25, -6, 5}},
          {{-13, 2, 132, 8}, {-19, 4, 97, 13}, {-36, 15, 47, 13}, {-58, 27, 6, 7}, {-55, 29, -6, 5}},
          {{-2, 21, 134, 8}, {-10, 20, 97, 13}, {-32, 26, 47, 13}, {-57, 32, 7, 7}, {-54, 34, -5, 5}},
          {{11, 39, 128, 8}, {1, 36, 92, 13}, {-25, 36, 45, 13}, {-56, 36, 8, 7}, {-53, 38, -4, 5}}};
}

/// From the fossa over the pelvic brim and the femoral head to the lesser trochanter.
Bundles iliacus_bundles() {
  return {{{-18, -48, 94, 6.2},
           {-16, -46, 80, 6.2},
           {-11, -45, 62, 6.2},
           {-5, -46, 38, 6.5},
           {-6, -36, 6, 6.8},
           {-10, -16, -26, 5.4},
           {-13, 12, -47, 4.6},
           {-12, 23, -54, 4}},
          {{-16, -36, 112, 6.2},
           {-14, -37, 92, 6.2},
           {-11, -37, 68, 6.2},
           {-2, -43, 38, 6.5},
           {-3, -36, 6, 6.8},
           {-10, -16, -26, 5.4},
           {-12, 12, -47, 4.6},
           {-12, 23, -55, 4}},
          {{-11, -19, 124, 6.2},
           {-10, -22, 98, 6.2},
           {-8, -26, 70, 6.2},
           {1, -41, 38, 6.5},
           {-1, -35, 6, 6.8},
           {-8, -15, -26, 5.4},
           {-12, 12, -48, 4.6},
           {-11, 23, -55, 4}},
          {{-4, -2, 131, 6.2},
           {-4, -8, 101, 6.2},
           {-4, -15, 71, 6.2},
           {3, -38, 38, 6.5},
           {2, -35, 6, 6.8},
           {-8, -15, -26, 5.4},
           {-11, 13, -48, 4.6},
           {-11, 24, -56, 4}},
          {{5, 14, 132, 6.2},
           {3, 6, 101, 6.2},
           {0, -5, 70, 6.2},
           {6, -36, 38, 6.5},
           {4, -34, 6, 6.8},
           {-6, -14, -26, 5.4},
           {-11, 13, -49, 4.6},
           {-10, 24, -56, 4}},
          {{14, 27, 126, 6.2},
           {11, 18, 97, 6.2},
           {6, 4, 67, 6.2},
           {9, -34, 38, 6.5},
           {7, -34, 6, 6.8},
           {-6, -14, -26, 5.4},
           {-10, 13, -49, 4.6},
           {-10, 24, -57, 4}}};
}

MuscleShape shape(const Bundles& bundles, double blend_m, int vertices) {
  MuscleShape result;
  result.vertices = vertices;
  result.lower_m = Vec3::Constant(1e3);
  result.upper_m = Vec3::Constant(-1e3);
  for (const std::vector<Station>& stations : bundles) {
    for (const Station& s : stations) {
      // Beyond the tubes for the blend between them and for the overshoot of the curves.
      const Vec3 reach = Vec3::Constant(1e-3 * s.radius_mm + 0.012);
      const Vec3 centre = 1e-3 * Vec3(s.x_mm, s.y_mm, s.z_mm);
      result.lower_m = result.lower_m.cwiseMin(centre - reach);
      result.upper_m = result.upper_m.cwiseMax(centre + reach);
    }
  }
  result.field = [fibres = StrandBundle(bundles, blend_m), hip = hip_bone_field(),
                  femur = femur_field()](const Vec3& point) {
    constexpr double rim_m = 0.004;
    const double flesh = fibres.distance(point);
    if (flesh > 0.02) {
      return flesh;  // far outside, where the bones no longer matter
    }
    return smooth_max(smooth_max(flesh, hip_clearance_m - hip(point), rim_m), femur_clearance_m - femur(point), rim_m);
  };
  return result;
}

}  // namespace

MuscleShape muscle_shape(std::string_view name) {
  if (name == "adductor_brevis") {
    return shape(adductor_brevis_bundles(), 0.010, 502);
  }
  if (name == "gluteus_maximus") {
    return shape(gluteus_maximus_bundles(), 0.016, 9878);
  }
  if (name == "gluteus_medius") {
    return shape(gluteus_medius_bundles(), 0.016, 5313);
  }
  assert(name == "iliacus");
  return shape(iliacus_bundles(), 0.012, 6931);
}

}  // namespace musclebench

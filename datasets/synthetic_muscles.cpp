#include "datasets/synthetic_muscles.hpp"

#include <cassert>
#include <utility>

#include "datasets/synthetic_bones.hpp"

namespace musclebench {

namespace {

using Bundles = std::vector<std::vector<Station>>;

constexpr double hip_clearance_m = 0.0006;
constexpr double femur_clearance_m = 0.0010;

/// From the pubic body to the inner side of the upper shaft.
Bundles adductor_brevis_bundles() {
  return {{{76, -38, -36, 6}, {50, -17, -54, 9}, {18, 8, -70, 10}, {-10, 21, -78, 7}, {-20, 25, -80, 5}},
          {{70, -20, -48, 6}, {46, -6, -64, 9}, {16, 14, -80, 9}, {-12, 25, -90, 6.5}, {-21, 27, -94, 4.5}}};
}

/// From the back of the ilium and the sacrum to the gluteal tuberosity.
Bundles gluteus_maximus_bundles() {
  return {
      {{36, 64, 112, 12}, {4, 62, 86, 17}, {-30, 60, 30, 19}, {-48, 56, -30, 17}, {-46, 46, -70, 9}, {-42, 41, -84, 6}},
      {{50, 78, 88, 13}, {22, 76, 58, 19}, {-16, 74, 8, 22}, {-42, 62, -46, 18}, {-44, 46, -86, 9}, {-41, 41, -96, 6}},
      {{68, 88, 58, 13},
       {40, 86, 28, 20},
       {0, 82, -18, 23},
       {-34, 64, -66, 17},
       {-42, 46, -102, 8},
       {-39, 40, -110, 6}},
      {{80, 92, 28, 12},
       {56, 88, -4, 19},
       {14, 82, -44, 21},
       {-26, 64, -88, 15},
       {-39, 44, -116, 7},
       {-38, 38, -124, 5}}};
}

/// From the outer face of the wing to the greater trochanter.
Bundles gluteus_medius_bundles() {
  return {{{-34, -42, 78, 9}, {-46, -26, 56, 12}, {-56, -2, 28, 11}, {-62, 14, 2, 7}, {-61, 20, -10, 5}},
          {{-38, -26, 104, 9}, {-46, -12, 70, 14}, {-56, 6, 34, 13}, {-63, 20, 4, 7}, {-62, 24, -8, 5}},
          {{-24, 0, 124, 9}, {-36, 6, 84, 15}, {-54, 18, 40, 14}, {-62, 27, 6, 7}, {-60, 29, -6, 5}},
          {{-6, 26, 130, 9}, {-24, 26, 92, 15}, {-48, 30, 44, 13}, {-60, 33, 10, 7}, {-58, 33, -2, 5}},
          {{12, 46, 122, 8}, {-10, 42, 88, 13}, {-40, 40, 46, 12}, {-56, 38, 14, 6.5}, {-54, 37, 4, 5}}};
}

/// From the fossa over the pelvic brim and the femoral head to the lesser trochanter.
Bundles iliacus_bundles() {
  return {{{-24, -40, 96, 7},
           {-14, -46, 66, 8},
           {-8, -45, 36, 9},
           {-4, -36, 4, 9},
           {-9, -16, -26, 8},
           {-13, 12, -46, 7},
           {-12, 24, -54, 5}},
          {{-22, -22, 120, 7},
           {-8, -30, 84, 9},
           {0, -38, 42, 10},
           {0, -36, 4, 10},
           {-7, -14, -28, 8},
           {-11, 13, -48, 6},
           {-11, 24, -56, 4.5}},
          {{-6, -2, 130, 7},
           {4, -16, 92, 9},
           {8, -31, 46, 10},
           {5, -35, 4, 9},
           {-5, -14, -30, 7},
           {-10, 13, -50, 6},
           {-10, 24, -57, 4.5}},
          {{12, 14, 126, 7},
           {17, -4, 92, 9},
           {15, -24, 48, 9},
           {9, -34, 6, 8},
           {-4, -13, -31, 7},
           {-9, 14, -50, 6},
           {-9, 24, -57, 4.5}}};
}

MuscleShape shape(const Bundles& bundles, double blend_m, int vertices) {
  MuscleShape result;
  result.vertices = vertices;
  result.lower_m = Vec3::Constant(1e3);
  result.upper_m = Vec3::Constant(-1e3);
  std::vector<Strand> strands;
  for (const std::vector<Station>& stations : bundles) {
    strands.emplace_back(stations);
    for (const Station& s : stations) {
      // Beyond the tubes for the blend between them and for the overshoot of the curves.
      const Vec3 reach = Vec3::Constant(1e-3 * s.radius_mm + 0.012);
      const Vec3 centre = 1e-3 * Vec3(s.x_mm, s.y_mm, s.z_mm);
      result.lower_m = result.lower_m.cwiseMin(centre - reach);
      result.upper_m = result.upper_m.cwiseMax(centre + reach);
    }
  }
  result.field = [fibres = StrandBundle(std::move(strands), blend_m), hip = hip_bone_field(),
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
    return shape(adductor_brevis_bundles(), 0.012, 502);
  }
  if (name == "gluteus_maximus") {
    return shape(gluteus_maximus_bundles(), 0.016, 9878);
  }
  if (name == "gluteus_medius") {
    return shape(gluteus_medius_bundles(), 0.014, 5313);
  }
  assert(name == "iliacus");
  return shape(iliacus_bundles(), 0.012, 6931);
}

}  // namespace musclebench

#include "datasets/synthetic_bones.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace musclebench {

namespace {

// ---------------------------------------------------------------- iliac wing

/// Along the blade (front negative) and up.
struct OutlinePoint {
  double u_mm;
  double z_mm;
};

/// Crest, spines and the greater sciatic notch, counter-clockwise seen from inside the pelvis.
constexpr std::array<OutlinePoint, 21> wing_outline = {
    {{-30, 32},  {0, 28},    {24, 36},   {36, 50},  {52, 56},  {66, 60},  {80, 70},
     {88, 84},   {89, 98},   {80, 114},  {66, 130}, {48, 141}, {28, 146}, {6, 144},
     {-18, 136}, {-40, 122}, {-55, 105}, {-62, 90}, {-62, 77}, {-53, 66}, {-48, 50}}};

constexpr double wing_rounding_m = 0.004;

/// Signed distance to the outline in its own plane.
double outline_distance(double u_m, double z_m) {
  double squared = 1e6;
  bool inside = false;
  for (std::size_t i = 0; i < wing_outline.size(); ++i) {
    const OutlinePoint& a = wing_outline[i];
    const OutlinePoint& b = wing_outline[(i + 1) % wing_outline.size()];
    const double du = 1e-3 * (b.u_mm - a.u_mm);
    const double dz = 1e-3 * (b.z_mm - a.z_mm);
    const double pu = u_m - 1e-3 * a.u_mm;
    const double pz = z_m - 1e-3 * a.z_mm;
    const double t = std::clamp((pu * du + pz * dz) / (du * du + dz * dz), 0.0, 1.0);
    squared = std::min(squared, (pu - t * du) * (pu - t * du) + (pz - t * dz) * (pz - t * dz));
    if ((a.z_mm > 1e3 * z_m) != (b.z_mm > 1e3 * z_m) && pu < du / dz * pz) {
      inside = !inside;
    }
  }
  return inside ? -std::sqrt(squared) : std::sqrt(squared);
}

double smooth_step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// A blade bent around the vertical, hollow on the inner side (the iliac fossa), with a thick crest.
double wing_distance(const Vec3& point) {
  const double u = 0.586 * point.x() + 0.810 * point.y();
  const double n = 0.810 * point.x() - 0.586 * point.y();
  const double offset = u - 0.022;
  const double bend = offset < 0 ? 3.4 : 1.2;
  const double slope = 2.0 * bend * offset;
  const double sheet = (n + 0.0085 - bend * offset * offset) / std::sqrt(1.0 + slope * slope);
  const double within = outline_distance(u, point.z());
  const double half_thickness = 0.0026 + 0.0026 * smooth_step(-0.016, -0.004, within);
  const double across = std::abs(sheet) - half_thickness + wing_rounding_m;
  const double along = within + wing_rounding_m;
  const double outside_across = std::max(across, 0.0);
  const double outside_along = std::max(along, 0.0);
  return std::min(std::max(across, along), 0.0) +
         std::sqrt(outside_across * outside_across + outside_along * outside_along) - wing_rounding_m;
}

// ---------------------------------------------------------------- the other parts of the hip bone

StrandBundle hip_bone_strands() {
  static constexpr std::array<Station, 1 + 1> socket_wall = {{{0.5, 0, 0, 32.5}, {2.5, 1, 3, 32.5}}};
  static constexpr std::array<Station, 4> roof = {
      {{3, -4, 26, 15}, {2, -6, 42, 13}, {0, -8, 62, 7}, {-3, -10, 84, 3.5}}};
  static constexpr std::array<Station, 5> rear_column = {
      {{18, 14, 16, 14}, {21, 21, 34, 11.5}, {27, 31, 52, 9}, {36, 44, 68, 7}, {46, 58, 84, 7}}};
  static constexpr std::array<Station, 4> front_spine = {
      {{-4, -26, 24, 9}, {-7, -37, 36, 7}, {-11, -44, 47, 6}, {-17, -46, 62, 4}}};
  static constexpr std::array<Station, 5> upper_ramus = {
      {{17, -18, 12, 11}, {32, -30, 6, 8}, {50, -39, -6, 6.5}, {68, -45, -16, 6.5}, {83, -46, -23, 7.5}}};
  static constexpr std::array<Station, 3> pubic_body = {{{84, -46, -22, 7.5}, {86, -41, -30, 7}, {84, -34, -39, 6}}};
  static constexpr std::array<Station, 5> ischium = {
      {{14, 26, 6, 13}, {16, 38, -8, 13}, {17, 46, -24, 13.5}, {22, 45, -39, 12}, {33, 36, -50, 7.5}}};
  static constexpr std::array<Station, 4> lower_ramus = {
      {{33, 36, -50, 7.5}, {46, 19, -54, 5.5}, {64, -4, -49, 5}, {84, -34, -39, 6}}};
  static constexpr std::array<Station, 3> ischial_spine = {{{26, 40, 8, 7}, {32, 47, 9, 4.5}, {38, 52, 9, 2}}};
  return {{Strand(socket_wall), Strand(roof), Strand(rear_column), Strand(front_spine), Strand(upper_ramus),
           Strand(pubic_body), Strand(ischium), Strand(lower_ramus), Strand(ischial_spine)},
          0.010};
}

StrandBundle sacrum_strands() {
  static constexpr std::array<Station, 6> column = {
      {{97, 22, 116, 15}, {97, 46, 96, 15}, {97, 70, 66, 12}, {97, 82, 34, 9}, {97, 78, 2, 6}, {97, 66, -18, 4}}};
  static constexpr std::array<Station, 3> upper_wing = {{{58, 52, 94, 12}, {74, 42, 102, 13}, {97, 36, 106, 14}}};
  static constexpr std::array<Station, 3> middle_wing = {{{63, 66, 76, 10}, {78, 64, 78, 11}, {97, 62, 80, 12}}};
  static constexpr std::array<Station, 4> side_ridge = {
      {{66, 68, 72, 9}, {71, 78, 50, 8}, {78, 83, 30, 7}, {90, 82, 12, 6}}};
  static constexpr std::array<Station, 4> spinous_ridge = {
      {{97, 64, 108, 7}, {97, 82, 84, 7}, {97, 94, 56, 6}, {97, 93, 30, 5}}};
  return {{Strand(column), Strand(upper_wing), Strand(middle_wing), Strand(side_ridge), Strand(spinous_ridge)}, 0.012};
}

/// What is cut away around the femur: the socket's ball, and the wide cone below it in which the neck moves.
double socket_opening(const Vec3& point) {
  static const Vec3 axis = Vec3(-0.80, -0.10, -0.59).normalized();
  const double ball = point.norm() - socket_radius_m;
  const double rim = 0.003 - point.dot(axis);
  const double sweep = point.norm() - 0.040;
  return std::min(ball, smooth_max(rim, sweep, 0.006));
}

/// The sacrum is halved in the midline.
constexpr double midline_m = 0.1010;

// ---------------------------------------------------------------- femur

StrandBundle femur_strands() {
  static constexpr std::array<Station, 3> neck = {{{-6, 2, -4, 16.5}, {-22, 9, -13, 14.5}, {-38, 17, -24, 17}}};
  static constexpr std::array<Station, 4> greater_trochanter = {
      {{-46, 22, -34, 15}, {-50, 25, -18, 14}, {-51, 28, -4, 10}, {-46, 33, 6, 6.5}}};
  static constexpr std::array<Station, 3> crest = {{{-47, 36, 0, 6}, {-36, 37, -20, 6}, {-18, 32, -44, 6}}};
  static constexpr std::array<Station, 3> lesser_trochanter = {
      {{-26, 24, -52, 11}, {-17, 28, -49, 9}, {-12, 30, -46, 6}}};
  static constexpr std::array<Station, 8> shaft = {{{-37, 20, -36, 19},
                                                    {-35, 23, -62, 16.5},
                                                    {-34, 22, -95, 14.5},
                                                    {-33, 16.5, -180, 13.7},
                                                    {-29, 14, -260, 14.3},
                                                    {-26, 18, -330, 17},
                                                    {-23, 22, -370, 20},
                                                    {-20, 26, -392, 20}}};
  static constexpr std::array<Station, 4> rough_line = {
      {{-36, 37, -55, 5}, {-36, 36, -110, 4}, {-33, 30, -190, 3}, {-29, 28, -270, 3}}};
  static constexpr std::array<Station, 4> inner_condyle = {
      {{-12, 20, -372, 15}, {-2, 24, -394, 17}, {2, 38, -402, 18}, {2, 50, -396, 15}}};
  static constexpr std::array<Station, 4> outer_condyle = {
      {{-32, 20, -370, 16}, {-40, 22, -392, 17}, {-42, 38, -400, 18}, {-40, 50, -394, 15}}};
  return {{Strand(neck), Strand(greater_trochanter), Strand(crest), Strand(lesser_trochanter), Strand(shaft),
           Strand(rough_line), Strand(inner_condyle), Strand(outer_condyle)},
          0.008};
}

}  // namespace

Field hip_bone_field() {
  return [hip = hip_bone_strands(), sacrum = sacrum_strands()](const Vec3& point) {
    const double bone = hip.distance(point, wing_distance(point));
    const double half_sacrum = smooth_max(sacrum.distance(point), point.x() - midline_m, 0.003);
    return smooth_max(smooth_min(bone, half_sacrum, 0.006), -socket_opening(point), 0.004);
  };
}

Field femur_field() {
  return [strands = femur_strands()](const Vec3& point) {
    return smooth_min(strands.distance(point), point.norm() - femoral_head_radius_m, 0.004);
  };
}

}  // namespace musclebench

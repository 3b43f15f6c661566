#include "datasets/synthetic/synthetic_bones.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace musclebench {

namespace {

double smooth_step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// ---------------------------------------------------------------- iliac wing

/// Along the blade (front negative) and up.
struct OutlinePoint {
  double u_mm;
  double z_mm;
};

/// Crest, spines and the greater sciatic notch, counter-clockwise seen from inside the pelvis.
constexpr std::array<OutlinePoint, 20> wing_outline = {
    {{-30, 30}, {0, 26},   {24, 34},  {38, 47}, {54, 54},   {70, 60},   {84, 72},   {89, 88},  {86, 104}, {77, 119},
     {62, 132}, {44, 141}, {24, 145}, {4, 143}, {-18, 136}, {-39, 122}, {-54, 105}, {-62, 88}, {-58, 70}, {-47, 46}}};

// A box around the smoothed outline.
constexpr double outline_min_u_m = -0.065;
constexpr double outline_max_u_m = 0.092;
constexpr double outline_min_z_m = 0.023;
constexpr double outline_max_z_m = 0.148;

constexpr double wing_rounding_m = 0.0045;
constexpr double blade_half_thickness_m = 0.0027;
constexpr double crest_half_thickness_m = 0.0055;

struct PlanePoint {
  double u_m;
  double z_m;
};

/// A Catmull-Rom curve through the outline, as a polygon.
std::vector<PlanePoint> smooth_outline() {
  constexpr std::size_t pieces = 4;
  constexpr std::size_t count = wing_outline.size();
  std::vector<PlanePoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const OutlinePoint& a = wing_outline[(i + count - 1) % count];
    const OutlinePoint& b = wing_outline[i];
    const OutlinePoint& c = wing_outline[(i + 1) % count];
    const OutlinePoint& d = wing_outline[(i + 2) % count];
    for (std::size_t piece = 0; piece < pieces; ++piece) {
      const double t = static_cast<double>(piece) / pieces;
      const auto blend = [t](double p, double q, double r, double s) {
        return 0.5 * (2.0 * q + t * (r - p) + t * t * (2.0 * p - 5.0 * q + 4.0 * r - s) +
                      t * t * t * (3.0 * (q - r) + s - p));
      };
      points.push_back({1e-3 * blend(a.u_mm, b.u_mm, c.u_mm, d.u_mm), 1e-3 * blend(a.z_mm, b.z_mm, c.z_mm, d.z_mm)});
    }
  }
  return points;
}

/// Signed distance to the outline in its own plane.
double outline_distance(const std::vector<PlanePoint>& outline, double u_m, double z_m) {
  double squared = 1e6;
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const PlanePoint& a = outline[i];
    const PlanePoint& b = outline[i + 1 < outline.size() ? i + 1 : 0];
    const double du = b.u_m - a.u_m;
    const double dz = b.z_m - a.z_m;
    const double pu = u_m - a.u_m;
    const double pz = z_m - a.z_m;
    const double t = std::clamp((pu * du + pz * dz) / (du * du + dz * dz), 0.0, 1.0);
    squared = std::min(squared, (pu - t * du) * (pu - t * du) + (pz - t * dz) * (pz - t * dz));
    if ((a.z_m > z_m) != (b.z_m > z_m) && pu < du / dz * pz) {
      inside = !inside;
    }
  }
  return inside ? -std::sqrt(squared) : std::sqrt(squared);
}

/// A blade bent around the vertical, hollow on the inner side (the iliac fossa), with a thick crest. Towards the hip
/// joint it leans inwards.
double wing_distance(const std::vector<PlanePoint>& outline, const Vec3& point) {
  constexpr double far_m = 0.025;
  const double u = 0.586 * point.x() + 0.810 * point.y();
  const double n = 0.810 * point.x() - 0.586 * point.y();
  const double offset = u - 0.022;
  const double bend = offset < 0 ? 3.4 : 1.2;
  const double slope = 2.0 * bend * offset;
  const double lean = 0.008 * (1.0 - smooth_step(0.036, 0.084, point.z()));
  const double sheet = (n + 0.0085 - lean - bend * offset * offset) / std::sqrt(1.06 + slope * slope);
  const double beyond_box = std::max({std::abs(sheet) - crest_half_thickness_m, u - outline_max_u_m,
                                      outline_min_u_m - u, point.z() - outline_max_z_m, outline_min_z_m - point.z()});
  if (beyond_box > far_m) {
    return beyond_box;
  }
  const double within = outline_distance(outline, u, point.z());
  const double half_thickness =
      blade_half_thickness_m + (crest_half_thickness_m - blade_half_thickness_m) * smooth_step(-0.018, -0.004, within);
  const double across = std::abs(sheet) - half_thickness + wing_rounding_m;
  const double along = within + wing_rounding_m;
  const double outside_across = std::max(across, 0.0);
  const double outside_along = std::max(along, 0.0);
  return std::min(std::max(across, along), 0.0) +
         std::sqrt(outside_across * outside_across + outside_along * outside_along) - wing_rounding_m;
}

// ---------------------------------------------------------------- the other parts of the hip bone

StrandBundle hip_bone_strands() {
  const std::vector<std::vector<Station>> ridges = {
      {{0.5, 0, 0, 32.5}, {2.5, 1, 3, 32.5}},                                                       // socket wall
      {{4, -4, 26, 15}, {2, -1, 42, 13.5}, {-2, 2, 56, 8}, {-5, 3.5, 70, 2.5}},                     // its roof
      {{18, 14, 16, 14}, {21, 22, 34, 11.5}, {25, 33, 52, 9}, {35, 49, 68, 7.5}, {46, 64, 84, 7}},  // rear column
      {{-1, -26, 22, 10},
       {-5, -36, 34, 8.5},
       {-10, -42, 46, 7.5},
       {-17, -45, 58, 5},
       {-22, -48, 70, 4}},                                                                               // front spine
      {{17, -18, 12, 12}, {32, -30, 6, 9}, {50, -39, -6, 7.5}, {68, -45, -16, 7.5}, {83, -46, -23, 8}},  // upper ramus
      {{84, -46, -22, 8}, {86, -41, -30, 7.5}, {84, -34, -39, 6.5}},                                     // pubic body
      {{14, 26, 6, 14}, {16, 38, -8, 14}, {17, 45, -24, 14.5}, {22, 44, -39, 13}, {33, 35, -50, 8}},     // ischium
      {{33, 35, -50, 8}, {46, 19, -54, 6}, {64, -4, -49, 5.5}, {84, -34, -39, 6.5}},                     // lower ramus
      {{24, 38, 8, 8}, {31, 46, 9, 5}, {37, 51, 9, 2}}};  // ischial spine
  return {ridges, 0.010};
}

StrandBundle sacrum_strands() {
  const std::vector<std::vector<Station>> ridges = {
      {{97, 22, 116, 15}, {97, 46, 96, 15}, {97, 70, 66, 12}, {97, 82, 34, 9}, {97, 78, 2, 6}, {97, 66, -18, 4}},
      {{56, 54, 94, 13}, {74, 43, 102, 14}, {97, 36, 106, 14}},                // upper wing
      {{60, 66, 74, 11}, {78, 64, 78, 12}, {97, 62, 80, 12}},                  // middle wing
      {{66, 68, 72, 9}, {71, 78, 50, 8.5}, {78, 83, 30, 7}, {90, 82, 12, 6}},  // side
      {{84, 66, 74, 10}, {84, 77, 52, 9}, {88, 82, 28, 7}},                    // plate between side and middle
      {{97, 64, 108, 7}, {97, 82, 84, 7}, {97, 94, 56, 6}, {97, 93, 30, 5}}};  // spinous ridge
  return {ridges, 0.012};
}

/// What is cut away around the femur: the socket's ball, and the wide cone below it in which the neck moves.
double socket_opening(const Vec3& point) {
  static const Vec3 axis = Vec3(-0.80, -0.10, -0.59).normalized();
  const double ball = point.norm() - socket_radius_m;
  const double rim = 0.003 - point.dot(axis);
  const double sweep = point.norm() - 0.040;
  return smooth_min(ball, smooth_max(rim, sweep, 0.006), 0.003);
}

/// The sacrum is halved in the midline.
constexpr double midline_m = 0.1010;

// ---------------------------------------------------------------- femur

StrandBundle femur_strands() {
  const std::vector<std::vector<Station>> ridges = {
      {{-6, 2, -4, 16.5}, {-22, 9, -13, 14.5}, {-38, 17, -24, 17}},                        // neck
      {{-45, 22, -36, 16}, {-50, 25, -19, 14.5}, {-51, 29, -3, 10.5}, {-46, 34, 6, 6.5}},  // greater trochanter
      {{-48, 34, -4, 7}, {-38, 34, -22, 6}, {-20, 31, -44, 6}},                            // crest between the two
      {{-26, 24, -52, 11}, {-17, 28, -49, 9}, {-12, 30, -46, 6}},                          // lesser trochanter
      {{-37, 20, -36, 19},
       {-35, 23, -62, 16.5},
       {-34, 22, -95, 14.5},
       {-33, 16.5, -180, 13.7},
       {-29, 14, -260, 14.3},
       {-26, 18, -330, 17},
       {-23, 22, -370, 20},
       {-20, 26, -392, 20}},  // shaft
      {{-36, 37, -55, 5},
       {-36, 36, -110, 4},
       {-33, 30, -190, 3},
       {-29, 26, -265, 2.5},
       {-28, 22, -285, 2}},                                                                   // rough line
      {{-12, 20, -372, 15}, {-2, 24, -394, 17}, {2, 38, -402, 18}, {2, 50, -396, 15}},        // inner condyle
      {{-32, 20, -370, 16}, {-40, 22, -392, 17}, {-42, 38, -400, 18}, {-40, 50, -394, 15}}};  // outer condyle
  return {ridges, 0.008};
}

}  // namespace

Field hip_bone_field() {
  return [outline = smooth_outline(), hip = hip_bone_strands(), sacrum = sacrum_strands()](const Vec3& point) {
    const double bone = hip.distance(point, wing_distance(outline, point));
    const double half_sacrum = smooth_max(sacrum.distance(point), point.x() - midline_m, 0.003);
    return smooth_max(smooth_min(bone, half_sacrum, 0.006), -socket_opening(point), 0.005);
  };
}

Field femur_field() {
  return [strands = femur_strands()](const Vec3& point) {
    return smooth_min(strands.distance(point), point.norm() - femoral_head_radius_m, 0.004);
  };
}

}  // namespace musclebench

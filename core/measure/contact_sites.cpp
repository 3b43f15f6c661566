#include "core/measure/contact_sites.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/portable_math.hpp"

namespace musclebench {

namespace {

// Lengths over the bone's diagonal: for a hip bone of 0.3 m, 1.5 mm and 3 mm.
constexpr double thin_half_thickness = 0.005;
constexpr double curvature_reach = 0.01;
/// Mean distance of a circle of radius r in the tangent plane from the surface, over r: r / 2R on a sphere of radius R.
constexpr double curved = 0.15;
constexpr int circle_points = 8;

/// Whether the opposite face is nearer than twice `half_m`. A ridge near the site is not: its faces do not oppose each
/// other.
bool is_thin(const Referee& referee, const ContactSite& site, double half_m) {
  constexpr double widening = 1.5;  // below 2, so that a plate is not left through its other face
  for (double depth_m = 1e-3 * half_m; depth_m < half_m; depth_m *= widening) {
    const Vec3 inside = site.surface_point_m - depth_m * site.outward;
    const SurfaceDistance truth = referee.closest(site.bone, inside);
    if (truth.signed_distance_m > -0.99 * depth_m) return truth.normal.dot(site.outward) < -0.5;
  }
  return false;
}

double mean_height(const Referee& referee, const ContactSite& site, double radius_m) {
  const Vec3 along = site.outward.unitOrthogonal();
  const Vec3 across = site.outward.cross(along);
  double sum_m = 0;
  for (int i = 0; i < circle_points; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / circle_points;
    const Vec3 offset = portable::cos(angle_rad) * along + portable::sin(angle_rad) * across;
    sum_m += referee.signed_distance(site.bone, site.surface_point_m + radius_m * offset);
  }
  return sum_m / (circle_points * radius_m);
}

ContactDifficulty shape_at(const Referee& referee, const ContactSite& site, double diagonal_m) {
  if (is_thin(referee, site, thin_half_thickness * diagonal_m)) return ContactDifficulty::thin;
  const double height = mean_height(referee, site, curvature_reach * diagonal_m);
  if (height > curved) return ContactDifficulty::ridge;
  return height < -curved ? ContactDifficulty::concave : ContactDifficulty::flat;
}

/// By node, whether it shares a triangle with one that is not free.
std::vector<char> attached_borders(const TriangleMesh& muscle, std::span<const int> free_nodes) {
  std::vector<char> is_attached(muscle.vertices.size(), 1);
  for (const int node : free_nodes) is_attached[static_cast<std::size_t>(node)] = 0;
  std::vector<char> borders(muscle.vertices.size(), 0);
  for (const Triangle& triangle : muscle.triangles) {
    const bool touches =
        std::ranges::any_of(triangle, [&](int node) { return is_attached[static_cast<std::size_t>(node)] != 0; });
    for (const int node : triangle) borders[static_cast<std::size_t>(node)] |= static_cast<char>(touches);
  }
  return borders;
}

}  // namespace

ContactSiteSampler::ContactSiteSampler(std::size_t bones, std::vector<Body> muscles)
    : m_muscles(std::move(muscles)), m_pairs(bones * m_muscles.size()) {}

void ContactSiteSampler::add(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions,
                             std::span<const Contact> truth) {
  for (const Contact& contact : truth) {
    const auto bone = static_cast<std::size_t>(contact.bone);
    const std::size_t muscle = body_of(m_muscles, contact.node);
    Pair& pair = m_pairs[bone * m_muscles.size() + muscle];
    if (pair.seen++ % pair.stride != 0) continue;
    const RigidMotion& pose = bone_poses[bone];
    const Vec3 surface = positions[static_cast<std::size_t>(contact.node)] + contact.depth_m * contact.normal;
    pair.sites.push_back({.bone = contact.bone,
                          .muscle = static_cast<int>(muscle),
                          .node = contact.node,
                          .surface_point_m = pose.apply_inverse(surface),
                          .outward = pose.rotation.transpose() * contact.normal});
    if (pair.sites.size() <= sites_a_pair) continue;
    // Thinned out: every second one of those that were kept.
    for (std::size_t i = 0; 2 * i < pair.sites.size(); ++i) pair.sites[i] = pair.sites[2 * i];
    pair.sites.resize((pair.sites.size() + 1) / 2);
    pair.stride *= 2;
  }
}

std::vector<ContactSite> ContactSiteSampler::sites() const {
  std::vector<ContactSite> all;
  for (const Pair& pair : m_pairs) {
    for (const ContactSite& site : pair.sites) all.emplace_back(site).contacts = pair.stride;
  }
  return all;
}

void classify_sites(const Referee& referee, std::span<const double> bone_diagonals_m, const TriangleMesh& muscle,
                    std::span<const int> free_nodes, std::vector<ContactSite>& sites) {
  const std::vector<char> borders = attached_borders(muscle, free_nodes);
  for (ContactSite& site : sites) {
    site.difficulty = borders[static_cast<std::size_t>(site.node)] != 0
                          ? ContactDifficulty::attached_border
                          : shape_at(referee, site, bone_diagonals_m[static_cast<std::size_t>(site.bone)]);
  }
}

}  // namespace musclebench

#include "core/effects/surface_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>

#include "core/clearance/clearance_cache.hpp"
#include "core/distance/triangle_distance.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

/// A triangle may grow by this factor before its clearance is too small for it.
constexpr double allowed_growth = 1.25;
/// Queries of a search for the deepest point, at most; each halves the step or goes deeper.
constexpr int most_queries = 10;
/// Below this share of the triangle's radius a step changes nothing that counts.
constexpr double least_step = 1e-3;
/// Points of a triangle whose barycentric coordinates differ by less are one.
constexpr double least_apart = 0.15;
/// Clearance of a triangle that no contact is sought for.
constexpr double anywhere_m = 1e6;

/// A point of a muscle's triangle near a bone, and the bone's tangent plane there, in the bone's rest frame.
struct FaceContact {
  std::size_t triangle;
  std::size_t bone;
  Vec3 weights;  ///< barycentric
  Vec3 point;    ///< of the plane
  Vec3 normal;   ///< unit, out of the bone
};

struct DeepestPoint {
  Vec3 at;
  Vec3 weights;
  SignedPoint located;
};

Vec3 barycentric(const Vec3& point, const std::array<Vec3, 3>& corners) {
  const Vec3 ab = corners[1] - corners[0];
  const Vec3 ac = corners[2] - corners[0];
  const Vec3 normal = ab.cross(ac);
  const double squared = normal.squaredNorm();
  if (!(squared > 0)) return Vec3::Constant(1.0 / 3);
  const Vec3 arm = point - corners[0];
  const double v = std::clamp(normal.dot(arm.cross(ac)) / squared, 0.0, 1.0);
  const double w = std::clamp(normal.dot(ab.cross(arm)) / squared, 0.0, 1.0 - v);
  return {1 - v - w, v, w};
}

class SurfaceContact final : public ContactStage {
 public:
  SurfaceContact(const StageInput& input, int interval, double skin_m, int steps)
      : m_triangles(input.triangles),
        m_inverse_masses(input.inverse_masses.begin(), input.inverse_masses.end()),
        m_interval(interval),
        m_skin_m(skin_m),
        m_steps(steps),
        m_carriers(input.nodes, -1),
        m_centres(input.triangles.size()),
        m_reaches_m(input.triangles.size(), 0),
        m_loads(input.nodes, 0),
        m_corrections(input.nodes, Vec3::Zero()),
        m_start_corrections(input.nodes, Vec3::Zero()) {
    for (const BoundNode& bound : input.bound_nodes) m_carriers[static_cast<std::size_t>(bound.node)] = bound.bone;
    for (std::size_t t = 0; t < m_triangles.size(); ++t) {
      if (has_free_node(t)) m_searched.push_back(static_cast<int>(t));
    }
    m_clearances.reset(input.bones, m_triangles.size());
    for (const Bone& bone : input.bones) {
      m_bones.push_back({bone.kept_signed_distance(), std::vector<int>(m_triangles.size(), 0)});
    }
  }

  [[nodiscard]] std::string_view name() const override { return "surface_contact"; }

  std::span<const int> after_bones(const ContactStageInput& input) override {
    if (m_calls++ % m_interval == 0) find_contacts(input);
    resolve(input);
    return m_moved;
  }

  [[nodiscard]] int contact_count() const override { return m_acted; }

 private:
  struct BoneSurface {
    std::shared_ptr<const SignedSurface> surface;
    std::vector<int> near_triangles;  ///< of the bone, by the muscle's triangle
  };

  [[nodiscard]] bool has_free_node(std::size_t triangle) const {
    return std::ranges::any_of(m_triangles[triangle],
                               [&](int node) { return m_inverse_masses[static_cast<std::size_t>(node)] > 0; });
  }

  /// What is attached to a bone lies in it by intention, with the triangles around.
  [[nodiscard]] bool is_attached_to(std::size_t triangle, int bone) const {
    return std::ranges::any_of(m_triangles[triangle],
                               [&](int node) { return m_carriers[static_cast<std::size_t>(node)] == bone; });
  }

  void find_contacts(const ContactStageInput& input) {
    m_contacts.clear();
    for (const int triangle : m_searched) measure(static_cast<std::size_t>(triangle), input.predicted);
    m_clearances.collect_expired(input.bone_poses, m_centres, m_searched);
    for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
      for (const int triangle : m_clearances.expired(static_cast<int>(bone))) {
        search(static_cast<std::size_t>(triangle), bone, input);
      }
    }
  }

  /// Its middle, and whether it still fits the sphere that its clearances are of.
  void measure(std::size_t triangle, std::span<const Vec3> positions) {
    const auto& [a, b, c] = m_triangles[triangle];
    const Vec3& pa = positions[static_cast<std::size_t>(a)];
    const Vec3& pb = positions[static_cast<std::size_t>(b)];
    const Vec3& pc = positions[static_cast<std::size_t>(c)];
    const Vec3 centre = (pa + pb + pc) / 3;
    const double radius_m =
        std::sqrt(std::max({(pa - centre).squaredNorm(), (pb - centre).squaredNorm(), (pc - centre).squaredNorm()}));
    m_centres[triangle] = centre;
    if (radius_m <= m_reaches_m[triangle]) return;
    m_reaches_m[triangle] = allowed_growth * radius_m;
    for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
      m_clearances.store(static_cast<int>(bone), static_cast<int>(triangle), centre, 0);
    }
  }

  void search(std::size_t triangle, std::size_t bone, const ContactStageInput& input) {
    const RigidMotion& pose = input.bone_poses[bone];
    const Vec3 centre = pose.apply_inverse(m_centres[triangle]);
    if (!centre.allFinite()) return;  // the run ends as diverged after this frame
    const auto stored = [&](double clearance_m) {
      m_clearances.store(static_cast<int>(bone), static_cast<int>(triangle), centre, clearance_m);
    };
    if (is_attached_to(triangle, static_cast<int>(bone))) return stored(anywhere_m);
    int& near = m_bones[bone].near_triangles[triangle];
    const Clearance clearance = m_bones[bone].surface->tree().clearance_from(centre, near);
    if (clearance.distance_m > 0) near = clearance.triangle;
    const double needed_m = m_reaches_m[triangle] + m_skin_m;
    if (clearance.distance_m > needed_m) return stored(clearance.distance_m - needed_m);  // or wholly inside
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = pose.apply_inverse(input.predicted[static_cast<std::size_t>(m_triangles[triangle][k])]);
    }
    const std::size_t first = m_contacts.size();
    const auto descend_from = [&](const Vec3& start) {
      const DeepestPoint deepest = find_deepest(*m_bones[bone].surface, corners, start, near);
      near = deepest.located.closest.triangle;
      const bool is_near = deepest.located.signed_distance_m() < m_skin_m;
      const bool is_new = std::none_of(
          m_contacts.begin() + static_cast<std::ptrdiff_t>(first), m_contacts.end(), [&](const FaceContact& known) {
            return (known.weights - deepest.weights).lpNorm<Eigen::Infinity>() < least_apart;
          });
      if (is_near && is_new) {
        m_contacts.push_back({triangle, bone, deepest.weights, deepest.located.closest.point,
                              m_bones[bone].surface->outward(deepest.at, deepest.located)});
      }
      return is_near;
    };
    if (!descend_from(centre)) return;
    // A ridge cuts a triangle along a line: what keeps one of its ends out leaves the other one in.
    for (const Vec3& corner : corners) (void)descend_from(0.3 * centre + 0.7 * corner);
  }

  /// Projected descent: along the part of the gradient in the triangle's plane, back into the triangle, by half the
  /// step where that goes no deeper.
  static DeepestPoint find_deepest(const SignedSurface& surface, const std::array<Vec3, 3>& corners, const Vec3& start,
                                   int near) {
    const auto& [a, b, c] = corners;
    const Vec3 centre = (a + b + c) / 3;
    const Vec3 normal = (b - a).cross(c - a).stableNormalized();
    const double radius_m =
        std::sqrt(std::max({(a - centre).squaredNorm(), (b - centre).squaredNorm(), (c - centre).squaredNorm()}));
    DeepestPoint best{start, Vec3::Constant(1.0 / 3), surface.locate_from(start, near)};
    double step_m = 0.5 * radius_m;
    for (int query = 1; query < most_queries && step_m > least_step * radius_m; ++query) {
      const Vec3 gradient = surface.outward(best.at, best.located);
      const Vec3 in_plane = gradient - normal.dot(gradient) * normal;
      const double slope = in_plane.norm();
      if (!(slope > 1e-6)) break;
      const Vec3 trial = closest_on_triangle(best.at - step_m / slope * in_plane, a, b, c).point;
      const SignedPoint located = surface.locate_from(trial, best.located.closest.triangle);
      if (located.signed_distance_m() < best.located.signed_distance_m()) {
        best.at = trial;
        best.located = located;
      } else {
        step_m *= 0.5;
      }
    }
    best.weights = barycentric(best.at, corners);
    return best;
  }

  /// As between muscles (MuscleContactResponse): all contacts are corrected from the same positions, each divided by
  /// the sum of the moduli of its row (l1-Jacobi).
  void resolve(const ContactStageInput& input) {
    m_moved.clear();
    m_acted = 0;
    for (const FaceContact& contact : m_contacts) {
      for (std::size_t k = 0; k < 3; ++k) {
        const int node = m_triangles[contact.triangle][k];
        double& load = m_loads[static_cast<std::size_t>(node)];
        if (load == 0 && contact.weights[static_cast<Eigen::Index>(k)] > 0) m_moved.push_back(node);
        load += contact.weights[static_cast<Eigen::Index>(k)];
      }
    }
    std::ranges::sort(m_moved);
    for (int step = 0; step < m_steps; ++step) {
      int acted = 0;
      for (const FaceContact& contact : m_contacts) acted += correct(contact, input) ? 1 : 0;
      m_acted = std::max(m_acted, acted);
      for (const int node : m_moved) {
        const auto i = static_cast<std::size_t>(node);
        input.predicted[i] += std::exchange(m_corrections[i], Vec3::Zero());
        input.start[i] += std::exchange(m_start_corrections[i], Vec3::Zero());
      }
    }
    for (const int node : m_moved) m_loads[static_cast<std::size_t>(node)] = 0;
  }

  bool correct(const FaceContact& contact, const ContactStageInput& input) {
    const Triangle& nodes = m_triangles[contact.triangle];
    const RigidMotion& pose = input.bone_poses[contact.bone];
    const RigidMotion& previous = input.previous_bone_poses[contact.bone];
    const Vec3 normal = pose.apply_to_direction(contact.normal);
    Vec3 point = Vec3::Zero();
    Vec3 start = Vec3::Zero();
    double row_sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto node = static_cast<std::size_t>(nodes[k]);
      const double weight = contact.weights[static_cast<Eigen::Index>(k)];
      point += weight * input.predicted[node];
      start += weight * input.start[node];
      row_sum += m_inverse_masses[node] * weight * m_loads[node];
    }
    const double gap_m = normal.dot(point - pose.apply(contact.point));
    if (!(gap_m < 0) || !(row_sum > 0)) return false;
    const double start_gap_m = previous.apply_to_direction(contact.normal).dot(start - previous.apply(contact.point));
    const double began_inside = std::clamp(start_gap_m / gap_m, 0.0, 1.0);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto node = static_cast<std::size_t>(nodes[k]);
      const double share = m_inverse_masses[node] * contact.weights[static_cast<Eigen::Index>(k)];
      const Vec3 correction = (-gap_m / row_sum * share) * normal;
      m_corrections[node] += correction;
      m_start_corrections[node] += began_inside * correction;
    }
    return true;
  }

  std::span<const Triangle> m_triangles;
  std::vector<double> m_inverse_masses;
  int m_interval;
  double m_skin_m;
  int m_steps;
  std::int64_t m_calls = 0;
  std::vector<int> m_carriers;  ///< by node: the bone that it is attached to; -1: free
  std::vector<int> m_searched;  ///< triangles that have a free node
  ClearanceCache m_clearances;  ///< of triangles, by their middles
  std::vector<BoneSurface> m_bones;
  std::vector<Vec3> m_centres;      ///< by triangle
  std::vector<double> m_reaches_m;  ///< by triangle: radius about its middle that its clearances allow for
  std::vector<FaceContact> m_contacts;
  int m_acted = 0;
  // By node, zero but for m_moved.
  std::vector<double> m_loads;
  std::vector<Vec3> m_corrections;
  std::vector<Vec3> m_start_corrections;
  std::vector<int> m_moved;
};

}  // namespace

std::unique_ptr<ContactStage> make_surface_contact(const StageInput& input, const Parameters& parameters) {
  return std::make_unique<SurfaceContact>(input, static_cast<int>(parameters.integer("interval")),
                                          parameters.number("skin_m"), static_cast<int>(parameters.integer("steps")));
}

std::vector<ParameterSpec> surface_contact_parameters() {
  // LHDL gluteus maximus: ten corrections halve what three leave of the depth, more gain little.
  return {parameter::integer({.name = "interval",
                              .default_value = 5,
                              .minimum = 1,
                              .maximum = 1000,
                              .help = "collision steps between two searches for the deepest points"}),
          parameter::number({.name = "skin_m",
                             .unit = "m",
                             .default_value = 2.5e-4,
                             .minimum = 0,
                             .maximum = 0.1,
                             .help = "points so near a bone are watched until the next search"}),
          parameter::integer({.name = "steps",
                              .default_value = 10,
                              .minimum = 1,
                              .maximum = 1000,
                              .help = "corrections a collision step"})};
}

}  // namespace musclebench

#include "core/effects/surface_contact/face_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "core/base/parallel_chunks.hpp"
#include "core/distance/triangle_distance.hpp"

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
/// A barycentric coordinate below this is 0: the point is on an edge or in a corner.
constexpr double on_border = 1e-2;
/// Where less of the gradient is left for a face to be pushed out by, its own normal is taken.
constexpr double least_along = 0.2;
/// Mean gradient of a ridge whose sides are so steep that it has no direction but by rounding.
constexpr double thinnest = 1e-3;
/// Clearance of a triangle that no contact is sought for.
constexpr double anywhere_m = 1e6;
constexpr std::size_t chunk_size = 32;

/// A triangle of the muscle in a bone's rest frame.
struct Face {
  std::array<Vec3, 3> corners;
  Vec3 centre;
  Vec3 normal;  ///< unit, out of the muscle
  double radius_m;

  explicit Face(const std::array<Vec3, 3>& at)
      : corners(at),
        centre((at[0] + at[1] + at[2]) / 3),
        normal((at[1] - at[0]).cross(at[2] - at[0]).stableNormalized()),
        radius_m(std::sqrt(std::max(
            {(at[0] - centre).squaredNorm(), (at[1] - centre).squaredNorm(), (at[2] - centre).squaredNorm()}))) {}

  [[nodiscard]] Vec3 at(const Vec3& weights) const {
    return weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
  }

  /// Of what may poke through it or is closer to it than `skin_m`.
  [[nodiscard]] Eigen::AlignedBox3d surroundings(double skin_m) const {
    return {centre.array() - (radius_m + skin_m), centre.array() + (radius_m + skin_m)};
  }

  [[nodiscard]] Vec3 weights_of(const Vec3& point) const {
    return barycentric(point, corners, Vec3::Constant(1.0 / 3));
  }
};

struct DeepestPoint {
  Vec3 at;
  SurfaceAnswer located;
  Vec3 gradient_beside;  ///< where the descent looked last before; on a ridge often that of its other side
};

/// The share of a step from `best` to `trial`, which goes no deeper, that the next one takes: where the tangents at
/// both ends meet, so that a ridge between them, where the distance has a kink, is hit at once.
double next_share(const DeepestPoint& best, const Vec3& trial, const SurfaceAnswer& located) {
  const Vec3 step = trial - best.at;
  const double falls_m = -best.located.gradient.dot(step);
  const double rises_m = located.gradient.dot(step);
  const double gained_m = best.located.signed_distance_m - located.signed_distance_m + rises_m;
  return falls_m > 0 && rises_m > 0 ? std::clamp(gained_m / (falls_m + rises_m), 0.02, 0.98) : 0.5;
}

/// Projected descent: along the part of the gradient in the face's plane, back into the face, by a shorter step where
/// that goes no deeper.
DeepestPoint find_deepest(const SurfaceQueries& surface, const Face& face, const Vec3& start, int near) {
  const auto& [a, b, c] = face.corners;
  const SurfaceAnswer at_start = surface.locate(start, near);
  DeepestPoint best{start, at_start, at_start.gradient};
  double step_m = 0.5 * face.radius_m;
  for (int query = 1; query < most_queries && step_m > least_step * face.radius_m; ++query) {
    const Vec3& gradient = best.located.gradient;
    const Vec3 in_plane = gradient - face.normal.dot(gradient) * face.normal;
    const double slope = in_plane.norm();
    if (!(slope > 1e-6)) break;
    const Vec3 trial = closest_on_triangle(best.at - step_m / slope * in_plane, a, b, c).point;
    const SurfaceAnswer located = surface.locate_from(trial, best.at, best.located);
    if (located.signed_distance_m < best.located.signed_distance_m) {
      best = {trial, located, best.located.gradient};
    } else {
      step_m *= next_share(best, trial, located);
      best.gradient_beside = located.gradient;
    }
  }
  return best;
}

/// The part of a direction along which a point with these weights can move within the face: along its plane or, on its
/// border, along the edge.
Vec3 along_face(const Face& face, const Vec3& weights, const Vec3& direction) {
  const auto inner = (weights.array() > on_border).count();
  if (inner == 3) return direction - face.normal.dot(direction) * face.normal;
  if (inner < 2) return Vec3::Zero();
  Eigen::Index least = 0;
  weights.minCoeff(&least);
  const auto opposite = static_cast<std::size_t>(least);
  const Vec3 edge = (face.corners[(opposite + 2) % 3] - face.corners[(opposite + 1) % 3]).stableNormalized();
  return edge.dot(direction) * edge;
}

/// Direction, of unit length, by which the deepest point of a face leaves the bone without another point of the face
/// becoming the deepest: the mean of the gradients on both sides that has the least part along the face, without that
/// part. Where the distance is smooth, the gradients are equal and have no such part at a minimum. Across a ridge they
/// differ, and their mean is normal to ridge and edge. Beside a spike the part along the face may be nearly all; then
/// the face gives way into the muscle.
Vec3 direction_out(const Face& face, const Vec3& weights, const DeepestPoint& deepest) {
  const Vec3& gradient = deepest.located.gradient;
  const Vec3 along = along_face(face, weights, gradient);
  const Vec3 change = along - along_face(face, weights, deepest.gradient_beside);
  const double squared = change.squaredNorm();
  const double beside = squared > 0 ? std::clamp(along.dot(change) / squared, 0.0, 1.0) : 0.0;
  const Vec3 mean = (1 - beside) * gradient + beside * deepest.gradient_beside;
  const Vec3 direction = mean - along_face(face, weights, mean);
  const double part = direction.norm();
  return part > least_along * mean.norm() && part > thinnest ? Vec3(direction / part) : Vec3(-face.normal);
}

/// Point of the bone's surface and normal of the plane that keeps the point at `deepest` out.
std::pair<Vec3, Vec3> plane_at(const SurfaceQueries& surface, const Face& face, const Vec3& weights,
                               const DeepestPoint& deepest, std::vector<PathCrossing>& crossings) {
  const SurfaceAnswer& located = deepest.located;
  std::pair<Vec3, Vec3> tangent = {located.closest_m, located.gradient};
  const Vec3 out = direction_out(face, weights, deepest);
  if (!(located.signed_distance_m < 0)) {
    return out.dot(located.gradient) > least_along ? std::pair(located.closest_m, out) : tangent;
  }
  // The tangent plane is met at depth / (out . gradient); a ridge that pokes through ends before or a little behind it.
  const double length_m = -2 * located.signed_distance_m / std::max(out.dot(located.gradient), least_along);
  const std::optional<double> way_m = surface.way_out_m(deepest.at, out, length_m, located.near, crossings);
  return way_m ? std::pair<Vec3, Vec3>(deepest.at + *way_m * out, out) : tangent;
}

/// Collects the contacts of one face with one bone, each from where a descent began.
class FaceSearch {
 public:
  /// `near` is for queries near the face. Appends to `found`.
  FaceSearch(const SurfaceQueries& surface, const Face& face, double skin_m, int& near, std::vector<FaceContact>& found,
             std::vector<PathCrossing>& crossings)
      : m_surface(surface),
        m_face(face),
        m_skin_m(skin_m),
        m_near(near),
        m_found(found),
        m_crossings(crossings),
        m_first(static_cast<std::ptrdiff_t>(found.size())) {}

  /// Whether it ends in the bone or within the skin.
  bool descend_from(const Vec3& start, FaceContact contact) {
    const DeepestPoint deepest = find_deepest(m_surface, m_face, start, m_near);
    m_near = deepest.located.near;
    if (!(deepest.located.signed_distance_m < m_skin_m)) return false;
    contact.weights = m_face.weights_of(deepest.at);
    if (!is_found(contact.weights)) {
      std::tie(contact.point, contact.normal) = plane_at(m_surface, m_face, contact.weights, deepest, m_crossings);
      m_found.push_back(contact);
    }
    return true;
  }

  [[nodiscard]] bool is_found(const Vec3& weights) const {
    return std::any_of(m_found.begin() + m_first, m_found.end(), [&](const FaceContact& other) {
      return (other.weights - weights).lpNorm<Eigen::Infinity>() < least_apart;
    });
  }

 private:
  const SurfaceQueries& m_surface;
  const Face& m_face;
  double m_skin_m;
  int& m_near;
  std::vector<FaceContact>& m_found;
  std::vector<PathCrossing>& m_crossings;
  std::ptrdiff_t m_first;
};

/// Appends the contacts of sharp vertices that poke through the face or nearly do. The bone comes from the side that
/// the face looks to, so the face gives way into the muscle. Whether there are any about, whether or not they meet the
/// face.
bool collect_sharp_vertices(const SharpVertices& vertices, const Face& face, double skin_m, FaceContact contact,
                            std::vector<FaceContact>& found) {
  bool are_about = false;
  contact.is_at_sharp_vertex = true;
  contact.normal = -face.normal;
  vertices.for_each_in(face.surroundings(skin_m), [&](const SharpVertices::Vertex& vertex) {
    are_about = true;
    const double height_m = face.normal.dot(vertex.position - face.centre);
    contact.weights = face.weights_of(vertex.position - height_m * face.normal);
    contact.point = vertex.position;
    if (height_m < skin_m && contact.weights.minCoeff() >= 0 && vertex.normal.dot(face.normal) < 0) {
      found.push_back(contact);
    }
  });
  return are_about;
}

Face face_of(const Triangle& triangle, std::span<const Vec3> positions, const RigidMotion& pose) {
  const auto corner = [&](std::size_t k) {
    return pose.apply_inverse(positions[static_cast<std::size_t>(triangle[k])]);
  };
  return Face({corner(0), corner(1), corner(2)});
}

}  // namespace

FaceContactFinder::FaceContactFinder(const StageInput& input, double skin_m)
    : m_triangles(input.triangles),
      m_skin_m(skin_m),
      m_threads(input.threads),
      m_carriers(input.nodes, -1),
      m_centres(input.triangles.size()),
      m_reaches_m(input.triangles.size(), 0) {
  for (const BoundNode& bound : input.bound_nodes) m_carriers[static_cast<std::size_t>(bound.node)] = bound.bone;
  for (std::size_t t = 0; t < m_triangles.size(); ++t) {
    if (has_free_node(t, input.inverse_masses)) m_searched.push_back(static_cast<int>(t));
  }
  m_clearances.reset(input.bones, m_triangles.size());
  const auto make = [make_queries = input.make_surface_queries, threads = m_threads](const Bone& bone) {
    return make_queries ? make_queries(bone, threads) : exact_surface_queries(bone);
  };
  for (std::size_t bone = 0; bone < input.bones.size(); ++bone) {
    m_bones.push_back({{input.bones[bone], input.is_untouched(bone), make},
                       SharpVertices(input.bones[bone].surface.mesh),
                       std::vector<int>(m_triangles.size(), 0),
                       {}});
  }
}

bool FaceContactFinder::has_free_node(std::size_t triangle, std::span<const double> inverse_masses) const {
  return std::ranges::any_of(m_triangles[triangle],
                             [&](int node) { return inverse_masses[static_cast<std::size_t>(node)] > 0; });
}

/// What is attached to a bone lies in it by intention, with the triangles around.
bool FaceContactFinder::is_attached_to(std::size_t triangle, std::size_t bone) const {
  return std::ranges::any_of(m_triangles[triangle], [&](int node) {
    return m_carriers[static_cast<std::size_t>(node)] == static_cast<int>(bone);
  });
}

std::span<const FaceContact> FaceContactFinder::find(std::span<const Vec3> positions,
                                                     std::span<const RigidMotion> bone_poses) {
  m_known.swap(m_found);
  m_found.clear();
  for (const int triangle : m_searched) measure(static_cast<std::size_t>(triangle), positions);
  m_clearances.collect_expired(bone_poses, m_centres, m_searched);
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) search_all(bone, positions, bone_poses[bone]);
  return m_found;
}

/// Its middle, and whether it still fits the sphere that its clearances are of.
void FaceContactFinder::measure(std::size_t triangle, std::span<const Vec3> positions) {
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

void FaceContactFinder::search_all(std::size_t bone, std::span<const Vec3> positions, const RigidMotion& pose) {
  const std::span<const int> expired = m_clearances.expired(static_cast<int>(bone));
  build_if_near(bone, expired, pose);
  const std::size_t chunks = chunk_count(expired.size(), chunk_size);
  if (m_chunks.size() < chunks) m_chunks.resize(chunks);
  for_each_chunk(expired.size(), chunk_size, m_threads, [&](std::size_t chunk, std::size_t first, std::size_t last) {
    m_chunks[chunk].found.clear();
    m_chunks[chunk].pointed_triangles.clear();
    for (const int triangle : expired.subspan(first, last - first)) {
      search(static_cast<std::size_t>(triangle), bone, positions, pose, m_chunks[chunk]);
    }
  });
  std::vector<int>& pointed = m_bones[bone].pointed_triangles;
  pointed.clear();
  for (const Chunk& chunk : std::span(m_chunks).first(chunks)) {
    m_found.insert(m_found.end(), chunk.found.begin(), chunk.found.end());
    pointed.insert(pointed.end(), chunk.pointed_triangles.begin(), chunk.pointed_triangles.end());
  }
}

/// Before the threads begin: what they read is built by then.
void FaceContactFinder::build_if_near(std::size_t bone, std::span<const int> triangles, const RigidMotion& pose) {
  StageSurface<SurfaceQueries>& surface = m_bones[bone].surface;
  if (surface.is_built()) return;
  const auto is_near = [&](int triangle) {
    const auto t = static_cast<std::size_t>(triangle);
    const Vec3 centre = pose.apply_inverse(m_centres[t]);
    return centre.allFinite() && surface.box_distance_m(centre) <= m_reaches_m[t] + m_skin_m;
  };
  if (std::ranges::any_of(triangles, is_near)) (void)surface.get();
}

std::span<const FaceContact> FaceContactFinder::known(std::size_t bone, std::size_t triangle) const {
  const auto key_of = [](const FaceContact& contact) { return std::pair(contact.bone, contact.triangle); };
  const auto first = std::ranges::lower_bound(m_known, std::pair(bone, triangle), {}, key_of);
  const auto last = std::ranges::upper_bound(m_known, std::pair(bone, triangle), {}, key_of);
  return {first, last};
}

void FaceContactFinder::search(std::size_t triangle, std::size_t bone, std::span<const Vec3> positions,
                               const RigidMotion& pose, Chunk& chunk) {
  const Vec3 centre = pose.apply_inverse(m_centres[triangle]);
  if (!centre.allFinite()) return;  // the run ends as diverged after this frame
  const auto stored = [&](double clearance_m) {
    m_clearances.store(static_cast<int>(bone), static_cast<int>(triangle), centre, clearance_m);
  };
  if (is_attached_to(triangle, bone)) return stored(anywhere_m);
  const double needed_m = m_reaches_m[triangle] + m_skin_m;
  const double by_box_m = m_bones[bone].surface.box_distance_m(centre);
  if (by_box_m > needed_m) return stored(by_box_m - needed_m);
  const SurfaceQueries& surface = m_bones[bone].surface.get();
  int& near = m_bones[bone].near[triangle];
  const Clearance clearance = surface.clearance(centre, near);
  if (clearance.distance_m > 0) near = clearance.triangle;
  if (clearance.distance_m > needed_m) return stored(clearance.distance_m - needed_m);  // or wholly inside
  const Face face = face_of(m_triangles[triangle], positions, pose);
  const FaceContact contact{.triangle = triangle, .bone = bone};
  if (collect_sharp_vertices(m_bones[bone].sharp_vertices, face, m_skin_m, contact, chunk.found)) {
    chunk.pointed_triangles.push_back(static_cast<int>(triangle));
  }
  FaceSearch face_search(surface, face, m_skin_m, near, chunk.found, chunk.crossings);
  if (!face_search.descend_from(face.centre, contact)) return;
  for (const Vec3& corner : face.corners) (void)face_search.descend_from(0.3 * face.centre + 0.7 * corner, contact);
  for (const FaceContact& last : known(bone, triangle)) {
    if (!face_search.is_found(last.weights)) (void)face_search.descend_from(face.at(last.weights), contact);
  }
}

std::span<const FaceContact> FaceContactFinder::follow(std::span<const Vec3> positions,
                                                       std::span<const RigidMotion> bone_poses) {
  std::erase_if(m_found, [](const FaceContact& contact) { return contact.is_at_sharp_vertex; });
  const auto others = static_cast<std::ptrdiff_t>(m_found.size());
  for (std::size_t bone = 0; bone < m_bones.size(); ++bone) follow_all(bone, positions, bone_poses[bone]);
  std::inplace_merge(m_found.begin(), m_found.begin() + others, m_found.end(),
                     [](const FaceContact& a, const FaceContact& b) {
                       return std::pair(a.bone, a.triangle) < std::pair(b.bone, b.triangle);
                     });
  return m_found;
}

void FaceContactFinder::follow_all(std::size_t bone, std::span<const Vec3> positions, const RigidMotion& pose) {
  for (const int triangle : m_bones[bone].pointed_triangles) {
    const auto t = static_cast<std::size_t>(triangle);
    const Face face = face_of(m_triangles[t], positions, pose);
    if (!face.centre.allFinite()) continue;
    (void)collect_sharp_vertices(m_bones[bone].sharp_vertices, face, m_skin_m, {.triangle = t, .bone = bone}, m_found);
  }
}

}  // namespace musclebench

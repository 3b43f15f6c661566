#include "core/effects/no_passage/no_passage.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/base/parallel_chunks.hpp"
#include "core/contact/contact_rows.hpp"
#include "core/effects/no_passage/passage_surfaces.hpp"

namespace musclebench {

namespace {

/// Features end a substep no closer than this share of what they had, or of the gap where that is less.
constexpr double least_share = 0.2;
/// What is closer than this share of the gap touches: its direction apart is rounding.
constexpr double touching_share = 1e-3;
/// Sine of the angle by which surfaces that touch have to face each other.
constexpr double least_facing = 0.2;
/// Sine of the least angle between edges that touch.
constexpr double least_angle = 1e-3;
/// Of an edge: what is closer to its end is at its end.
constexpr double on_border = 1e-3;
/// Corrections of all rows in a round.
constexpr int row_steps = 10;
constexpr std::size_t chunk_size = 64;
/// Distance of a pair without stencils: other triangles own their features.
constexpr double anywhere_m = 1e6;

std::size_t at_index(int value) { return static_cast<std::size_t>(value); }

/// Two features that come too close on their paths.
struct Hit {
  PassageStencil stencil;
  std::array<double, 4> weights = {};  ///< of StencilGap, just before they touch
  Vec3 normal = Vec3::Zero();          ///< unit, from the second side to the first, in the frame of the paths; or 0
  StencilCorners at = {};              ///< the corners then
  double target_m = 0;                 ///< that they are to keep
};

/// How the corners of a triangle move on their paths.
struct TriangleMotion {
  Vec3 mean_m = Vec3::Zero();
  double spread_m = 0;  ///< no corner moves otherwise by more

  TriangleMotion() = default;
  TriangleMotion(const Triangle& triangle, std::span<const Vec3> start, std::span<const Vec3> end) {
    std::array<Vec3, 3> moves;
    for (std::size_t k = 0; k < 3; ++k) moves[k] = end[at_index(triangle[k])] - start[at_index(triangle[k])];
    mean_m = (moves[0] + moves[1] + moves[2]) / 3;
    double squared = 0;
    for (const Vec3& move : moves) squared = std::max(squared, (move - mean_m).squaredNorm());
    spread_m = std::sqrt(squared);
  }
};

/// How far two triangles come closer at most.
double approach_m(const TriangleMotion& one, const TriangleMotion& other) {
  return (one.mean_m - other.mean_m).norm() + one.spread_m + other.spread_m;
}

/// A pair of triangles whose distance was measured: that of its stencils is no smaller than `left_m` where the paths
/// of the last substep began.
struct KnownPair {
  std::size_t place;  ///< of the other triangle in its tree
  double left_m;
};

/// Motions of all triangles in one frame, of this substep and the last, and what is known of pairs with one tree.
struct PairsWithTree {
  std::vector<TriangleMotion> now;
  std::vector<TriangleMotion> last;
  std::vector<std::vector<KnownPair>> known;  ///< by triangle, ascending in place

  void reset(std::size_t triangles) {
    last.assign(triangles, {});
    known.assign(triangles, {});
  }
  static void measure(std::span<const Triangle> triangles, std::span<const Vec3> start, std::span<const Vec3> end,
                      std::vector<TriangleMotion>& motions) {
    motions.resize(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) motions[t] = TriangleMotion(triangles[t], start, end);
  }
};

/// Disjoint sets of numbers, each told by its smallest.
class JoinedSets {
 public:
  void reset(std::size_t count) {
    m_parents.resize(count);
    std::iota(m_parents.begin(), m_parents.end(), 0);
  }
  int find(int item) {
    while (m_parents[at_index(item)] != item) {
      item = m_parents[at_index(item)] = m_parents[at_index(m_parents[at_index(item)])];
    }
    return item;
  }
  void join(int one, int other) {
    one = find(one);
    other = find(other);
    m_parents[at_index(std::max(one, other))] = std::min(one, other);
  }

 private:
  std::vector<int> m_parents;
};

Eigen::AlignedBox3d swept_box(const Triangle& triangle, std::span<const Vec3> start, std::span<const Vec3> end) {
  Eigen::AlignedBox3d box;
  for (const int node : triangle) {
    box.extend(start[at_index(node)]);
    box.extend(end[at_index(node)]);
  }
  return box;
}

Vec3 middle_of(const Triangle& triangle, std::span<const Vec3> at) {
  return (at[at_index(triangle[0])] + at[at_index(triangle[1])] + at[at_index(triangle[2])]) / 3;
}

bool share_a_vertex(const std::array<int, 4>& corners, StencilKind kind) {
  const auto& [a, b, c, d] = corners;
  if (kind == StencilKind::node_face) return a == b || a == c || a == d;
  return a == c || a == d || b == c || b == d;
}

/// Whether the boxes around the paths of both sides, without what all corners move alike, are farther apart than
/// `least_m` along some axis.
bool are_paths_apart(StencilKind kind, const StencilCorners& start, const StencilCorners& end, double least_m) {
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k) mean += 0.25 * (end[k] - start[k]);
  const std::size_t second = kind == StencilKind::node_face ? 1 : 2;
  std::array<Eigen::AlignedBox3d, 2> boxes;
  for (std::size_t k = 0; k < 4; ++k) {
    boxes[k < second ? 0 : 1].extend(start[k]);
    boxes[k < second ? 0 : 1].extend(Vec3(end[k] - mean));
  }
  return ((boxes[0].min() - boxes[1].max()).array() > least_m).any() ||
         ((boxes[1].min() - boxes[0].max()).array() > least_m).any();
}

Vec3 area_normal(const std::array<Vec3, 3>& corners) {
  return (corners[1] - corners[0]).cross(corners[2] - corners[0]);
}

/// Whether the edge from `from` to `to` goes through the triangle's inside and reaches farther than `touching_m` beyond
/// it on both sides.
bool pierces(const Vec3& from, const Vec3& to, const std::array<Vec3, 3>& triangle, double touching_m) {
  const auto& [a, b, c] = triangle;
  const Vec3 normal = area_normal(triangle).stableNormalized();
  const double below_m = normal.dot(from - a);
  const double above_m = normal.dot(to - a);
  if (std::min(below_m, above_m) > -touching_m || std::max(below_m, above_m) < touching_m) return false;
  const Vec3 along = to - from;
  const auto side = [&](const Vec3& one, const Vec3& other) {
    const double volume = along.dot((one - from).cross(other - from));
    return std::abs(volume) > touching_m * along.norm() * (other - one).norm() ? (volume > 0 ? 1 : -1) : 0;
  };
  const int first = side(a, b);
  return first != 0 && first == side(b, c) && first == side(c, a);
}

bool intersect(const std::array<Vec3, 3>& one, const std::array<Vec3, 3>& other, double touching_m) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (pierces(one[k], one[(k + 1) % 3], other, touching_m)) return true;
    if (pierces(other[k], other[(k + 1) % 3], one, touching_m)) return true;
  }
  return false;
}

/// Unit normals of the vertices, by area.
void normals_of(std::span<const Triangle> triangles, std::span<const Vec3> at, std::vector<Vec3>& normals) {
  normals.assign(at.size(), Vec3::Zero());
  for (const auto& [a, b, c] : triangles) {
    const Vec3 area = area_normal({at[at_index(a)], at[at_index(b)], at[at_index(c)]});
    for (const int vertex : {a, b, c}) normals[at_index(vertex)] += area;
  }
  for (Vec3& normal : normals) normal = normal.stableNormalized();
}

class NoPassage final : public ContactStage {
 public:
  NoPassage(const StageInput& input, double gap_m, int rounds)
      : m_mesh(*input.mesh),
        m_bodies(input.bodies.begin(), input.bodies.end()),
        m_gap_m(gap_m),
        m_rounds(rounds),
        m_threads(input.threads),
        m_inverse_masses(input.inverse_masses.begin(), input.inverse_masses.end()),
        m_carriers(input.nodes, -1),
        m_features(m_mesh.triangles, m_mesh.vertices.size()),
        m_solver(m_inverse_masses, input.contacts.friction_coefficient),
        m_is_moved(input.nodes, 1) {
    for (const BoundNode& bound : input.bound_nodes) m_carriers[at_index(bound.node)] = bound.bone;
    std::vector<Vec3> middles;
    for (const Triangle& triangle : m_mesh.triangles) middles.push_back(middle_of(triangle, m_mesh.vertices));
    m_tree = BoxTree(middles);
    for (const Bone& bone : input.bones) m_bones.emplace_back(bone.surface.mesh);
    m_body_of.resize(m_mesh.triangles.size(), 0);
    for (std::size_t body = 0; body < m_bodies.size(); ++body) {
      for (std::size_t t = m_bodies[body].first_triangle; t < m_bodies[body].last_triangle; ++t) m_body_of[t] = body;
    }
    m_pairs.reset(m_mesh.triangles.size());
    for (BoneSurface& bone : m_bones) bone.pairs.reset(m_mesh.triangles.size());
    m_is_left_out.assign((m_bones.size() + m_bodies.size()) * input.nodes, 0);
  }

  [[nodiscard]] std::string_view name() const override { return "no_passage"; }

  std::span<const int> before_bones(const ContactStageInput& input) override {
    if (m_safe.empty()) {
      m_safe.assign(input.start.begin(), input.start.end());
      m_proposed = m_safe;
      place_in_bones(input.previous_bone_poses, input.previous_bone_poses, m_safe);
      leave_out_intersecting();
    }
    return {};
  }

  std::span<const int> end_substep(const ContactStageInput& input) override {
    m_proposed.assign(input.predicted.begin(), input.predicted.end());
    std::ranges::fill(m_is_moved, 1);
    normals_of(m_mesh.triangles, m_safe, m_normals);
    m_rows.clear();
    m_row_of.clear();
    m_hit_count = 0;
    for (int round = 0; find_hits(input, round == 0) && round < m_rounds; ++round) {
      m_hit_count = std::max(m_hit_count, static_cast<int>(m_hits.size()));
      for (const Hit& hit : m_hits) add_row(hit, input);
      m_solver.solve(m_rows, input.start, m_proposed);
      std::ranges::fill(m_is_moved, 0);
      for (const int node : m_solver.moved_nodes()) m_is_moved[at_index(node)] = 1;
      for (const Hit& hit : m_hits) look_again_at(hit.stencil);
    }
    if (!m_hits.empty()) move_in_zones(input);
    m_changed.clear();
    for (std::size_t node = 0; node < m_proposed.size(); ++node) {
      if (m_proposed[node] == input.predicted[node]) continue;
      input.predicted[node] = m_proposed[node];
      m_changed.push_back(static_cast<int>(node));
    }
    measure_motions(&PairsWithTree::last);
    m_safe.assign(m_proposed.begin(), m_proposed.end());
    if (m_are_left_out) leave_out_intersecting();
    return m_changed;
  }

  /// Pairs of features that came too close in the round that had most.
  [[nodiscard]] int contact_count() const override { return m_hit_count; }

 private:
  struct BoneSurface {
    explicit BoneSurface(const TriangleMesh& surface)
        : mesh(surface), features(surface.triangles, surface.vertices.size()) {
      std::vector<Vec3> middles;
      for (const Triangle& triangle : mesh.triangles) middles.push_back(middle_of(triangle, mesh.vertices));
      tree = BoxTree(middles);
      tree.refit([&](std::size_t t) { return swept_box(mesh.triangles[t], mesh.vertices, mesh.vertices); });
      normals_of(mesh.triangles, mesh.vertices, normals);
    }

    const TriangleMesh& mesh;
    OwnedFeatures features;
    BoxTree tree;
    std::vector<Vec3> normals;        ///< by vertex
    Mat3 to_rest = Mat3::Identity();  ///< directions where the paths start
    // By node, in the bone's rest frame.
    std::vector<Vec3> start;
    std::vector<Vec3> end;
    PairsWithTree pairs;
  };
  /// What one thread finds.
  struct Chunk {
    std::vector<Hit> hits;
    std::vector<KnownPair> known;
  };

  [[nodiscard]] std::array<Vec3, 3> corners_of(const TriangleMesh& mesh, std::size_t triangle,
                                               std::span<const Vec3> at) const {
    const auto& [a, b, c] = mesh.triangles[triangle];
    return {at[at_index(a)], at[at_index(b)], at[at_index(c)]};
  }

  /// The paths of nodes that have moved since the last time.
  void place_in_bones(std::span<const RigidMotion> previous, std::span<const RigidMotion> poses,
                      std::span<const Vec3> start) {
    for (std::size_t b = 0; b < m_bones.size(); ++b) {
      BoneSurface& bone = m_bones[b];
      bone.start.resize(start.size());
      bone.to_rest = previous[b].rotation.transpose();
      bone.end.resize(start.size());
      for (std::size_t node = 0; node < start.size(); ++node) {
        if (m_is_moved[node] == 0) continue;
        bone.start[node] = previous[b].apply_inverse(start[node]);
        bone.end[node] = poses[b].apply_inverse(m_proposed[node]);
      }
    }
  }

  [[nodiscard]] char* left_out(std::size_t collider) { return m_is_left_out.data() + collider * m_carriers.size(); }
  [[nodiscard]] const char* left_out(std::size_t collider) const {
    return m_is_left_out.data() + collider * m_carriers.size();
  }

  /// Nodes of triangles that intersect a collider where they are now; after the first time only of those that did.
  void leave_out_intersecting() {
    const bool is_first = std::exchange(m_is_first, false);
    m_still_left_out.assign(m_is_left_out.size(), 0);
    m_are_left_out = false;
    const auto mark = [&](std::size_t collider, const Triangle& triangle) {
      for (const int node : triangle) {
        const std::size_t i = collider * m_carriers.size() + at_index(node);
        if (!is_first && m_is_left_out[i] == 0) continue;
        m_still_left_out[i] = 1;
        m_are_left_out = true;
      }
    };
    m_tree.refit([&](std::size_t t) { return swept_box(m_mesh.triangles[t], m_safe, m_safe); });
    for (std::size_t t = 0; t < m_mesh.triangles.size(); ++t) {
      const Triangle& triangle = m_mesh.triangles[t];
      for (std::size_t b = 0; b < m_bones.size(); ++b) {
        if (!is_first && !is_any_left_out(b, triangle)) continue;
        const BoneSurface& bone = m_bones[b];
        const std::array<Vec3, 3> own = corners_of(m_mesh, t, is_first ? bone.start : bone.end);
        Eigen::AlignedBox3d box;
        for (const Vec3& corner : own) box.extend(corner);
        bool does = false;
        bone.tree.for_each_in(box, 0, [&](std::size_t other, std::size_t) {
          does = does || intersect(own, corners_of(bone.mesh, other, bone.mesh.vertices), touching_m());
        });
        if (does) mark(b, triangle);
      }
      const std::array<Vec3, 3> own = corners_of(m_mesh, t, m_safe);
      Eigen::AlignedBox3d box;
      for (const Vec3& corner : own) box.extend(corner);
      m_tree.for_each_in(box, 0, [&](std::size_t other, std::size_t) {
        if (other <= t) return;
        const std::size_t of_other = m_bones.size() + m_body_of[other];
        const std::size_t of_one = m_bones.size() + m_body_of[t];
        const Triangle& second = m_mesh.triangles[other];
        if (!is_first && !is_any_left_out(of_other, triangle) && !is_any_left_out(of_one, second)) return;
        for (const int node : triangle) {
          if (node == second[0] || node == second[1] || node == second[2]) return;
        }
        if (!intersect(own, corners_of(m_mesh, other, m_safe), touching_m())) return;
        mark(of_other, triangle);
        mark(of_one, second);
      });
    }
    m_is_left_out.swap(m_still_left_out);
  }

  [[nodiscard]] bool is_any_left_out(std::size_t collider, const Triangle& triangle) const {
    const char* of = left_out(collider);
    return of[triangle[0]] != 0 || of[triangle[1]] != 0 || of[triangle[2]] != 0;
  }

  /// Whether a stencil is none of this effect's concern.
  [[nodiscard]] bool is_exempt(const PassageStencil& stencil) const {
    bool are_all_carried = true;
    for (std::size_t k = 0; k < 4; ++k) {
      if (stencil.is_of_bone(k)) continue;
      const int node = stencil.corners[k];
      const int carrier = m_carriers[at_index(node)];
      are_all_carried = are_all_carried && carrier >= 0;
      if (stencil.bone >= 0 && carrier == stencil.bone) return true;
      if (stencil.bone >= 0 && m_are_left_out && left_out(at_index(stencil.bone))[node] != 0) return true;
    }
    if (are_all_carried) return true;
    if (stencil.bone >= 0 || !m_are_left_out) return false;
    const std::size_t second = stencil.kind == StencilKind::node_face ? 1 : 2;
    const std::size_t of_first = body_of(m_bodies, stencil.corners[0]);
    const std::size_t of_second = body_of(m_bodies, stencil.corners[3]);
    for (std::size_t k = 0; k < 4; ++k) {
      if (left_out(m_bones.size() + (k < second ? of_second : of_first))[stencil.corners[k]] != 0) return true;
    }
    return false;
  }

  [[nodiscard]] StencilCorners starts_of(const PassageStencil& stencil) const {
    StencilCorners starts;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t corner = at_index(stencil.corners[k]);
      if (stencil.bone < 0) {
        starts[k] = m_safe[corner];
      } else {
        const BoneSurface& bone = m_bones[at_index(stencil.bone)];
        starts[k] = stencil.is_of_bone(k) ? bone.mesh.vertices[corner] : bone.start[corner];
      }
    }
    return starts;
  }

  [[nodiscard]] std::pair<StencilCorners, StencilCorners> paths_of(const PassageStencil& stencil) const {
    StencilCorners ends;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t corner = at_index(stencil.corners[k]);
      if (stencil.bone < 0) {
        ends[k] = m_proposed[corner];
      } else {
        const BoneSurface& bone = m_bones[at_index(stencil.bone)];
        ends[k] = stencil.is_of_bone(k) ? bone.mesh.vertices[corner] : bone.end[corner];
      }
    }
    return {starts_of(stencil), ends};
  }

  /// Whether any features come too close on their paths to `m_proposed`, of triangles with a node that moved.
  bool find_hits(const ContactStageInput& input, bool is_first = false) {
    place_in_bones(input.previous_bone_poses, input.bone_poses, m_safe);
    if (is_first) measure_motions(&PairsWithTree::now);
    // What all nodes move alike makes no two triangles meet.
    m_common = Vec3::Zero();
    for (std::size_t node = 0; node < m_safe.size(); ++node) m_common += m_proposed[node] - m_safe[node];
    m_common /= static_cast<double>(std::max<std::size_t>(m_safe.size(), 1));
    m_relative.resize(m_safe.size());
    for (std::size_t node = 0; node < m_safe.size(); ++node) m_relative[node] = m_proposed[node] - m_common;
    m_tree.refit([&](std::size_t t) { return swept_box(m_mesh.triangles[t], m_safe, m_relative); });
    const std::size_t triangles = m_mesh.triangles.size();
    m_chunks.resize(chunk_count(triangles, chunk_size));
    for_each_chunk(triangles, chunk_size, m_threads, [&](std::size_t chunk, std::size_t first, std::size_t last) {
      m_chunks[chunk].hits.clear();
      for (std::size_t t = first; t < last; ++t) {
        if (is_first) {
          look_at_first(t, m_chunks[chunk]);
        } else if (is_moved(t)) {
          look_at_again(t, m_chunks[chunk].hits);
        }
      }
    });
    m_hits.clear();
    for (const Chunk& chunk : m_chunks) m_hits.insert(m_hits.end(), chunk.hits.begin(), chunk.hits.end());
    return !m_hits.empty();
  }

  void measure_motions(std::vector<TriangleMotion> PairsWithTree::*of) {
    PairsWithTree::measure(m_mesh.triangles, m_safe, m_proposed, m_pairs.*of);
    for (BoneSurface& bone : m_bones) PairsWithTree::measure(m_mesh.triangles, bone.start, bone.end, bone.pairs.*of);
  }

  [[nodiscard]] bool is_moved(std::size_t triangle) const {
    const auto& [a, b, c] = m_mesh.triangles[triangle];
    return (m_is_moved[at_index(a)] | m_is_moved[at_index(b)] | m_is_moved[at_index(c)]) != 0;
  }

  /// All pairs of a triangle with later ones and with bones. Where the distance that was left is more than the two can
  /// have come closer, nothing of them is looked at.
  void look_at_first(std::size_t t, Chunk& chunk) {
    const Triangle& triangle = m_mesh.triangles[t];
    for (std::size_t b = 0; b < m_bones.size(); ++b) {
      BoneSurface& bone = m_bones[b];
      look_up(
          bone.pairs, t, 0, bone.tree, grown(swept_box(triangle, bone.start, bone.end)), chunk,
          [&](std::size_t) { return std::pair(TriangleMotion(), TriangleMotion()); },
          [&](std::size_t other, const auto& visit) { for_each_with_bone(t, b, other, visit); });
    }
    look_up(
        m_pairs, t, m_tree.place_of(t) + 1, m_tree, grown(swept_box(triangle, m_safe, m_relative)), chunk,
        [&](std::size_t other) { return std::pair(m_pairs.last[other], m_pairs.now[other]); },
        [&](std::size_t other, const auto& visit) { for_each_with_muscle(t, other, visit); });
  }

  /// With triangles of a tree from `first_place` on. `motion_of(other)`: in the last substep and in this.
  /// `for_each(other, visit)`: the stencils of the pair.
  template <typename MotionOf, typename ForEach>
  void look_up(PairsWithTree& pairs, std::size_t t, std::size_t first_place, const BoxTree& tree,
               const Eigen::AlignedBox3d& box, Chunk& chunk, const MotionOf& motion_of, const ForEach& for_each) {
    std::vector<KnownPair>& known = pairs.known[t];
    auto before = known.begin();
    chunk.known.clear();
    tree.for_each_in(box, first_place, [&](std::size_t other, std::size_t place) {
      while (before != known.end() && before->place < place) ++before;
      const auto [last, now] = motion_of(other);
      const double enough_m = approach_m(pairs.now[t], now) + least_share * m_gap_m;
      double left_m = 0;
      if (before != known.end() && before->place == place) left_m = before->left_m - approach_m(pairs.last[t], last);
      if (!(left_m > enough_m)) {
        left_m = anywhere_m;
        for_each(other, [&](const PassageStencil& stencil) {
          left_m = std::min(left_m, gap_of(stencil.kind, starts_of(stencil)).distance_m);
        });
        if (!(left_m > enough_m)) {
          for_each(other, [&](const PassageStencil& stencil) { follow(stencil, chunk.hits); });
        }
      }
      chunk.known.push_back({place, left_m});
    });
    known.assign(chunk.known.begin(), chunk.known.end());
  }

  [[nodiscard]] Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& box) const {
    const Vec3 by = Vec3::Constant(least_share * m_gap_m);
    return {box.min() - by, box.max() + by};
  }

  template <typename Visit>
  void for_each_with_bone(std::size_t t, std::size_t b, std::size_t other, const Visit& visit) const {
    const BoneSurface& bone = m_bones[b];
    for_each_stencil(m_features.of[t], m_mesh.triangles[t], bone.features.of[other], bone.mesh.triangles[other],
                     [&](StencilKind kind, bool first_is_mine, const std::array<int, 4>& corners) {
                       visit({kind, static_cast<int>(b), !first_is_mine, corners});
                     });
  }

  template <typename Visit>
  void for_each_with_muscle(std::size_t t, std::size_t other, const Visit& visit) const {
    for_each_stencil(m_features.of[t], m_mesh.triangles[t], m_features.of[other], m_mesh.triangles[other],
                     [&](StencilKind kind, bool, const std::array<int, 4>& corners) {
                       if (!share_a_vertex(corners, kind)) visit({kind, -1, false, corners});
                     });
  }

  /// Pairs of a triangle whose path has changed.
  void look_at_again(std::size_t t, std::vector<Hit>& hits) const {
    const Triangle& triangle = m_mesh.triangles[t];
    const auto follow_it = [&](const PassageStencil& stencil) { follow(stencil, hits); };
    for (std::size_t b = 0; b < m_bones.size(); ++b) {
      const BoneSurface& bone = m_bones[b];
      bone.tree.for_each_in(grown(swept_box(triangle, bone.start, bone.end)), 0,
                            [&](std::size_t other, std::size_t) { for_each_with_bone(t, b, other, follow_it); });
    }
    m_tree.for_each_in(grown(swept_box(triangle, m_safe, m_relative)), 0, [&](std::size_t other, std::size_t) {
      if (other == t || (other < t && is_moved(other))) return;
      for_each_with_muscle(t, other, follow_it);
    });
  }

  void follow(const PassageStencil& stencil, std::vector<Hit>& hits) const {
    const auto [start, end] = paths_of(stencil);
    if (are_paths_apart(stencil.kind, start, end, least_share * m_gap_m)) return;
    if (is_exempt(stencil)) return;
    const StencilGap before = gap_of(stencil.kind, start);
    const double distance_m = before.distance_m;
    Hit hit{stencil, before.weights, {}, start, m_gap_m};
    if (distance_m < touching_m()) {
      if (!comes_in(stencil, before.weights, start, end, hit.normal)) return;
    } else {
      const double share = safe_share(stencil.kind, start, end, least_share * std::min(m_gap_m, distance_m));
      if (!(share < 1)) return;
      for (std::size_t k = 0; k < 4; ++k) hit.at[k] = start[k] + share * (end[k] - start[k]);
      const StencilGap gap = gap_of(stencil.kind, hit.at);
      hit.weights = gap.weights;
      hit.normal = gap.apart.stableNormalized();
    }
    if (stencil.bone < 0) {
      // Neighbours in the mesh may be closer by nature.
      StencilCorners rest;
      for (std::size_t k = 0; k < 4; ++k) rest[k] = m_mesh.vertices[at_index(stencil.corners[k])];
      const double rest_m = gap_of(stencil.kind, rest).distance_m;
      if (body_of(m_bodies, stencil.corners[0]) == body_of(m_bodies, stencil.corners[3])) {
        hit.target_m = std::min(m_gap_m, std::max(distance_m, 0.5 * rest_m));
      }
    }
    hits.push_back(hit);
  }

  /// Whether features that touch end in each other, where their surfaces face each other; and the normal that they
  /// have then.
  [[nodiscard]] bool comes_in(const PassageStencil& stencil, const std::array<double, 4>& weights,
                              const StencilCorners& start, const StencilCorners& end, Vec3& normal) const {
    const bool is_node = stencil.kind == StencilKind::node_face;
    Vec3 of_first = normal_of(stencil, 0);
    Vec3 of_second = area_normal({start[1], start[2], start[3]});
    normal = of_second;
    if (!is_node) {
      // Where an edge touches with an end, its node does.
      if (std::abs(*std::ranges::min_element(weights, {}, [](double w) { return std::abs(w); })) < on_border)
        return false;
      of_first += normal_of(stencil, 1);
      of_second = normal_of(stencil, 2) + normal_of(stencil, 3);
      const Vec3 first = (start[1] - start[0]).stableNormalized();
      normal = first.cross((start[3] - start[2]).stableNormalized());
      if (normal.norm() < least_angle) return false;
      if (normal.dot(of_second - of_first) < 0) normal = -normal;
    }
    normal = normal.stableNormalized();
    // On a ridge both faces are steep, and their edge looks to the node.
    if (is_node && normal.dot(of_first) > -least_facing) {
      normal = Vec3::Zero();
      for (std::size_t k = 1; k < 4; ++k) normal -= weights[k] * normal_of(stencil, k);
      of_second = normal = normal.stableNormalized();
    }
    if (!(normal.dot(of_first.stableNormalized()) < -least_facing)) return false;
    if (!(normal.dot(of_second.stableNormalized()) > least_facing)) return false;
    Vec3 apart = Vec3::Zero();
    for (std::size_t k = 0; k < 4; ++k) apart += weights[k] * end[k];
    return normal.dot(apart) < least_share * m_gap_m;
  }

  /// Of a corner's surface, where the paths start and in their frame.
  [[nodiscard]] Vec3 normal_of(const PassageStencil& stencil, std::size_t corner) const {
    const std::size_t vertex = at_index(stencil.corners[corner]);
    if (stencil.bone < 0) return m_normals[vertex];
    const BoneSurface& bone = m_bones[at_index(stencil.bone)];
    return stencil.is_of_bone(corner) ? bone.normals[vertex] : Vec3(bone.to_rest * m_normals[vertex]);
  }

  [[nodiscard]] double touching_m() const { return touching_share * m_gap_m; }

  void add_row(const Hit& hit, const ContactStageInput& input) {
    if (hit.normal.isZero()) return;
    const Vec3& normal = hit.normal;
    ContactRow row{.normal = normal,
                   .offset_m = hit.target_m,
                   .start_normal = normal,
                   .start_offset_m = hit.target_m,
                   .steps = row_steps};
    const PassageStencil& stencil = hit.stencil;
    Vec3 on_bone = Vec3::Zero();  // minus the bone's point, or the point itself, by the side that it is on
    for (std::size_t k = 0; k < 4; ++k) {
      if (stencil.is_of_bone(k)) {
        on_bone += hit.weights[k] * hit.at[k];
      } else {
        row.nodes[k] = stencil.corners[k];
        row.weights[k] = hit.weights[k];
      }
    }
    if (stencil.bone >= 0) {
      const RigidMotion& pose = input.bone_poses[at_index(stencil.bone)];
      const RigidMotion& previous = input.previous_bone_poses[at_index(stencil.bone)];
      const double side = stencil.bone_is_first ? -1 : 1;  // so that the weights of the muscle's side are positive
      const Vec3 point = -side * on_bone;
      for (double& weight : row.weights) weight *= side;
      row.normal = side * pose.apply_to_direction(normal);
      row.start_normal = side * previous.apply_to_direction(normal);
      row.offset_m += row.normal.dot(pose.apply(point));
      row.start_offset_m += row.start_normal.dot(previous.apply(point));
      row.carried_m = pose.apply(point) - previous.apply(point);
    }
    const auto [known, is_new] = m_row_of.try_emplace(stencil, m_rows.size());
    if (is_new) {
      m_rows.push_back(row);
    } else {
      m_rows[known->second] = row;
    }
  }

  void look_again_at(const PassageStencil& stencil) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (!stencil.is_of_bone(k)) m_is_moved[at_index(stencil.corners[k])] = 1;
    }
  }

  /// Joins what still comes too close, with all that this brings too close in turn.
  void move_in_zones(const ContactStageInput& input) {
    const std::size_t nodes = m_safe.size();
    m_zones.reset(nodes + m_bones.size());
    const std::vector<Vec3> wanted = m_proposed;
    std::vector<char> is_in(nodes, 0);
    for (std::size_t round = 0; round < nodes && !m_hits.empty(); ++round) {
      bool has_grown = false;
      for (const Hit& hit : m_hits) has_grown = join(hit.stencil, is_in) || has_grown;
      if (!has_grown) return;  // bones alone bring these together
      place_zones(input, wanted, is_in);
      find_hits(input);
    }
  }

  /// Whether that is news.
  bool join(const PassageStencil& stencil, std::vector<char>& is_in) {
    const auto nodes = static_cast<int>(m_safe.size());
    bool is_news = false;
    int first = -1;
    const auto add = [&](int item) {
      if (first >= 0 && m_zones.find(first) != m_zones.find(item)) {
        m_zones.join(first, item);
        is_news = true;
      }
      first = item;
    };
    if (stencil.bone >= 0) add(nodes + stencil.bone);
    for (std::size_t k = 0; k < 4; ++k) {
      if (stencil.is_of_bone(k)) continue;
      const int node = stencil.corners[k];
      if (std::exchange(is_in[at_index(node)], 1) == 0) {
        is_news = true;
        if (m_carriers[at_index(node)] >= 0) add(nodes + m_carriers[at_index(node)]);
      }
      add(node);
    }
    return is_news;
  }

  void place_zones(const ContactStageInput& input, std::span<const Vec3> wanted, std::span<const char> is_in) {
    const std::size_t nodes = m_safe.size();
    std::vector<int> bone_of(nodes + m_bones.size(), -1);
    for (std::size_t b = 0; b < m_bones.size(); ++b) {
      int& bone = bone_of[at_index(m_zones.find(static_cast<int>(nodes + b)))];
      if (bone < 0) bone = static_cast<int>(b);
    }
    std::vector<Vec3> moments(nodes + m_bones.size(), Vec3::Zero());
    std::vector<double> masses(nodes + m_bones.size(), 0);
    for (std::size_t node = 0; node < nodes; ++node) {
      if (is_in[node] == 0 || !(m_inverse_masses[node] > 0)) continue;
      const std::size_t zone = at_index(m_zones.find(static_cast<int>(node)));
      moments[zone] += (wanted[node] - m_safe[node]) / m_inverse_masses[node];
      masses[zone] += 1 / m_inverse_masses[node];
    }
    std::ranges::fill(m_is_moved, 0);
    for (std::size_t node = 0; node < nodes; ++node) {
      if (is_in[node] == 0 || !(m_inverse_masses[node] > 0)) continue;
      const std::size_t zone = at_index(m_zones.find(static_cast<int>(node)));
      const int bone = bone_of[zone];
      const Vec3 placed = bone >= 0 ? input.bone_poses[at_index(bone)].apply(
                                          input.previous_bone_poses[at_index(bone)].apply_inverse(m_safe[node]))
                                    : Vec3(m_safe[node] + moments[zone] / masses[zone]);
      m_is_moved[node] = 1;
      m_proposed[node] = placed;
    }
  }

  const TriangleMesh& m_mesh;  ///< of all muscles, at rest
  std::vector<Body> m_bodies;
  double m_gap_m;
  int m_rounds;
  int m_threads;
  std::vector<double> m_inverse_masses;
  std::vector<int> m_carriers;  ///< by node: the bone that it is bound to, or -1
  OwnedFeatures m_features;
  std::vector<std::size_t> m_body_of;  ///< by triangle
  std::vector<BoneSurface> m_bones;
  BoxTree m_tree;  ///< of paths of triangles, without what all nodes move alike
  ContactRowSolver m_solver;
  // Positions of all nodes, world frame.
  std::vector<Vec3> m_safe;      ///< where the last substep ended
  std::vector<Vec3> m_proposed;  ///< where this one is to end
  std::vector<Vec3> m_relative;  ///< the same without m_common
  Vec3 m_common = Vec3::Zero();
  std::vector<Vec3> m_normals;   ///< by node, of m_safe
  std::vector<char> m_is_moved;  ///< by node: its path is not the one that was last looked at
  PairsWithTree m_pairs;
  std::vector<Chunk> m_chunks;
  std::vector<Hit> m_hits;
  std::vector<ContactRow> m_rows;
  std::map<PassageStencil, std::size_t> m_row_of;
  JoinedSets m_zones;
  std::vector<int> m_changed;
  int m_hit_count = 0;
  // By collider (bones, then muscles) and node.
  std::vector<char> m_is_left_out;
  std::vector<char> m_still_left_out;
  bool m_are_left_out = false;
  bool m_is_first = true;
};

}  // namespace

std::unique_ptr<ContactStage> make_no_passage(const StageInput& input, const Parameters& parameters) {
  return std::make_unique<NoPassage>(input, parameters.number("gap_m"), static_cast<int>(parameters.integer("rounds")));
}

std::vector<ParameterSpec> no_passage_parameters() {
  return {parameter::number({.name = "gap_m",
                             .unit = "m",
                             .default_value = 1e-4,
                             .minimum = 1e-9,
                             .maximum = 0.1,
                             .help = "distance that surfaces are brought back to where they came too close"}),
          parameter::integer({.name = "rounds",
                              .default_value = 8,
                              .minimum = 1,
                              .maximum = 1000,
                              .help = "times that paths are corrected as contacts before what is left moves as one"})};
}

}  // namespace musclebench

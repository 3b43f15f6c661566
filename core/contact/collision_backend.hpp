#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/scoped_timer.hpp"
#include "core/contact/bone.hpp"
#include "core/contact/contact.hpp"
#include "core/contact/reach_watch.hpp"
#include "core/contact/structure_origin.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// What a backend can do. The response and the contract tests rely on it.
struct Capabilities {
  /// Contacts carry depth and normal.
  bool depth = true;
  /// `detect` accepts a subset of the nodes, at any positions. False: it needs the whole muscle surface.
  bool point_queries = true;
  /// The backend finds contacts. False only for the loop without collision.
  bool finds_contacts = true;
  /// State from the previous step makes the next detection cheaper.
  bool has_cache = false;
  /// After `build`, `step_m` is positive. The response `backtrack` needs it.
  bool has_step = false;
  /// After two frames of a run, detections allocate no heap memory.
  bool steady_memory = false;
  /// A detection measures its time for each muscle and bone (`pair_times`).
  bool times_pairs = false;
};

/// An upper bound of the error of a backend's answers, in metres. Nodes closer to a surface than `touching_distance_m`
/// do not count, for exact backends either.
struct AnswerBound {
  double missed_depth_m = 0;    ///< every node that is inside a bone and deeper than this is reported
  double false_distance_m = 0;  ///< no node that is outside and farther from the surface than this is reported
  /// A depth changes by at most this, plus the rounding of coordinates, if the whole scene is moved or scaled. Stored
  /// values are then rounded differently, or a grid lies differently.
  double storage_m = 0;
};

/// The error of an approximate structure over one bone: its difference from the exact distance at sampled points near
/// the bone's surface.
struct StructureError {
  std::string bone;
  std::size_t bytes = 0;  ///< of the structure
  int samples = 0;
  double largest_m = 0;  ///< largest error
  double p99_m = 0;      ///< 99th percentile of the errors
};

/// A collision backend (a way to detect collisions) finds the muscle nodes that are inside rigid bones. Derive from it
/// and override the `do_` functions. If each node can be answered alone, derive from BoneStructure instead.
///
/// The order of calls is: `build` once, then `update` and any number of `detect` in each iteration. All positions are
/// in the world frame, in metres. One virtual call answers a batch of nodes. All calls come from one thread. A call may
/// use `threads` threads, but the result must not depend on their number.
class CollisionBackend {
 public:
  CollisionBackend() = default;
  CollisionBackend(const CollisionBackend&) = delete;
  CollisionBackend& operator=(const CollisionBackend&) = delete;
  virtual ~CollisionBackend() = default;

  [[nodiscard]] virtual Capabilities capabilities() const = 0;

  /// The error bound for `bone`, after `build`. The contract tests check it.
  [[nodiscard]] virtual AnswerBound answer_bound(int bone) const = 0;

  /// Memory of the structures that `build` made, without the input meshes. Count it from sizes, so that it is the same
  /// in every run.
  [[nodiscard]] virtual std::size_t structure_bytes() const = 0;

  /// Whether `build` computed the structures or read them from files.
  [[nodiscard]] virtual StructureOrigin structure_origin() const { return {}; }

  /// The measured errors of approximate structures, one for each bone. Empty for exact backends.
  [[nodiscard]] virtual std::vector<StructureError> structure_errors() const { return {}; }

  /// Sets a function that a long `build` calls from time to time, in its thread. `share` is the part done, 0 to 1.
  void report_build_to(std::function<void(double share)> report) { m_report_build = std::move(report); }

  /// The step of the response `backtrack` out of `bone`: the smallest edge of a cell, in metres. 0 without cells.
  [[nodiscard]] virtual double step_m(int /*bone*/) const { return 0; }

  /// How far outside the box of a closed bone a contact can be, in metres. The distance is from the node, or from the
  /// muscle triangle if the backend collides surfaces. It is called before `build`. Infinite means unknown: the bone is
  /// then never pruned.
  [[nodiscard]] virtual double contact_reach_m(const Bone& /*bone*/) const {
    return std::numeric_limits<double>::infinity();
  }

  /// Call it before `build`. `boxes` has one box for each bone, in its rest frame: where nodes are expected during the
  /// whole run. An unbounded box means anywhere. If the box is empty and the backend knows `contact_reach_m`, it builds
  /// nothing over that bone. A grid may cover only the box. If a node comes elsewhere, that detection builds what is
  /// missing. So the boxes never change the contacts.
  virtual void expect_within(std::vector<Eigen::AlignedBox3d> boxes);
  /// For each bone, whether no node is expected near it. Empty if `expect_within` was not called.
  [[nodiscard]] std::span<const char> untouched() const { return m_untouched; }
  /// The bones whose structures were left out or incomplete after `build`, including those completed later.
  [[nodiscard]] virtual std::vector<PrunedBone> pruned_bones() const {
    return {m_watch.bones().begin(), m_watch.bones().end()};
  }

  /// Sets the muscles whose times are reported separately, in the order of their nodes. Call it before `build`. It does
  /// not change contacts.
  void tell_apart(std::vector<Body> muscles) { m_muscles = std::move(muscles); }
  /// The times of the last detection for each bone and muscle: first all muscles of bone 0, then those of bone 1, and
  /// so on. They are summed over threads. Work for all pairs together, such as a sweep of the clearance cache, is not
  /// included. Empty if `tell_apart` was not called, or if the backend lacks `times_pairs`.
  [[nodiscard]] std::span<const Nanoseconds> pair_times() const { return m_pair_ns; }

  /// Builds the structures over `bones` in rest pose. `muscle` is the muscle surface at rest, for backends that collide
  /// surfaces. Both must outlive the backend. Throws InputError if the parameters do not fit the bones.
  void build(std::span<const Bone> bones, const TriangleMesh& muscle, int threads);

  /// Sets the bone poses (one for each bone) and node positions (one for each muscle vertex) of this iteration.
  void update(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions);

  /// Finds the contacts of `nodes`, which are ascending indices into `positions`. Overwrites `contacts` with them,
  /// ordered by bone and then by node. A backend without `point_queries` requires the positions of the last `update`.
  void detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts);

 protected:
  [[nodiscard]] std::span<const Bone> bones() const { return m_bones; }
  [[nodiscard]] const TriangleMesh& muscle() const { return *m_muscle; }
  [[nodiscard]] std::span<const RigidMotion> poses() const { return m_poses; }
  [[nodiscard]] int threads() const { return m_threads; }
  /// Muscles whose times are reported separately. Empty: all nodes count as one muscle.
  [[nodiscard]] std::span<const Body> muscles() const { return m_muscles; }
  /// Adds to `pair_times`. `do_detect` of a backend with `times_pairs` calls it if `muscles()` is not empty.
  void add_pair_time(std::size_t bone, std::size_t muscle, Nanoseconds ns) {
    m_pair_ns[bone * m_muscles.size() + muscle] += ns;
  }
  /// The function of `report_build_to`. May be empty.
  [[nodiscard]] const std::function<void(double share)>& build_report() const { return m_report_build; }
  /// Whether `do_build` must leave the bone out, and `do_detect` must skip it.
  [[nodiscard]] bool is_pruned(std::size_t bone) const { return m_watch.watches(static_cast<int>(bone)); }
  /// The box in which nodes are expected, in the rest frame of `bone`.
  [[nodiscard]] Eigen::AlignedBox3d expected_box(std::size_t bone) const {
    return m_expected.empty() ? unbounded_box() : m_expected[bone];
  }

 private:
  /// Builds over `bones()`, except those that `is_pruned` names.
  virtual void do_build() = 0;
  /// Builds over a bone that `do_build` left out. `is_pruned` is already false for it.
  virtual void do_bring_back(std::size_t /*bone*/) { do_build(); }
  /// Follows new positions. Backends that query in the rest frame of the bones need not override it.
  virtual void do_update(std::span<const Vec3> /*positions*/) {}
  /// Appends to `contacts`, which is empty, in the order that `detect` promises.
  virtual void do_detect(std::span<const Vec3> positions, std::span<const int> nodes,
                         std::vector<Contact>& contacts) = 0;

  void start_watch();
  /// Builds over these bones and stops watching them.
  void bring_back(std::span<const int> bones);

  std::span<const Bone> m_bones;
  const TriangleMesh* m_muscle = nullptr;
  std::vector<RigidMotion> m_poses;
  int m_threads = 1;
  std::function<void(double share)> m_report_build;
  std::vector<Eigen::AlignedBox3d> m_expected;  ///< by bone; empty: anywhere
  std::vector<char> m_untouched;
  ReachWatch m_watch;
  std::vector<Body> m_muscles;
  std::vector<Nanoseconds> m_pair_ns;
};

}  // namespace musclebench

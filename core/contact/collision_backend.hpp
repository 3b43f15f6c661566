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

/// What a backend can do, and what the contract tests and the response may expect of it.
struct Capabilities {
  /// Contacts carry depth and normal.
  bool depth = true;
  /// `detect` accepts a subset of the nodes, at any positions (false: it needs the whole muscle surface).
  bool point_queries = true;
  /// Contacts are found at all: false is the loop without collision.
  bool finds_contacts = true;
  /// State of the detection of the step before makes the next one cheaper.
  bool has_cache = false;
  /// Once built, `step_m` is positive: the step of the backtracking response.
  bool has_step = false;
  /// After two frames of a run a detection asks for no heap memory any more.
  bool steady_memory = false;
  /// Of muscles that are told apart, a detection says how long each took with each bone.
  bool times_pairs = false;
};

/// How far a backend's answer may be from the truth. A node closer to a surface than `touching_distance_m` is on it,
/// for exact backends, too. A node inside a bone and deeper than `missed_depth_m` is reported; a node outside and
/// farther than `false_distance_m` from the surface is not. A depth changes by at most `storage_m`, besides the
/// rounding of coordinates, where everything is moved or given in another unit: what is stored is rounded, or laid out
/// otherwise.
struct AnswerBound {
  double missed_depth_m = 0;
  double false_distance_m = 0;
  double storage_m = 0;
};

/// How far the structure over one bone is from the exact distance, at sampled points near the bone's surface.
struct StructureError {
  std::string bone;
  std::size_t bytes = 0;
  int samples = 0;
  double largest_m = 0;
  double p99_m = 0;
};

/// A collision backend: finds the nodes of one muscle surface that lie inside rigid bones.
///
/// Calls come in this order: `build` once; then for every iteration `update` and `detect`, `detect` any number of
/// times. All positions are in the world frame, in metres. One virtual call answers for a batch of nodes. A backend is
/// built, measured and destroyed in one thread; inside a call it may use `threads` threads, with the same result for
/// any number.
class CollisionBackend {
 public:
  CollisionBackend() = default;
  CollisionBackend(const CollisionBackend&) = delete;
  CollisionBackend& operator=(const CollisionBackend&) = delete;
  virtual ~CollisionBackend() = default;

  [[nodiscard]] virtual Capabilities capabilities() const = 0;

  /// What the backend, once built, declares for `bone`; the contract tests hold it to this.
  [[nodiscard]] virtual AnswerBound answer_bound(int bone) const = 0;

  /// Bytes of the structures made by `build`, counted from their sizes (deterministic), without the input meshes.
  [[nodiscard]] virtual std::size_t structure_bytes() const = 0;

  /// Whether `build` found the structures in files instead of computing them.
  [[nodiscard]] virtual StructureOrigin structure_origin() const { return {}; }

  /// Errors that a backend that approximates has measured when it built its structures, a bone each; empty for others.
  [[nodiscard]] virtual std::vector<StructureError> structure_errors() const { return {}; }

  /// Called now and then during a long `build`, in its thread, with the share that is done.
  void report_build_to(std::function<void(double share)> report) { m_report_build = std::move(report); }

  /// Step of the backtracking response out of `bone`: the smallest edge of a cell. 0 for a backend without cells.
  [[nodiscard]] virtual double step_m(int /*bone*/) const { return 0; }

  /// How far from the box of the bone's vertices, in rest pose, a contact may lie: of a backend that collides surfaces
  /// the triangle that meets the bone, else the node. Asked before `build`, of closed bones. Infinite where that is not
  /// known: then the bone is never pruned.
  [[nodiscard]] virtual double contact_reach_m(const Bone& /*bone*/) const {
    return std::numeric_limits<double>::infinity();
  }

  /// Before `build`: by bone, the box in its rest frame in which nodes are expected at any time; unbounded: anywhere.
  /// Nothing is built over a bone whose box is empty where the backend knows how far its contacts reach, and of a grid
  /// only the part in the box may be; until a node comes elsewhere: then what is lacking is built within that
  /// detection. So the contacts are the same, whatever was expected.
  virtual void expect_within(std::vector<Eigen::AlignedBox3d> boxes);
  /// By bone, whether no node is expected to come near it; empty: nothing was said.
  [[nodiscard]] std::span<const char> untouched() const { return m_untouched; }
  /// Bones over which nothing, or only a part, was built at first; those that were completed, too.
  [[nodiscard]] virtual std::vector<PrunedBone> pruned_bones() const {
    return {m_watch.bones().begin(), m_watch.bones().end()};
  }

  /// Before `build`: the muscles whose times are told apart, in the order of their nodes. They change no contact.
  void tell_apart(std::vector<Body> muscles) { m_muscles = std::move(muscles); }
  /// Of the last detection, where muscles are told apart and the backend `times_pairs`: the time that each muscle's
  /// nodes took with each bone, by bone and then by muscle, summed over threads; else empty. What serves all pairs,
  /// such as the sweep of a clearance cache, is in none.
  [[nodiscard]] std::span<const Nanoseconds> pair_times() const { return m_pair_ns; }

  /// Builds the structures over `bones` in rest pose. `muscle` is the muscle's surface at rest, for backends that
  /// collide surfaces. Both outlive the backend. Throws InputError when the parameters do not fit the bones.
  void build(std::span<const Bone> bones, const TriangleMesh& muscle, int threads);

  /// Tells this iteration's bone poses and node positions (one a vertex of the muscle).
  void update(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions);

  /// Finds the contacts of `nodes` (ascending indices into `positions`), into `contacts`, which is overwritten: ordered
  /// by bone, then by node. A backend without `point_queries` may only be called with the positions of the last
  /// `update`.
  void detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts);

 protected:
  [[nodiscard]] std::span<const Bone> bones() const { return m_bones; }
  [[nodiscard]] const TriangleMesh& muscle() const { return *m_muscle; }
  [[nodiscard]] std::span<const RigidMotion> poses() const { return m_poses; }
  [[nodiscard]] int threads() const { return m_threads; }
  /// Those that are told apart; none: all nodes are one's.
  [[nodiscard]] std::span<const Body> muscles() const { return m_muscles; }
  /// Called by `do_detect` of a backend that `times_pairs`, as often as it likes, where muscles are told apart.
  void add_pair_time(std::size_t bone, std::size_t muscle, Nanoseconds ns) {
    m_pair_ns[bone * m_muscles.size() + muscle] += ns;
  }
  /// May be empty.
  [[nodiscard]] const std::function<void(double share)>& build_report() const { return m_report_build; }
  /// Whether `do_build` leaves the bone out, and `do_detect` does not ask about it.
  [[nodiscard]] bool is_pruned(std::size_t bone) const { return m_watch.watches(static_cast<int>(bone)); }
  /// Where nodes are expected, in the rest frame of `bone`.
  [[nodiscard]] Eigen::AlignedBox3d expected_box(std::size_t bone) const {
    return m_expected.empty() ? unbounded_box() : m_expected[bone];
  }

 private:
  virtual void do_build() = 0;
  /// Of a bone that `do_build` has left out; `is_pruned` no longer holds.
  virtual void do_bring_back(std::size_t /*bone*/) { do_build(); }
  /// Backends that query in the bones' rest frame have nothing to do here.
  virtual void do_update(std::span<const Vec3> /*positions*/) {}
  /// Appends to `contacts`, which is empty.
  virtual void do_detect(std::span<const Vec3> positions, std::span<const int> nodes,
                         std::vector<Contact>& contacts) = 0;

  void start_watch();
  /// Brings back the bones.
  void bring_back(std::span<const int> bones);

  std::span<const Bone> m_bones;
  const TriangleMesh* m_muscle = nullptr;
  std::vector<RigidMotion> m_poses;
  int m_threads = 1;
  std::function<void(double share)> m_report_build;
  std::vector<Eigen::AlignedBox3d> m_expected;  ///< by bone; none: anywhere
  std::vector<char> m_untouched;
  ReachWatch m_watch;
  std::vector<Body> m_muscles;
  std::vector<Nanoseconds> m_pair_ns;
};

}  // namespace musclebench

#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/scoped_timer.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/contact/response.hpp"
#include "core/pbd/contact_stage.hpp"
#include "core/pbd/effect.hpp"
#include "core/pbd/frame_impulses.hpp"
#include "core/pbd/lost_nodes.hpp"
#include "core/pbd/node_order.hpp"
#include "core/pbd/node_rows.hpp"
#include "core/pbd/particles.hpp"
#include "core/pbd/start_overlap.hpp"
#include "core/pbd/team.hpp"

namespace musclebench {

/// A change of the time step at the first substep of a frame. It holds until the next change.
struct TimeStepChange {
  int from_frame;  ///< 1 is the first frame
  double time_step_s;
};

/// The settings of the simulation loop. A frame has `substeps` substeps. A substep is one prediction, `iterations`
/// passes over the constraints, each followed by detection and response, and one velocity update.
struct LoopParameters {
  int frames = 1;
  int rest_frames = 0;  ///< number of last frames in which bones stand still at the end of their motion
  /// Number of substeps before the first frame. Bones stand still, and no velocity is passed on. They move nodes out of
  /// bones and other muscles that they overlap in the meshes, without throwing them. Macklin et al. 2014, section 4.4,
  /// correct positions before a step in the same way.
  int settle_substeps = 0;
  /// How fast nodes are moved out of bones, margins or other muscles that they overlap at the start of the run. They
  /// gain no speed. 0: at once, and bones throw the nodes out, as in the paper.
  double depenetration_m_per_s = 0;
  int substeps = 1;
  int iterations = 1;
  double time_step_s = 1e-3;       ///< duration of a substep, until `time_step_changes` changes it
  double node_mass_kg = 1;         ///< mass of each node, unless a density is given
  double density_kg_per_m3 = 0;    ///< density of the muscle, whose nodes share its mass evenly; 0: use node_mass_kg
  double start_noise_m = 0;        ///< largest random displacement of free nodes along each axis at the start
  bool interpolate_poses = false;  ///< false: bones jump to the frame's pose in its first substep, as in the paper
  std::vector<TimeStepChange> time_step_changes = {};  ///< ascending by frame

  /// Duration of a substep of this frame.
  [[nodiscard]] double time_step_of_s(int frame) const;
  /// Simulated time from the start of the run to the end of a substep. The first substep of a frame is 1.
  [[nodiscard]] double time_s(int frame, int substep) const;
};

/// The wall time of each part of one frame.
struct StageTimes {
  std::vector<Nanoseconds> effects_ns;  ///< in the order of the simulation's effects
  std::vector<Nanoseconds> stages_ns;   ///< in the order of its contact stages
  /// Detection for each bone and muscle, as in CollisionBackend::pair_times.
  std::vector<Nanoseconds> pairs_ns;
  Nanoseconds predict_ns = 0;
  Nanoseconds update_ns = 0;
  Nanoseconds detect_ns = 0;
  Nanoseconds respond_ns = 0;
  Nanoseconds finish_ns = 0;
  Nanoseconds frame_ns = 0;      ///< the whole frame without the observer
  Nanoseconds recording_ns = 0;  ///< the observer

  /// Time of the collision backend and the response.
  [[nodiscard]] Nanoseconds collision_ns() const { return update_ns + detect_ns + respond_ns; }
};

/// The input of one collision step of the loop. Positions are in the world frame, in metres, by node.
struct CollisionStep {
  std::span<const Vec3> substep_start;               ///< x
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const Vec3> positions;                   ///< p, at which the backend detects contacts
  std::span<const RigidMotion> bone_poses;
  bool last_of_frame = false;
};

/// Observes the collision steps of the loop. Derive from it to record them. Its time counts as recording and not as
/// part of the frame. All calls come from one thread.
class CollisionObserver {
 public:
  CollisionObserver() = default;
  CollisionObserver(const CollisionObserver&) = delete;
  CollisionObserver& operator=(const CollisionObserver&) = delete;
  virtual ~CollisionObserver() = default;

  /// Called after the constraints, before any contact stage moves a node. `positions` is p.
  virtual void before_stages(std::span<const Vec3> /*positions*/) {}
  /// Called before the backend detects contacts.
  virtual void before_detection(const CollisionStep& step) = 0;
  /// Called with the same step, before the response moves any node.
  virtual void after_detection(const CollisionStep& step, std::span<const Contact> contacts) = 0;
};

/// An observer that copies the last detection of a frame. The Referee judges it.
class LastDetection final : public CollisionObserver {
 public:
  std::vector<Vec3> substep_start;
  std::vector<RigidMotion> previous_bone_poses;
  std::vector<Vec3> positions;
  std::vector<RigidMotion> bone_poses;
  std::vector<Contact> contacts;

  void before_detection(const CollisionStep& step) override;
  void after_detection(const CollisionStep& step, std::span<const Contact> detected) override;
};

/// A function that sets the poses of all bones at a time in frames. 0 is before the first frame, 1 is its end.
/// Fractions are allowed.
using PoseFunction = std::function<void(double frame_position, std::vector<RigidMotion>& poses)>;

/// A function that is called after each part of the loop that moves nodes, to find the cause of a fault. `mover` is the
/// name of an effect or a contact stage, or one of the two names below.
using MoverWatch = std::function<void(std::string_view mover)>;
/// The mover of the prediction.
inline constexpr std::string_view moved_by_velocity = "its own velocity";
/// The mover of the response.
inline constexpr std::string_view moved_by_response = "the response to contacts with bones";

/// The position-based dynamics loop (Mueller et al. 2007) that all backends share. It moves muscles among rigid moving
/// bones. Muscles collide with bones. Contact stages add everything else, such as contact between muscles.
///
/// Call it from one thread. To start: construct, `add_stage`, `settle`, then `step_frame` with 1, 2, and so on.
class Simulation {
 public:
  /// `backend` must have been built, and must outlive the simulation. Only free nodes (inverse mass above 0) are
  /// predicted and collide. `effects` must have been made for `order`. `threads` changes the time and no bit of the
  /// result.
  Simulation(const LoopParameters& loop, const Particles& particles, NodeOrder order,
             std::vector<std::unique_ptr<Effect>> effects, CollisionBackend& backend, Response response,
             PoseFunction poses, int threads = 1);

  /// Call it before the first frame. Stages run in the order in which they are added.
  void add_stage(std::unique_ptr<ContactStage> stage) { m_stages.push_back(std::move(stage)); }

  /// Runs `LoopParameters::settle_substeps`. Call it once, after the last `add_stage` and before the first frame.
  void settle();

  /// Runs frame `frame` (the first is 1). It allocates no memory unless the backend does. `observer`, if given, sees
  /// every collision step. The returned times are valid until the next frame. The frame ends early if a node is lost or
  /// if `stop_when` says so.
  const StageTimes& step_frame(int frame, CollisionObserver* observer = nullptr);

  /// Sets limits of motion from the next frame on. They are tested before each collision step, after each contact stage
  /// and at the end of the frame. So no backend searches for contacts of a node that left the scene.
  void limit_motion(const MotionLimits& limits) { m_lost.set_limits(limits); }
  /// The nodes that exceeded the limits.
  [[nodiscard]] const LostNodes& lost() const { return m_lost; }
  /// Sets a function that is called before each collision step. If it returns true, the frame ends.
  void stop_when(std::function<bool()> is_stopped) { m_asks_to_stop = std::move(is_stopped); }
  [[nodiscard]] bool was_stopped() const { return m_was_stopped; }
  /// The last substep that started. The first of a frame is 1.
  [[nodiscard]] int substep() const { return m_substep; }

  /// Records the impulses of effects and contacts from the next frame on. `muscles` are the bodies of the nodes. Call
  /// it before the first frame. Recording changes no bit of the motion; it takes time, which counts.
  void record_impulses(std::vector<Body> muscles);
  /// Those of the last frame; null without `record_impulses`.
  [[nodiscard]] const FrameImpulses* impulses() const { return m_impulses.get(); }

  /// Sets a function that is called after each part of each iteration. Do not use it when you measure times.
  void watch_movers(MoverWatch watch) { m_watch = std::move(watch); }
  /// The predicted position of the node so far in this substep, m, world frame.
  [[nodiscard]] Vec3 predicted(int node) const { return m_rows[m_order.row_of(node)].position(); }
  /// The displacement of the node since the start of the substep, m.
  [[nodiscard]] Vec3 move(int node) const;

  /// Positions of all nodes at the end of the last complete substep, m, world frame.
  [[nodiscard]] const std::vector<Vec3>& positions() const { return m_positions; }
  /// Velocities of all nodes, m/s.
  [[nodiscard]] std::vector<Vec3> velocities() const;
  [[nodiscard]] std::span<const RigidMotion> bone_poses() const { return m_poses; }
  /// The contacts with bones in the last step: those of the backend and those that stages added.
  [[nodiscard]] std::span<const Contact> contacts() const { return m_contacts; }
  [[nodiscard]] std::span<const int> free_nodes() const { return m_free_nodes; }
  [[nodiscard]] std::span<const std::unique_ptr<Effect>> effects() const { return m_effects; }
  [[nodiscard]] std::span<const std::unique_ptr<ContactStage>> stages() const { return m_stages; }

 private:
  void start_times();
  [[nodiscard]] bool has_ended() const { return m_was_stopped || m_lost.any(); }
  void step(const SubstepInput& input, bool last_of_frame, CollisionObserver* observer);
  void apply_forces(const SubstepInput& input, const Team& team);
  void predict(const SubstepInput& input, const Team& team);
  void project(const SubstepInput& input, const Team& team);
  using StageMoment = std::span<const int> (ContactStage::*)(const ContactStageInput&);
  void run_stages(StageMoment moment, std::span<const Contact> contacts);
  [[nodiscard]] ContactStageInput stage_input(std::span<const Contact> contacts) {
    return {m_positions, m_predicted, m_free_nodes,      m_previous_poses,
            m_poses,     contacts,    m_depenetration_m, m_impulses ? m_impulses->contacts() : nullptr};
  }
  void collide(bool last_of_frame, CollisionObserver* observer);
  void find_contacts();
  void respond();
  void record_force(std::size_t effect, double time_step_s, const Team& team);
  void look_at_positions(const Team& team);
  void look_at_moves(double time_step_s, const Team& team);
  void finish_substep(double time_step_s, const Team& team);
  void tell_watch(std::string_view mover, const Team& team) const;

  LoopParameters m_loop;
  NodeOrder m_order;
  std::vector<int> m_free_nodes;  ///< ascending
  // By node, for collision.
  std::vector<Vec3> m_positions;  ///< x, at the start of the substep
  std::vector<Vec3> m_predicted;  ///< p, corrected by constraints, then by contacts
  // By row, for everything else.
  NodeRows m_start;  ///< x
  NodeRows m_rows;   ///< p
  std::vector<NodeRow> m_velocities;
  std::vector<std::unique_ptr<Effect>> m_effects;
  std::vector<std::unique_ptr<ContactStage>> m_stages;
  CollisionBackend& m_backend;
  Response m_response;
  std::unique_ptr<FrameImpulses> m_impulses;
  PoseFunction m_pose_function;
  MoverWatch m_watch;
  LostNodes m_lost;
  StartOverlap m_start_overlap;
  /// Largest displacement of a node that overlapped at the start of the run, in the current collision step.
  double m_depenetration_m = std::numeric_limits<double>::infinity();
  std::function<bool()> m_asks_to_stop;
  bool m_was_stopped = false;
  int m_substep = 0;
  std::vector<RigidMotion> m_poses;
  std::vector<RigidMotion> m_previous_poses;
  std::vector<Contact> m_contacts;
  StageTimes m_times;
  int m_threads;
  Barrier m_barrier;
};

}  // namespace musclebench

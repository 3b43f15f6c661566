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
#include "core/pbd/lost_nodes.hpp"
#include "core/pbd/node_order.hpp"
#include "core/pbd/node_rows.hpp"
#include "core/pbd/particles.hpp"
#include "core/pbd/start_overlap.hpp"
#include "core/pbd/team.hpp"

namespace musclebench {

/// From the first substep of a frame on.
struct TimeStepChange {
  int from_frame;  ///< 1: the first
  double time_step_s;
};

/// How the shared loop runs. One frame is `substeps` substeps; one substep is one prediction, `iterations` passes over
/// the constraints, each followed by detection and response, and one velocity update.
struct LoopParameters {
  int frames = 1;
  int rest_frames = 0;  ///< of them the last ones, in which bones stand still where their motion ended
  /// Before the first frame, with bones standing still and no velocity taken over from one to the next: nodes that the
  /// meshes have inside a bone or another muscle are laid out of it and are not thrown (Macklin et al. 2014, section
  /// 4.4, correct positions in the same sense before a step).
  int settle_substeps = 0;
  /// How fast contacts lay out what overlaps bones, their margin or other muscles when the run begins; it takes up no
  /// speed by that. 0: at once, and bones throw it out, as in the paper.
  double depenetration_m_per_s = 0;
  int substeps = 1;
  int iterations = 1;
  double time_step_s = 1e-3;       ///< of one substep, unless the frame is one of those below
  double node_mass_kg = 1;         ///< of every node, unless a density is given
  double density_kg_per_m3 = 0;    ///< of the muscle, whose mass its nodes share evenly; 0: use node_mass_kg
  double start_noise_m = 0;        ///< free nodes start displaced at random, by at most so much along each axis
  bool interpolate_poses = false;  ///< false: bones jump to the frame's pose in its first substep, as in the paper
  std::vector<TimeStepChange> time_step_changes = {};  ///< ascending by frame

  [[nodiscard]] double time_step_of_s(int frame) const;
  /// From the start of the run to the end of a substep (1: the first of the frame).
  [[nodiscard]] double time_s(int frame, int substep) const;
};

/// The time of each stage of one frame.
struct StageTimes {
  std::vector<Nanoseconds> effects_ns;  ///< in the order of the simulation's effects
  std::vector<Nanoseconds> stages_ns;   ///< in the order of its contact stages
  /// Detection by pair: see CollisionBackend::pair_times.
  std::vector<Nanoseconds> pairs_ns;
  Nanoseconds predict_ns = 0;
  Nanoseconds update_ns = 0;
  Nanoseconds detect_ns = 0;
  Nanoseconds respond_ns = 0;
  Nanoseconds finish_ns = 0;
  Nanoseconds frame_ns = 0;      ///< wall time of the frame's loop, without the recording
  Nanoseconds recording_ns = 0;  ///< taken by the observer

  [[nodiscard]] Nanoseconds collision_ns() const { return update_ns + detect_ns + respond_ns; }
};

/// Input of one collision step of the loop: world frame, metres.
struct CollisionStep {
  std::span<const Vec3> substep_start;               ///< x
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const Vec3> positions;                   ///< p, for which the backend detects contacts
  std::span<const RigidMotion> bone_poses;
  bool last_of_frame = false;
};

/// Observes the collision steps of the loop. Its time counts as recording, not as the frame's.
class CollisionObserver {
 public:
  CollisionObserver() = default;
  CollisionObserver(const CollisionObserver&) = delete;
  CollisionObserver& operator=(const CollisionObserver&) = delete;
  virtual ~CollisionObserver() = default;

  /// Before any contact stage has moved a node: p of the step, after the constraints.
  virtual void before_stages(std::span<const Vec3> /*positions*/) {}
  virtual void before_detection(const CollisionStep& step) = 0;
  /// The same step, before the response moves any node.
  virtual void after_detection(const CollisionStep& step, std::span<const Contact> contacts) = 0;
};

/// Keeps the last detection of a frame, which the Referee judges.
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

/// Poses of all bones at a time in frames: 0 before the first frame, 1 at its end, fractions between.
using PoseFunction = std::function<void(double frame_position, std::vector<RigidMotion>& poses)>;

/// Told the name of what has just moved the nodes of a `Simulation`, to find the cause of a fault: an effect, a contact
/// stage, or one of these.
using MoverWatch = std::function<void(std::string_view mover)>;
inline constexpr std::string_view moved_by_velocity = "its own velocity";
inline constexpr std::string_view moved_by_response = "the response to contacts with bones";

/// The shared position-based dynamics loop (Mueller et al. 2007): muscles, rigid moving bones, any backend. Muscles
/// collide with bones; contact stages do the rest, such as contact between muscles.
class Simulation {
 public:
  /// `backend` has been built and outlives the simulation. Only free nodes, those of an inverse mass above 0, are
  /// predicted and collide. `effects` were made for `order`. `threads` change the time, and no bit of the result.
  Simulation(const LoopParameters& loop, const Particles& particles, NodeOrder order,
             std::vector<std::unique_ptr<Effect>> effects, CollisionBackend& backend, Response response,
             PoseFunction poses, int threads = 1);

  /// Before the first frame. Stages run in the order that they are added in.
  void add_stage(std::unique_ptr<ContactStage> stage) { m_stages.push_back(std::move(stage)); }

  /// Runs `LoopParameters::settle_substeps`; once, before the first frame and after the last `add_stage`.
  void settle();

  /// Runs frame `frame` (1-based); allocates no memory unless the backend does. `observer`, if given, sees every
  /// collision step. The returned times are valid until the next frame.
  ///
  /// Ends before its last substep where a node is lost or it is stopped.
  const StageTimes& step_frame(int frame, CollisionObserver* observer = nullptr);

  /// From the next frame on. Compared before each collision step, so that nothing searches for contacts of what has
  /// left the scene, after each contact stage, and at the end of the frame.
  void limit_motion(const MotionLimits& limits) { m_lost.set_limits(limits); }
  [[nodiscard]] const LostNodes& lost() const { return m_lost; }
  /// Asked before each collision step whether the frame ends here.
  void stop_when(std::function<bool()> is_stopped) { m_asks_to_stop = std::move(is_stopped); }
  [[nodiscard]] bool was_stopped() const { return m_was_stopped; }
  /// The last one that was begun, 1-based.
  [[nodiscard]] int substep() const { return m_substep; }

  /// Called after each part of each iteration. Not while anything is timed.
  void watch_movers(MoverWatch watch) { m_watch = std::move(watch); }
  /// Where the parts so far have moved the node in this substep, m.
  [[nodiscard]] Vec3 predicted(int node) const { return m_rows[m_order.row_of(node)].position(); }
  /// How far that is from where the substep began, m.
  [[nodiscard]] Vec3 move(int node) const;

  /// Of all nodes, at the end of the last whole substep, m.
  [[nodiscard]] const std::vector<Vec3>& positions() const { return m_positions; }
  [[nodiscard]] std::vector<Vec3> velocities() const;
  [[nodiscard]] std::span<const RigidMotion> bone_poses() const { return m_poses; }
  /// The contacts with bones of the last step: the backend's, and those that stages added.
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
    return {m_positions, m_predicted, m_free_nodes, m_previous_poses, m_poses, contacts, m_depenetration_m};
  }
  void collide(bool last_of_frame, CollisionObserver* observer);
  void find_contacts();
  void respond();
  void look_at_positions(const Team& team);
  void look_at_moves(double time_step_s, const Team& team);
  void finish_substep(double time_step_s, const Team& team);
  void tell_watch(std::string_view mover, const Team& team) const;

  LoopParameters m_loop;
  NodeOrder m_order;
  std::vector<int> m_free_nodes;  ///< ascending
  // By node, for collision.
  std::vector<Vec3> m_positions;  ///< x: at the start of the substep
  std::vector<Vec3> m_predicted;  ///< p: corrected by constraints, then by contacts
  // By row, for all else.
  NodeRows m_start;  ///< x
  NodeRows m_rows;   ///< p
  std::vector<NodeRow> m_velocities;
  std::vector<std::unique_ptr<Effect>> m_effects;
  std::vector<std::unique_ptr<ContactStage>> m_stages;
  CollisionBackend& m_backend;
  Response m_response;
  PoseFunction m_pose_function;
  MoverWatch m_watch;
  LostNodes m_lost;
  StartOverlap m_start_overlap;
  /// Of what overlaps as the run begins, in the current collision step at most.
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

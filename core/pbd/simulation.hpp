#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/base/scoped_timer.hpp"
#include "core/contact/collision_backend.hpp"
#include "core/contact/response.hpp"
#include "core/pbd/effect.hpp"

namespace musclebench {

/// How the shared loop runs. One frame is `substeps` substeps; one substep is one prediction, `iterations` passes over
/// the constraints, each followed by detection and response, and one velocity update.
struct LoopParameters {
  int frames = 1;
  int substeps = 1;
  int iterations = 1;
  double time_step_s = 1e-3;       ///< of one substep
  double damping_per_s = 0;        ///< velocities decay as exp(-damping t)
  double node_mass_kg = 1;         ///< of every node, unless a density is given
  double density_kg_per_m3 = 0;    ///< of the muscle, whose mass its nodes share evenly; 0: use node_mass_kg
  bool interpolate_poses = false;  ///< false: bones jump to the frame's pose in its first substep, as in the paper
};

/// The time of each stage of one frame.
struct StageTimes {
  std::vector<Nanoseconds> effects_ns;  ///< in the order of the simulation's effects
  Nanoseconds predict_ns = 0;
  Nanoseconds update_ns = 0;
  Nanoseconds detect_ns = 0;
  Nanoseconds respond_ns = 0;
  Nanoseconds finish_ns = 0;
  Nanoseconds frame_ns = 0;      ///< wall time of the frame's loop, without the recording
  Nanoseconds recording_ns = 0;  ///< taken by the observer
};

/// What one collision step of the loop works on, before the backend is told: world frame, metres.
struct CollisionStep {
  std::span<const Vec3> substep_start;               ///< x
  std::span<const RigidMotion> previous_bone_poses;  ///< the poses that x was computed with
  std::span<const Vec3> positions;                   ///< p, which the backend is asked about
  std::span<const RigidMotion> bone_poses;
  bool last_of_frame = false;
};

/// Looks on while the loop collides: what it takes is recording time, not the frame's.
class CollisionObserver {
 public:
  CollisionObserver() = default;
  CollisionObserver(const CollisionObserver&) = delete;
  CollisionObserver& operator=(const CollisionObserver&) = delete;
  virtual ~CollisionObserver() = default;

  virtual void before_detection(const CollisionStep& step) = 0;
  /// The same step; the response has not moved anything yet.
  virtual void after_detection(const CollisionStep& step, std::span<const Contact> contacts) = 0;
};

/// Keeps the last detection of a frame: what the Referee judges.
class LastDetection final : public CollisionObserver {
 public:
  std::vector<Vec3> substep_start;
  std::vector<RigidMotion> previous_bone_poses;
  std::vector<Vec3> positions;
  std::vector<RigidMotion> bone_poses;
  std::vector<Contact> contacts;

  void before_detection(const CollisionStep& step) override;
  void after_detection(const CollisionStep& step, std::span<const Contact> answered) override;
};

/// Poses of all bones at `frame_position`: 0 before the first frame, 1 at the end of the first, fractions between.
using PoseFunction = std::function<void(double frame_position, std::vector<RigidMotion>& poses)>;

/// The shared position-based-dynamics loop: one muscle, rigid moving bones, any backend.
class Simulation {
 public:
  /// `backend` is built and outlives the simulation. `free_nodes` are the nodes that no bone carries, ascending: only
  /// these move by themselves and collide.
  Simulation(const LoopParameters& loop, Particles particles, std::vector<int> free_nodes,
             std::vector<std::unique_ptr<Effect>> effects, CollisionBackend& backend, ResponseKind response,
             PoseFunction poses);

  /// Runs frame `frame` (1-based) without allocating memory, if the backend does not. `observer`, when given, sees
  /// every collision step. The times are those of this frame until the next one.
  const StageTimes& step_frame(int frame, CollisionObserver* observer = nullptr);

  [[nodiscard]] const Particles& particles() const { return m_particles; }
  [[nodiscard]] std::span<const RigidMotion> bone_poses() const { return m_poses; }
  /// Answered by the last detection.
  [[nodiscard]] std::span<const Contact> contacts() const { return m_contacts; }
  [[nodiscard]] std::span<const int> free_nodes() const { return m_free_nodes; }
  [[nodiscard]] std::span<const std::unique_ptr<Effect>> effects() const { return m_effects; }

 private:
  void predict(const SubstepInput& input);
  void collide(bool last_of_frame, CollisionObserver* observer);
  void finish_substep();

  LoopParameters m_loop;
  Particles m_particles;
  std::vector<int> m_free_nodes;
  std::vector<std::unique_ptr<Effect>> m_effects;
  CollisionBackend& m_backend;
  Response m_response;
  PoseFunction m_pose_function;
  std::vector<RigidMotion> m_poses;
  std::vector<RigidMotion> m_previous_poses;
  std::vector<Contact> m_contacts;
  StageTimes m_times;
};

}  // namespace musclebench

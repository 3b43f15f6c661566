#include "bench/run_case.hpp"

#include <algorithm>
#include <cmath>
#include <malloc.h>
#include <memory>
#include <numbers>

#include <fmt/format.h>

#include "core/base/sha256.hpp"
#include "core/base/system_memory.hpp"
#include "core/geometry/surface_volume.hpp"
#include "core/measure/referee.hpp"

namespace musclebench {

namespace {

constexpr double degrees_per_radian = 180 / std::numbers::pi;

/// Positions farther than this many scene diagonals from the start count as blown up.
constexpr double divergence_diagonals = 10;

std::vector<int> all_nodes(const Scene& scene) {
  std::vector<int> nodes(scene.muscle.mesh.vertices.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = static_cast<int>(i);
  }
  return nodes;
}

std::vector<BoundNode> bind_nodes(const Scene& scene, CollisionBackend& backend,
                                  const std::vector<RigidMotion>& rest_poses) {
  if (!scene.attach_at_first_contact) {
    return scene.bound_nodes();
  }
  std::vector<Contact> contacts;
  backend.update(rest_poses, scene.muscle.mesh.vertices);
  backend.detect(scene.muscle.mesh.vertices, all_nodes(scene), contacts);
  std::vector<BoundNode> bound;
  bound.reserve(contacts.size());
  for (const Contact& contact : contacts) {
    bound.push_back({contact.node, contact.bone});
  }
  std::stable_sort(bound.begin(), bound.end(), [](const BoundNode& a, const BoundNode& b) { return a.node < b.node; });
  bound.erase(
      std::unique(bound.begin(), bound.end(), [](const BoundNode& a, const BoundNode& b) { return a.node == b.node; }),
      bound.end());
  return bound;
}

Particles particles_of(const Scene& scene, const std::vector<BoundNode>& bound) {
  Particles particles;
  particles.positions = scene.muscle.mesh.vertices;
  particles.predicted = particles.positions;
  particles.velocities.assign(particles.size(), Vec3::Zero());
  const double volume_m3 = std::abs(surface_volume_m3(scene.muscle.mesh.vertices, scene.muscle.mesh.triangles));
  const double shared_mass_kg = scene.loop.density_kg_per_m3 * volume_m3 / static_cast<double>(particles.size());
  particles.inverse_masses.assign(particles.size(),
                                  1 / (shared_mass_kg > 0 ? shared_mass_kg : scene.loop.node_mass_kg));
  for (const BoundNode& node : bound) {
    particles.inverse_masses[node.node] = 0;
  }
  return particles;
}

std::vector<int> free_nodes_of(const Particles& particles) {
  std::vector<int> nodes;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (particles.inverse_masses[i] > 0) {
      nodes.push_back(static_cast<int>(i));
    }
  }
  return nodes;
}

double scene_diagonal_m(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : scene.muscle.mesh.vertices) {
    box.extend(vertex);
  }
  for (const Bone& bone : scene.bones) {
    for (const Vec3& vertex : bone.surface.mesh.vertices) {
      box.extend(vertex);
    }
  }
  return box.diagonal().norm();
}

/// The first node that left the range of the scene; -1 when all is well. Written so that NaN counts as lost.
int lost_node(const std::vector<Vec3>& positions, const std::vector<Vec3>& rest, double range_m) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!((positions[i] - rest[i]).norm() <= range_m)) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

std::string hash_of(const Particles& particles) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(particles.positions)));
  hash.add(std::as_bytes(std::span(particles.velocities)));
  return hash.hex_digest().substr(0, 16);
}

/// Drives one simulation and looks at it between frames.
class CaseRunner {
 public:
  explicit CaseRunner(const RunCase& run) : m_run(run), m_scene(run.scene) {}

  RunResult run(const std::function<void(int)>& report) {
    start();
    const Nanoseconds start_ns = monotonic_now_ns();
    keep_snapshot(0);
    for (int frame = 1; frame <= m_scene.loop.frames && m_result.status == "ok"; ++frame) {
      step(frame);
      report(frame);
    }
    m_result.wall_ns = monotonic_now_ns() - start_ns;
    m_result.memory_after_bytes = memory_without_referee_bytes();
    m_result.memory_peak_bytes = peak_resident_memory_bytes();
    m_result.state_hash = hash_of(m_simulation->particles());
    return std::move(m_result);
  }

 private:
  void start() {
    std::vector<RigidMotion> rest_poses(m_scene.bones.size());
    m_backend = m_run.backend.make(m_run.parameters);
    const Nanoseconds start_ns = monotonic_now_ns();
    m_backend->build(m_scene.bones, m_scene.muscle.mesh, m_run.threads);
    m_result.build_ns = monotonic_now_ns() - start_ns;
    m_result.structure_bytes = m_backend->structure_bytes();

    m_result.bound_nodes = bind_nodes(m_scene, *m_backend, rest_poses);
    std::vector<std::unique_ptr<Effect>> effects;
    const std::vector<FibreSegment> fibres = m_scene.fibres_with(m_result.bound_nodes);
    const EffectInput input{m_scene.muscle.mesh, fibres, m_result.bound_nodes, rest_poses};
    for (const SceneEffect& effect : m_scene.effects) {
      effects.push_back(find_effect(effect.name)->make(input, effect.parameters));
      m_result.effect_names.push_back(effect.name);
    }
    Particles particles = particles_of(m_scene, m_result.bound_nodes);
    std::vector<int> free_nodes = free_nodes_of(particles);
    m_simulation = std::make_unique<Simulation>(
        m_scene.loop, std::move(particles), std::move(free_nodes), std::move(effects), *m_backend,
        m_run.backend.response,
        [this](double position, std::vector<RigidMotion>& poses) { m_scene.poses_at(position, poses); });
    m_result.rest_volume_m3 = surface_volume_m3(m_scene.muscle.mesh.vertices, m_scene.muscle.mesh.triangles);
    m_range_m = divergence_diagonals * scene_diagonal_m(m_scene);
    m_result.records.reserve(static_cast<std::size_t>(std::min(m_scene.loop.frames, 100000)));
    malloc_trim(0);  // what only the building needed shall not count as the structures' memory
    m_result.memory_before_bytes = resident_memory_bytes();
    if (m_run.judge) {
      m_referee = std::make_unique<Referee>(m_scene.bones, static_cast<int>(m_scene.muscle.mesh.vertices.size()));
      malloc_trim(0);
      m_result.referee_bytes =
          resident_memory_bytes() - std::min(resident_memory_bytes(), m_result.memory_before_bytes);
    }
  }

  /// The judge is the harness's; only the rest is what the simulation needs.
  [[nodiscard]] std::size_t memory_without_referee_bytes() const {
    return resident_memory_bytes() - std::min(resident_memory_bytes(), m_result.referee_bytes);
  }

  void step(int frame) {
    StepRecord record;
    record.frame = frame;
    record.angle_deg = m_scene.angle_rad(frame) * degrees_per_radian;
    record.warm_up = frame <= m_run.warm_up_frames;
    record.times = m_simulation->step_frame(frame, m_referee ? &m_last_detection : nullptr);
    record.contacts = static_cast<int>(m_simulation->contacts().size());
    record.resident_bytes = memory_without_referee_bytes();

    const Particles& particles = m_simulation->particles();
    record.volume_m3 = surface_volume_m3(particles.positions, m_scene.muscle.mesh.triangles);
    const int lost = lost_node(particles.positions, m_scene.muscle.mesh.vertices, m_range_m);
    if (lost >= 0) {
      m_result.status = "diverged";
      m_result.status_detail =
          fmt::format("frame {}: node {} left the scene by more than {:.3g} m", frame, lost, m_range_m);
    } else if (m_referee) {
      m_referee->judge(m_last_detection.bone_poses, m_last_detection.positions, m_simulation->free_nodes(), m_truth);
      record.difference = compare_contacts(m_last_detection.contacts, m_truth);
      m_referee->judge(m_simulation->bone_poses(), particles.positions, m_simulation->free_nodes(), m_truth);
      record.depth = depth_statistics(m_truth);
      record.judged = true;
    }
    m_result.records.push_back(record);
    if (lost < 0) {
      keep_snapshot(frame);
    }
  }

  void keep_snapshot(int frame) {
    if (!std::binary_search(m_run.snapshots.begin(), m_run.snapshots.end(), frame)) {
      return;
    }
    const auto poses = m_simulation->bone_poses();
    Snapshot snapshot{frame,
                      m_scene.angle_rad(frame) * degrees_per_radian,
                      m_simulation->particles().positions,
                      std::vector<double>(m_simulation->particles().size(), 0.0),
                      {poses.begin(), poses.end()}};
    if (m_referee) {
      m_referee->judge(poses, snapshot.positions, m_simulation->free_nodes(), m_truth);
      for (const Contact& contact : m_truth) {
        double& depth_m = snapshot.depths_m[contact.node];
        depth_m = std::max(depth_m, contact.depth_m);
      }
    }
    m_result.snapshots.push_back(std::move(snapshot));
  }

  const RunCase& m_run;
  const Scene& m_scene;
  RunResult m_result;
  std::unique_ptr<CollisionBackend> m_backend;
  std::unique_ptr<Simulation> m_simulation;
  std::unique_ptr<Referee> m_referee;
  LastDetection m_last_detection;
  std::vector<Contact> m_truth;
  double m_range_m = 0;
};

}  // namespace

RunResult run_case(const RunCase& run, const std::function<void(int)>& report) { return CaseRunner(run).run(report); }

}  // namespace musclebench

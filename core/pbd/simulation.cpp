#include "core/pbd/simulation.hpp"

#include <algorithm>
#include <utility>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace musclebench {

namespace {

/// Adds the time of a stage that a whole team goes through: from when its first thread begins until all have ended.
class TeamTimer {
 public:
  TeamTimer(Nanoseconds& total_ns, const Team& team)
      : m_total_ns(total_ns), m_team(team), m_start_ns(team.is_first() ? monotonic_now_ns() : 0) {}
  TeamTimer(const TeamTimer&) = delete;
  TeamTimer& operator=(const TeamTimer&) = delete;
  ~TeamTimer() {
    m_team.wait();
    if (m_team.is_first()) m_total_ns += monotonic_now_ns() - m_start_ns;
  }

 private:
  Nanoseconds& m_total_ns;
  const Team& m_team;
  Nanoseconds m_start_ns;
};

/// Calls `work(team)` on so many threads.
template <typename Work>
void run_team([[maybe_unused]] int threads, [[maybe_unused]] Barrier& barrier, const Work& work) {
#ifdef _OPENMP
  if (threads > 1) {  // OpenMP allocates even a team of one
    barrier.reset();
#pragma omp parallel num_threads(threads)
    work(Team(omp_get_thread_num(), omp_get_num_threads(), barrier));
    return;
  }
#endif
  work(Team());
}

}  // namespace

double LoopParameters::time_step_of_s(int frame) const {
  double step_s = time_step_s;
  for (const TimeStepChange& change : time_step_changes) {
    if (change.from_frame <= frame) step_s = change.time_step_s;
  }
  return step_s;
}

double LoopParameters::time_s(int frame, int substep) const {
  double steps = static_cast<double>(frame - 1) * substeps + substep;
  double changed_s = 0;
  for (auto change = time_step_changes.rbegin(); change != time_step_changes.rend(); ++change) {
    const double later_steps = std::max(0.0, steps - static_cast<double>(change->from_frame - 1) * substeps);
    changed_s += later_steps * change->time_step_s;
    steps -= later_steps;
  }
  return steps * time_step_s + changed_s;
}

void LastDetection::before_detection(const CollisionStep& step) {
  if (!step.last_of_frame) {
    return;
  }
  substep_start.assign(step.substep_start.begin(), step.substep_start.end());
  previous_bone_poses.assign(step.previous_bone_poses.begin(), step.previous_bone_poses.end());
  positions.assign(step.positions.begin(), step.positions.end());
  bone_poses.assign(step.bone_poses.begin(), step.bone_poses.end());
  contacts.reserve(bone_poses.size() * positions.size());
}

void LastDetection::after_detection(const CollisionStep& step, std::span<const Contact> detected) {
  if (step.last_of_frame) {
    contacts.assign(detected.begin(), detected.end());
  }
}

Simulation::Simulation(const LoopParameters& loop, const Particles& particles, NodeOrder order,
                       std::vector<std::unique_ptr<Effect>> effects, CollisionBackend& backend, Response response,
                       PoseFunction poses, int threads)
    : m_loop(loop),
      m_order(std::move(order)),
      m_positions(particles.positions),
      m_predicted(particles.positions),
      m_start(m_order, particles.positions, particles.inverse_masses),
      m_rows(m_start),
      m_velocities(particles.size()),
      m_effects(std::move(effects)),
      m_backend(backend),
      m_response(std::move(response)),
      m_pose_function(std::move(poses)),
      m_lost(particles.positions),
      m_start_overlap(particles.size()),
      m_threads(threads),
      m_barrier(threads) {
  for (int node = 0; node < static_cast<int>(particles.size()); ++node) {
    if (particles.inverse_masses[node] > 0) {
      m_free_nodes.push_back(node);
      m_velocities[m_order.row_of(node)].set_position(particles.velocities[node]);
    }
  }
  m_pose_function(0, m_poses);
  m_previous_poses = m_poses;
  // Reserved for the most contacts possible, so that no timed frame allocates memory.
  m_contacts.reserve(m_poses.size() * m_free_nodes.size());
  m_response.reserve(particles.size(), m_poses.size());
  m_times.effects_ns.reserve(m_effects.size());
}

std::vector<Vec3> Simulation::velocities() const {
  std::vector<Vec3> velocities(m_velocities.size());
  for (std::size_t row = 0; row < m_velocities.size(); ++row) {
    velocities[m_order.node_in(row)] = m_velocities[row].position();
  }
  return velocities;
}

void Simulation::settle() {
  start_times();
  const std::vector<NodeRow> velocities = m_velocities;
  for (int substep = 0; substep < m_loop.settle_substeps; ++substep) {
    std::ranges::fill(m_velocities, NodeRow{});
    step({m_loop.time_step_of_s(1), m_poses, 0}, false, nullptr);
  }
  m_velocities = velocities;
}

void Simulation::start_times() {
  m_times = StageTimes{.effects_ns = std::move(m_times.effects_ns),
                       .stages_ns = std::move(m_times.stages_ns),
                       .pairs_ns = std::move(m_times.pairs_ns)};
  m_times.effects_ns.assign(m_effects.size(), 0);
  m_times.stages_ns.assign(m_stages.size(), 0);
  m_times.pairs_ns.assign(m_backend.pair_times().size(), 0);
}

const StageTimes& Simulation::step_frame(int frame, CollisionObserver* observer) {
  start_times();
  const Nanoseconds start_ns = monotonic_now_ns();
  const double time_step_s = m_loop.time_step_of_s(frame);
  m_lost.clear();
  m_was_stopped = false;
  if (m_impulses) m_impulses->begin_frame(time_step_s);
  for (const auto& effect : m_effects) effect->begin_frame();
  m_depenetration_m = m_loop.depenetration_m_per_s > 0 ? m_loop.depenetration_m_per_s * time_step_s / m_loop.iterations
                                                       : std::numeric_limits<double>::infinity();
  for (m_substep = 0; m_substep < m_loop.substeps && !has_ended();) {
    ++m_substep;
    m_previous_poses.swap(m_poses);
    const double part = m_loop.interpolate_poses ? static_cast<double>(m_substep) / m_loop.substeps : 1.0;
    m_pose_function(frame - 1 + part, m_poses);
    step({time_step_s, m_poses, m_loop.time_s(frame, m_substep)}, m_substep == m_loop.substeps, observer);
  }
  if (m_impulses) m_impulses->end_frame();
  if (!has_ended()) {
    look_at_positions(Team());
    look_at_moves(time_step_s, Team());
  }
  m_times.frame_ns = monotonic_now_ns() - start_ns - m_times.recording_ns;
  return m_times;
}

void Simulation::step(const SubstepInput& input, bool last_of_frame, CollisionObserver* observer) {
  if (m_impulses) m_impulses->begin_substep();
  for (int iteration = 1; iteration <= m_loop.iterations; ++iteration) {
    run_team(m_threads, m_barrier, [&](const Team& team) {
      if (iteration == 1) {
        apply_forces(input, team);
        predict(input, team);
        tell_watch(moved_by_velocity, team);
      }
      project(input, team);
    });
    m_was_stopped = m_asks_to_stop && m_asks_to_stop();
    if (has_ended()) return;
    collide(last_of_frame && iteration == m_loop.iterations, observer);
    if (has_ended()) return;
  }
  const bool records_end = m_impulses && !m_stages.empty();
  if (records_end) m_impulses->begin_contacts(m_positions, m_predicted);
  run_stages(&ContactStage::end_substep, m_contacts);
  if (records_end) m_impulses->add_contacts(m_positions, m_predicted, {});
  if (has_ended()) return;
  run_team(m_threads, m_barrier, [&](const Team& team) { finish_substep(input.time_step_s, team); });
}

void Simulation::apply_forces(const SubstepInput& input, const Team& team) {
  for (std::size_t i = 0; i < m_effects.size(); ++i) {
    const TeamTimer timer(m_times.effects_ns[i], team);
    const bool is_recorded = m_impulses && m_effects[i]->is_force();
    if (is_recorded) {
      if (team.is_first()) m_impulses->velocities_before() = m_velocities;
      team.wait();
    }
    m_effects[i]->apply_force(m_rows, m_velocities, input, team);
    if (is_recorded) record_force(i, input.time_step_s, team);
  }
}

void Simulation::predict(const SubstepInput& input, const Team& team) {
  const TeamTimer timer(m_times.predict_ns, team);
  const auto [first, last] = team.share(m_rows.size());
  bool all_small = true;
  for (std::size_t row = first; row < last; ++row) {
    const NodeRow move = input.time_step_s * m_velocities[row];
    m_rows[row] = m_start[row] + move;
    all_small &= m_lost.is_small(move);
  }
  if (!all_small) look_at_moves(input.time_step_s, team);
}

void Simulation::project(const SubstepInput& input, const Team& team) {
  for (std::size_t i = 0; i < m_effects.size(); ++i) {
    {
      const TeamTimer timer(m_times.effects_ns[i], team);
      if (m_impulses) {
        if (team.is_first()) m_rows.set_impulses(m_impulses->rows_of(i));
        team.wait();
      }
      m_effects[i]->project(m_rows, input, team);
    }
    tell_watch(m_effects[i]->name(), team);
  }
  const TeamTimer timer(m_times.predict_ns, team);
  bool all_near = true;
  const auto [first, last] = team.share(m_rows.size());
  for (std::size_t row = first; row < last; ++row) {
    const int node = m_order.node_in(row);
    m_predicted[static_cast<std::size_t>(node)] = m_rows[row].position();
    all_near &= m_lost.is_near(m_rows[row]);
  }
  if (!all_near) look_at_positions(team);
}

void Simulation::record_impulses(std::vector<Body> muscles) {
  std::vector<double> inverse_masses(m_positions.size());
  for (std::size_t row = 0; row < m_rows.size(); ++row) {
    inverse_masses[static_cast<std::size_t>(m_order.node_in(row))] = m_rows[row].inverse_mass;
  }
  m_impulses =
      std::make_unique<FrameImpulses>(std::move(muscles), m_poses.size(), m_order, inverse_masses, m_effects.size());
}

void Simulation::record_force(std::size_t effect, double time_step_s, const Team& team) {
  team.wait();
  const auto [first, last] = team.share(m_rows.size());
  for (std::size_t row = first; row < last; ++row) {
    const double inverse_mass = m_rows[row].inverse_mass;
    if (inverse_mass == 0) continue;
    const NodeRow change = m_velocities[row] - m_impulses->velocities_before()[row];
    NodeRow& sum = m_impulses->rows_of(effect)[row];
    sum = sum + time_step_s / inverse_mass * change;
  }
}

void Simulation::look_at_positions(const Team& team) {
  const auto [first, last] = team.share(m_rows.size());
  for (std::size_t row = first; row < last; ++row) {
    m_lost.measure_position(m_order.node_in(row), m_rows[row].position());
  }
}

void Simulation::look_at_moves(double time_step_s, const Team& team) {
  const auto [first, last] = team.share(m_rows.size());
  for (std::size_t row = first; row < last; ++row) {
    m_lost.measure_move(m_order.node_in(row), time_step_s * m_velocities[row].position());
  }
}

Vec3 Simulation::move(int node) const {
  const auto row = static_cast<std::size_t>(m_order.row_of(node));
  return (m_rows[row] - m_start[row]).position();
}

void Simulation::tell_watch(std::string_view mover, const Team& team) const {
  if (!m_watch) return;
  if (team.is_first()) m_watch(mover);
  team.wait();
}

void Simulation::run_stages(StageMoment moment, std::span<const Contact> contacts) {
  for (std::size_t i = 0; i < m_stages.size(); ++i) {
    const ScopedTimer timer(m_times.stages_ns[i]);
    for (const int node : ((*m_stages[i]).*moment)(stage_input(contacts))) {
      const auto row = m_order.row_of(node);
      m_rows[row].set_position(m_predicted[static_cast<std::size_t>(node)]);
      m_start[row].set_position(m_positions[static_cast<std::size_t>(node)]);
      if (!m_lost.is_near(m_rows[row])) m_lost.measure_position(node, m_rows[row].position());
    }
    tell_watch(m_stages[i]->name(), Team());
  }
}

void Simulation::collide(bool last_of_frame, CollisionObserver* observer) {
  if (observer != nullptr) {
    const ScopedTimer timer(m_times.recording_ns);
    observer->before_stages(m_predicted);
  }
  if (m_impulses) m_impulses->begin_contacts(m_positions, m_predicted);
  run_stages(&ContactStage::before_bones, {});
  if (has_ended()) return;
  const CollisionStep step{m_positions, m_previous_poses, m_predicted, m_poses, last_of_frame};
  if (observer != nullptr) {
    const ScopedTimer timer(m_times.recording_ns);
    observer->before_detection(step);
  }
  find_contacts();
  if (observer != nullptr) {
    const ScopedTimer timer(m_times.recording_ns);
    observer->after_detection(step, m_contacts);
  }
  for (std::size_t i = 0; i < m_stages.size(); ++i) {
    const ScopedTimer timer(m_times.stages_ns[i]);
    m_stages[i]->add_contacts(stage_input({}), m_contacts);
  }
  for (std::size_t i = 0; i < m_stages.size(); ++i) {
    const ScopedTimer timer(m_times.stages_ns[i]);
    m_stages[i]->before_response(stage_input(m_contacts));
  }
  respond();
  tell_watch(moved_by_response, Team());
  run_stages(&ContactStage::after_bones, m_contacts);
  if (m_impulses) m_impulses->add_contacts(m_positions, m_predicted, m_contacts);
}

void Simulation::finish_substep(double time_step_s, const Team& team) {
  const TeamTimer timer(m_times.finish_ns, team);
  const double per_time_step = 1.0 / time_step_s;
  const auto [first, last] = team.share(m_rows.size());
  for (std::size_t row = first; row < last; ++row) {
    if (m_rows[row].inverse_mass > 0) {
      m_velocities[row] = per_time_step * (m_rows[row] - m_start[row]);
    }
    m_start[row] = m_rows[row];
  }
  if (team.is_first()) m_positions.swap(m_predicted);
}

}  // namespace musclebench

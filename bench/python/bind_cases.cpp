#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <iterator>
#include <mutex>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include "bench/cases/probe_case.hpp"
#include "bench/cases/record_case.hpp"
#include "bench/cases/replay_case.hpp"
#include "bench/process/progress.hpp"
#include "bench/python/arrays.hpp"
#include "bench/python/bindings.hpp"
#include "bench/python/chosen_backend.hpp"
#include "bench/python/loaded_scene.hpp"
#include "bench/results/other_case.hpp"
#include "bench/results/probe_output.hpp"
#include "bench/results/recorded_scene.hpp"
#include "bench/results/recording_header_of.hpp"
#include "bench/results/replay_output.hpp"
#include "bench/results/result_folder.hpp"
#include "bench/results/run_output.hpp"
#include "bench/trials/required_figure.hpp"
#include "core/base/input_error.hpp"
#include "core/recording/recording_reader.hpp"
#include "core/scene/prepare_simulation.hpp"

namespace musclebench {

namespace py = pybind11;
using namespace pybind11::literals;
namespace fs = std::filesystem;

namespace {

/// Progress on a terminal. Throws what Ctrl-C raises in Python.
class Watched {
 public:
  Watched(std::string label, int total) : m_progress(progress_style(false), std::move(label), total) {}

  void show(int done) {
    m_progress.show(done);
    look(std::chrono::milliseconds(100));
    rethrow();
  }
  /// For work that asks within what it times, and then ends by itself. Another thread of Python may keep the
  /// interpreter for 5 ms, so it seldom looks.
  bool is_interrupted() {
    look(std::chrono::seconds(1));
    return m_interruption != nullptr;
  }
  void rethrow() const {
    if (m_interruption) std::rethrow_exception(m_interruption);
  }

 private:
  using Clock = std::chrono::steady_clock;

  void look(Clock::duration after) {
    if (m_interruption || Clock::now() - m_last_look < after) return;
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) m_interruption = std::make_exception_ptr(py::error_already_set());
    m_last_look = Clock::now();
  }

  Progress m_progress;
  Clock::time_point m_last_look = Clock::now();
  std::exception_ptr m_interruption;
};

/// A run adds warnings of its own to those of the scene.
class KeptWarnings {
 public:
  explicit KeptWarnings(Scene& scene) : m_scene(scene), m_kept(scene.warnings) {}
  KeptWarnings(const KeptWarnings&) = delete;
  KeptWarnings& operator=(const KeptWarnings&) = delete;
  ~KeptWarnings() { m_scene.warnings = std::move(m_kept); }

 private:
  Scene& m_scene;
  std::vector<SceneWarning> m_kept;
};

/// Throws InputError.
std::vector<int> frames_of(const Scene& scene, std::vector<int> frames) {
  std::ranges::sort(frames);
  if (!frames.empty() && (frames.front() < 0 || frames.back() > scene.loop.frames)) {
    throw InputError("snapshots", fmt::format("frame {} is not within 0 (rest) and {}",
                                              frames.front() < 0 ? frames.front() : frames.back(), scene.loop.frames));
  }
  return frames;
}

/// What a backend in Python does stands in no case: its results are never those of the same case.
void require_room(const fs::path& out, const Case& resolved, const ChosenBackend& chosen, std::string_view mode,
                  bool force) {
  if (!force) require_no_other_case(out, resolved, mode);
  if (!force && chosen.is_python && fs::exists(out / "run.json")) {
    throw InputError(out.string(),
                     "holds a result, and a backend in Python may have changed since; give force=True, or "
                     "another folder");
  }
  require_writable(out);
}

std::string run(LoadedScene& loaded, const py::object& backend, const py::object& parameters, const fs::path& out,
                const CaseChoice& choice, std::vector<int> snapshots, bool judge, bool forces, bool force) {
  require_threads(choice.threads);
  const ChosenBackend chosen = choose_backend(backend, parameters);
  const py::gil_scoped_release unlocked;
  const std::unique_lock<InUse> lock = wait_for(loaded.in_use);
  Scene& scene = loaded.scene;
  const KeptWarnings of_the_scene(scene);
  RunCase what{resolve_case(scene, *chosen.entry, chosen.parameters, choice)};
  what.judge = judge;
  std::ranges::move(warnings_of_run(what), std::back_inserter(scene.warnings));
  what.judges_wishes = !scene.wanted.own_values.empty();
  what.snapshots = frames_of(scene, std::move(snapshots));
  what.forces = forces;
  require_room(out, what, chosen, "coupled", force);
  Watched watched(fmt::format("{} {}", scene.name, chosen.entry->name), scene.loop.frames);
  RunResult result = run_case(
      what, [&](int done) { watched.show(done); }, {}, [&] { return watched.is_interrupted(); });
  watched.rethrow();
  note_unmet_wants(what, result);
  write_run(out, what, result);
  return result.status;
}

void record(LoadedScene& loaded, const fs::path& out, const py::object& backend, const py::object& parameters,
            const CaseChoice& choice) {
  require_threads(choice.threads);
  const ChosenBackend chosen = backend.is_none() ? choose_backend(py::str(exact_backend().name), parameters)
                                                 : choose_backend(backend, parameters);
  const py::gil_scoped_release unlocked;
  const std::unique_lock<InUse> lock = wait_for(loaded.in_use);
  const Scene& scene = loaded.scene;
  if (!loaded.choice.effect_overrides.empty()) {
    throw InputError("effects", "a recording does not tell changed effects; write them into a scene file");
  }
  const Case resolved = resolve_case(scene, *chosen.entry, chosen.parameters, choice);
  require_recording_writable(out);
  const BuiltBackend built = build_backend(resolved);
  const PreparedSimulation prepared =
      prepare_simulation(scene, *built.backend, resolved.responses, resolved.threads,
                         make_contact_methods(scene, resolved.colliders, resolved.threads));
  RecordingWriter writer(
      out, recording_header(resolved, loaded.choice, {1, scene.loop.frames}, prepared.simulation->free_nodes()));
  Watched watched("record " + scene.name, scene.loop.frames);
  const std::string lost = record_frames(*prepared.simulation, scene, writer, [&](int done) { watched.show(done); });
  if (!lost.empty()) throw std::runtime_error(scene.name + ": diverged, nothing was recorded: " + lost);
  writer.finish();
}

std::string replay(const fs::path& recording, const py::object& backend, const py::object& parameters,
                   const fs::path& out, const CaseChoice& choice, const std::string& data, int stride, bool judge,
                   bool force) {
  require_threads(choice.threads);
  const ChosenBackend chosen = choose_backend(backend, parameters);
  const py::gil_scoped_release unlocked;
  RecordingReader reader(recording.string());
  const RecordingHeader& header = reader.header();
  const Scene scene = load_recorded_scene(header, {recording.string(), "", data});
  ReplayCase what{resolve_case(scene, *chosen.entry, chosen.parameters, choice), reader.file()};
  if (stride < 1) throw InputError("stride", fmt::format("is {}; give at least 1", stride));
  what.stride = stride;
  what.judge = judge;
  require_room(out, what, chosen, "replay", force);
  Watched watched(fmt::format("replay {} {}", scene.name, chosen.entry->name), replayed_frames(what, header));
  const ReplayResult result = replay_case(what, reader, [&](int done) { watched.show(done); });
  write_replay(out, what, result, header, recording);
  return result.status;
}

std::string probe_points(LoadedScene& loaded, const py::object& backend, const py::object& parameters,
                         const fs::path& out, const CaseChoice& choice, int points, bool force) {
  require_threads(choice.threads);
  const ChosenBackend chosen = choose_backend(backend, parameters);
  const py::gil_scoped_release unlocked;
  const std::unique_lock<InUse> lock = wait_for(loaded.in_use);
  constexpr int most_points = 100'000'000;
  if (points < 1 || points > most_points / static_cast<int>(loaded.scene.bones.size())) {
    throw InputError("points",
                     fmt::format("are {}; give at least 1, and at most {} over all bones", points, most_points));
  }
  ProbeCase what{{loaded.scene, *chosen.entry, chosen.parameters, choice.threads}, points};
  require_room(out, what, chosen, "probe", force);
  Watched watched(fmt::format("probe {} {}", loaded.scene.name, chosen.entry->name),
                  points * static_cast<int>(loaded.scene.bones.size()));
  const ProbeResult result = probe(what, [&](int done) { watched.show(done); });
  write_probe(out, what, result);
  return result.status;
}

}  // namespace

void bind_cases(py::module_& module) {
  module.def(
      "run",
      [](LoadedScene& scene, const py::object& backend, const fs::path& out, const py::object& parameters, int threads,
         const std::string& response, const std::vector<std::string>& colliders, std::vector<int> snapshots, bool judge,
         bool forces, bool force) {
        return run(scene, backend, parameters, out, {response, colliders, threads}, std::move(snapshots), judge, forces,
                   force);
      },
      "scene"_a, "backend"_a, "out"_a, "parameters"_a = py::none(), py::kw_only(), "threads"_a = 1, "response"_a = "",
      "colliders"_a = std::vector<std::string>{}, "snapshots"_a = std::vector<int>{}, "judge"_a = true,
      "forces"_a = false, "force"_a = false, "Runs a scene into the result folder `out`; returns the status.");
  module.def(
      "record",
      [](LoadedScene& scene, const fs::path& out, const py::object& backend, const py::object& parameters,
         int threads) { record(scene, out, backend, parameters, {.threads = threads}); },
      "scene"_a, "out"_a, "backend"_a = py::none(), "parameters"_a = py::none(), py::kw_only(), "threads"_a = 1,
      "Runs a scene and stores the input of every collision step in a file.");
  module.def(
      "replay",
      [](const fs::path& recording, const py::object& backend, const fs::path& out, const py::object& parameters,
         int threads, const std::string& data, int stride, bool judge, bool force) {
        return replay(recording, backend, parameters, out, {.threads = threads}, data, stride, judge, force);
      },
      "recording"_a, "backend"_a, "out"_a, "parameters"_a = py::none(), py::kw_only(), "threads"_a = 1, "data"_a = "",
      "stride"_a = 1, "judge"_a = true, "force"_a = false, "Feeds a recording to a backend; returns the status.");
  module.def(
      "probe",
      [](LoadedScene& scene, const py::object& backend, const fs::path& out, const py::object& parameters, int threads,
         int points,
         bool force) { return probe_points(scene, backend, parameters, out, {.threads = threads}, points, force); },
      "scene"_a, "backend"_a, "out"_a, "parameters"_a = py::none(), py::kw_only(), "threads"_a = 1, "points"_a = 20000,
      "force"_a = false, "Asks a backend about points around each bone; returns the status.");
}

}  // namespace musclebench

#include <limits>
#include <mutex>
#include <numeric>
#include <optional>
#include <pybind11/stl.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "backends/registry.hpp"
#include "bench/python/arrays.hpp"
#include "bench/python/bindings.hpp"
#include "bench/python/chosen_backend.hpp"
#include "bench/python/loaded_scene.hpp"
#include "core/base/scoped_timer.hpp"
#include "core/base/unsupported_input.hpp"

namespace musclebench {

namespace py = pybind11;
using namespace pybind11::literals;

namespace {

/// A backend over bones, to be asked about points.
class QueriedBackend {
 public:
  QueriedBackend(ChosenBackend chosen, std::shared_ptr<LoadedScene> scene, std::vector<Bone> bones, int threads)
      : m_chosen(std::move(chosen)), m_scene(std::move(scene)), m_own_bones(std::move(bones)), m_threads(threads) {
    if (this->bones().empty()) throw InputError("bones", "are none; give a scene, or at least one bone");
    require_threads(threads);
    m_backend = m_chosen.entry->make(m_chosen.parameters);
    if (!m_scene && !m_backend->capabilities().point_queries) {
      throw UnsupportedInput(name(), "collides whole surfaces and can't be asked about points; give it a scene");
    }
    m_queries.resize(this->bones().size());
    const py::gil_scoped_release unlocked;
    const std::unique_lock<InUse> lock = wait_for(in_use());
    for (const Bone& bone : this->bones()) bone.shared.start_accounting();
    {
      const ScopedTimer timer(m_build_ns);
      m_backend->build(this->bones(), nodes(), threads);
    }
    for (const Bone& bone : this->bones()) m_build_ns += bone.shared.reused_build_ns();
  }

  [[nodiscard]] const std::string& name() const { return m_chosen.entry->name; }
  [[nodiscard]] const ChosenBackend& chosen() const { return m_chosen; }
  [[nodiscard]] double build_seconds() const { return 1e-9 * static_cast<double>(m_build_ns); }
  [[nodiscard]] std::size_t structure_bytes() const { return m_backend->structure_bytes(); }
  [[nodiscard]] std::pair<double, double> bound(const py::object& bone) {
    const auto of = static_cast<int>(index_of(bone));
    const py::gil_scoped_release unlocked;
    const std::unique_lock<InUse> lock = wait_for(in_use());
    const AnswerBound declared = m_backend->answer_bound(of);
    return {declared.missed_depth_m, declared.false_distance_m};
  }

  py::array detect(const py::object& points, const py::object& poses) {
    const NumberArray given = points.is_none() ? NumberArray() : numbers_in(points, "points");
    const std::span<const Vec3> positions = points.is_none() ? rest_nodes() : points_in(given, "points");
    require_surface(positions.size());
    const std::vector<RigidMotion> at = poses.is_none() ? std::vector<RigidMotion>(bones().size())
                                                        : poses_of(numbers_in(poses, "poses"), bones().size());
    std::vector<Contact> contacts;
    {
      const py::gil_scoped_release unlocked;
      const std::unique_lock<InUse> lock = wait_for(in_use());
      const Answering answering(*this);
      m_nodes.resize(positions.size());
      std::iota(m_nodes.begin(), m_nodes.end(), 0);
      m_backend->update(at, positions);
      m_backend->detect(positions, m_nodes, contacts);
    }
    return array_of(std::move(contacts));
  }

  py::array locate(const py::object& points, const py::object& bone) {
    const NumberArray given = numbers_in(points, "points");
    const std::span<const Vec3> positions = points_in(given, "points");
    const std::size_t of = index_of(bone);
    std::vector<SurfaceAnswer> answers(positions.size(), unknown());
    {
      const py::gil_scoped_release unlocked;
      const std::unique_lock<InUse> lock = wait_for(in_use());
      const Answering answering(*this);
      if (m_chosen.entry->make_surface_queries) {
        locate_on_both_sides(positions, of, answers);
      } else {
        locate_inside(positions, of, answers);
      }
    }
    return array_of(std::move(answers));
  }

 private:
  /// A backend in Python that is asked may ask others, but not itself: its buffers are in use.
  class Answering {
   public:
    explicit Answering(QueriedBackend& backend) : m_backend(backend) {
      require_threads(backend.m_threads);
      if (backend.m_is_answering) throw InputError(backend.name(), "is asked while it answers; ask another backend");
      backend.m_is_answering = true;
    }
    Answering(const Answering&) = delete;
    Answering& operator=(const Answering&) = delete;
    ~Answering() { m_backend.m_is_answering = false; }

   private:
    QueriedBackend& m_backend;
  };

  static SurfaceAnswer unknown() {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, Vec3::Constant(nan), Vec3::Constant(nan), -1};
  }

  [[nodiscard]] InUse& in_use() { return m_scene ? m_scene->in_use : m_in_use; }
  [[nodiscard]] std::span<const Bone> bones() const { return m_scene ? m_scene->scene.bones : m_own_bones; }
  [[nodiscard]] const TriangleMesh& nodes() const { return m_scene ? m_scene->scene.muscle_mesh : m_no_muscle; }

  [[nodiscard]] std::span<const Vec3> rest_nodes() const {
    if (!m_scene) throw InputError("points", "are missing; only a backend over a scene has nodes of its own");
    return m_scene->scene.muscle_mesh.vertices;
  }

  void require_surface(std::size_t points) const {
    if (m_backend->capabilities().point_queries || points == nodes().vertices.size()) return;
    throw UnsupportedInput(name(),
                           fmt::format("collides whole surfaces: give the positions of all {} nodes, not {} points",
                                       nodes().vertices.size(), points));
  }

  [[nodiscard]] std::size_t index_of(const py::object& bone) const {
    std::vector<std::string> names;
    for (const Bone& each : bones()) names.push_back(each.name);
    if (py::isinstance<py::str>(bone)) {
      const auto found = std::ranges::find(names, bone.cast<std::string>());
      if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    } else {
      const std::int64_t index = integer_of(bone, "bone");
      if (index >= 0 && index < std::ssize(names)) return static_cast<std::size_t>(index);
    }
    throw InputError("bone",
                     fmt::format("{} is none of them; there are 0 to {}: {}", py::repr(bone).cast<std::string>(),
                                 std::ssize(names) - 1, fmt::join(names, ", ")));
  }

  void locate_on_both_sides(std::span<const Vec3> points, std::size_t bone, std::vector<SurfaceAnswer>& answers) {
    std::shared_ptr<const SurfaceQueries>& queries = m_queries[bone];
    if (!queries) {
      queries = m_chosen.entry->make_surface_queries(m_chosen.parameters, bones())(bones()[bone], m_threads);
    }
#pragma omp parallel for schedule(static) num_threads(m_threads)
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (can_be_asked(points[i])) answers[i] = queries->locate(points[i], -1);
    }
  }

  /// What a detection of contacts tells. Outside the bone that is nothing.
  void locate_inside(std::span<const Vec3> points, std::size_t bone, std::vector<SurfaceAnswer>& answers) {
    const Capabilities can = m_backend->capabilities();
    if (!can.depth || !can.finds_contacts || !can.point_queries) {
      throw UnsupportedInput(name(), "tells no depth of a single point; ask it by detect, or ask another backend");
    }
    m_nodes.resize(points.size());
    std::iota(m_nodes.begin(), m_nodes.end(), 0);
    std::vector<Contact> contacts;
    m_backend->update(std::vector<RigidMotion>(bones().size()), points);
    m_backend->detect(points, m_nodes, contacts);
    for (const Contact& contact : contacts) {
      if (contact.bone != static_cast<int>(bone)) continue;
      const auto point = static_cast<std::size_t>(contact.node);
      answers[point] = {-contact.depth_m, contact.normal, points[point] + contact.depth_m * contact.normal, -1};
    }
  }

  ChosenBackend m_chosen;
  std::shared_ptr<LoadedScene> m_scene;  ///< nothing: bones of its own
  std::vector<Bone> m_own_bones;
  TriangleMesh m_no_muscle;
  int m_threads;
  InUse m_in_use;
  bool m_is_answering = false;
  std::unique_ptr<CollisionBackend> m_backend;
  std::vector<std::shared_ptr<const SurfaceQueries>> m_queries;  ///< by bone, built at their first use
  std::vector<int> m_nodes;
  Nanoseconds m_build_ns = 0;
};

std::vector<Bone> bones_in(const py::object& bones) {
  std::vector<Bone> own;
  for (const py::handle bone : py::isinstance<Bone>(bones) ? py::list(py::make_tuple(bones)) : py::list(bones)) {
    if (!py::isinstance<Bone>(bone)) throw InputError("bones", "has an element that is no Bone");
    own.push_back(bone.cast<const Bone&>());
  }
  return own;
}

}  // namespace

void bind_queries(py::module_& module) {
  py::class_<QueriedBackend>(module, "Backend",
                             R"(A backend over bones, to be asked about points.

Arrays of float64 that are contiguous are read where they are, and answers are not copied.)")
      .def(py::init([](const py::object& backend, const py::object& bones, const py::object& parameters, int threads) {
             ChosenBackend chosen = choose_backend(backend, parameters);
             if (py::isinstance<LoadedScene>(bones)) {
               return std::make_unique<QueriedBackend>(std::move(chosen), bones.cast<std::shared_ptr<LoadedScene>>(),
                                                       std::vector<Bone>{}, threads);
             }
             return std::make_unique<QueriedBackend>(std::move(chosen), nullptr, bones_in(bones), threads);
           }),
           "backend"_a, "bones"_a, "parameters"_a = py::none(), py::kw_only(), "threads"_a = 1,
           R"(Builds the structures of a backend over bones.

backend: a name of the catalogue, or an object that is a backend (`help(musclebench)`). bones: a Scene, a Bone, or
several. parameters: a dict, over the defaults. Raises InputError.)")
      .def_property_readonly("name", &QueriedBackend::name)
      .def_property_readonly("implementation",
                             [](const QueriedBackend& of) { return of.chosen().entry->implementation; })
      .def_property_readonly("build_seconds", &QueriedBackend::build_seconds,
                             "With what the bones had built before and share.")
      .def_property_readonly("structure_bytes", &QueriedBackend::structure_bytes)
      .def("bound", &QueriedBackend::bound, "bone"_a = 0,
           R"(What the backend declares of its contacts, in metres: (missed_m, false_m).

Every point deeper than missed_m is reported, and none farther outside than false_m. Infinite: nothing is declared.)")
      .def("detect", &QueriedBackend::detect, "points"_a = py::none(), "poses"_a = py::none(),
           R"(Contacts of points with bones.

points: (n, 3), metres, world frame (default: the scene's nodes at rest). poses: (bones, 4, 4), float64, see Scene.poses
(default: rest). Returns records ordered by bone, then point: node (index of the point), bone (index), depth_m (at least
0) and normal (3, unit, out of the bone). A backend that tells no depth leaves both at 0. Points with NaN have none.)")
      .def("locate", &QueriedBackend::locate, "points"_a, "bone"_a = 0,
           R"(Where points are to one bone.

points: (n, 3), metres, rest frame of the bone. bone: index or name. Returns a record a point: signed_distance_m
(negative inside), normal (3, unit, the gradient) and closest_m (3, on the surface). NaN where the backend does not tell:
most tell nothing outside the bone, and none beyond 1e9 m. A distance field is as exact as `bound` within the bone's box,
and off by up to half of the distance outside it. Raises UnsupportedInput for a backend that tells no depths.)");
}

}  // namespace musclebench

#include "bench/python/python_backend.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "backends/registry.hpp"
#include "bench/python/arrays.hpp"
#include "bench/python/chosen_backend.hpp"
#include "core/base/input_error.hpp"
#include "core/clearance/point_backend.hpp"

namespace musclebench {

namespace py = pybind11;

namespace {

/// An object of Python that C++ may let go of in a thread without the interpreter's lock.
using KeptObject = std::shared_ptr<py::object>;

KeptObject keep(py::object object) {
  return {new py::object(std::move(object)), [](py::object* kept) {
            const py::gil_scoped_acquire lock;
            delete kept;
          }};
}

/// Nothing where there is none. What a property of that name raises goes on.
std::optional<py::object> find_attribute(const py::object& of, const char* name) {
  py::object found = py::reinterpret_steal<py::object>(PyObject_GetAttrString(of.ptr(), name));
  if (found) return found;
  if (PyErr_ExceptionMatches(PyExc_AttributeError) == 0) throw py::error_already_set();
  PyErr_Clear();
  return std::nullopt;
}

py::object attribute(const py::object& of, const char* name, const std::string& where, const char* cure) {
  if (auto found = find_attribute(of, name)) return *found;
  throw InputError(where, fmt::format("has no {}; {}", name, cure));
}

double length_of(const py::handle& value, const std::string& where) {
  const double length_m = PyBool_Check(value.ptr()) ? -1.0 : PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw InputError(where, "bound_m is no length in metres, and no pair of them");
  }
  if (!(length_m >= 0)) throw InputError(where, "bound_m has to be at least 0 m");
  return length_m;
}

AnswerBound bound_of(const py::object& structure, const std::string& where) {
  const py::object bound = attribute(structure, "bound_m", where, "say how far an answer may be off, in metres");
  if (py::isinstance<py::str>(bound) || PySequence_Size(bound.ptr()) < 0) {  // a number has no length
    PyErr_Clear();
    const double both_m = length_of(bound, where);
    return {both_m, both_m};
  }
  const auto pair = bound.cast<py::sequence>();
  if (pair.size() != 2) throw InputError(where, "bound_m is no length in metres, and no pair of them");
  return {length_of(py::object(pair[0]), where), length_of(py::object(pair[1]), where)};
}

std::size_t bytes_of(const py::object& structure, const std::string& where) {
  const std::optional<py::object> told = find_attribute(structure, "bytes");
  const std::int64_t bytes = told ? integer_of(*told, where + ": bytes") : 0;
  if (bytes < 0) throw InputError(where, fmt::format("has {} bytes; give at least 0", bytes));
  return static_cast<std::size_t>(bytes);
}

/// What `detect` of Python returned, checked.
class PythonAnswer {
 public:
  PythonAnswer(const py::object& answer, std::size_t points, const std::string& where) : m_where(where) {
    if (!py::isinstance<py::sequence>(answer) || py::len(answer) != 3) {
      refuse("is no tuple of three arrays: indices, depths_m, normals");
    }
    const auto parts = answer.cast<py::sequence>();
    m_indices = indices_in(parts[0], m_where + ": indices");
    m_depths = numbers_in(parts[1], m_where + ": depths_m");
    m_normals = numbers_in(parts[2], m_where + ": normals");
    if (m_indices.size() == 0 && m_depths.size() == 0 && m_normals.size() == 0) {
      m_indices = IndexArray(0);
      return;
    }
    if (m_indices.ndim() != 1 || m_depths.ndim() != 1 || m_depths.shape(0) != size() ||
        std::ssize(points_in(m_normals, m_where + ": normals")) != size()) {
      refuse("has arrays of different lengths; give indices (k,), depths_m (k,) and normals (k, 3)");
    }
    for (py::ssize_t i = 0; i < size(); ++i) check(i, static_cast<std::int64_t>(points));
  }

  [[nodiscard]] py::ssize_t size() const { return m_indices.shape(0); }
  [[nodiscard]] std::size_t index(py::ssize_t i) const { return static_cast<std::size_t>(m_indices.data()[i]); }
  [[nodiscard]] double depth_m(py::ssize_t i) const { return m_depths.data()[i]; }
  [[nodiscard]] const Vec3& normal(py::ssize_t i) const { return reinterpret_cast<const Vec3*>(m_normals.data())[i]; }

 private:
  [[noreturn]] void refuse(const std::string& problem) const { throw InputError(m_where, "its answer " + problem); }

  void check(py::ssize_t i, std::int64_t points) const {
    const std::int64_t index = m_indices.data()[i];
    if (index < 0 || index >= points) refuse(fmt::format("names point {}, and there are {}", index, points));
    if (i > 0 && index <= m_indices.data()[i - 1]) refuse("has indices that do not ascend");
    if (!(depth_m(i) >= 0) || !std::isfinite(depth_m(i))) {
      refuse(fmt::format("has a depth of {} m; it is the distance to the surface, at least 0", depth_m(i)));
    }
    constexpr double far_from_unit = 1e-6;
    if (!(std::abs(normal(i).norm() - 1) < far_from_unit)) {
      refuse(fmt::format("has a normal of length {}; it has to be 1", normal(i).norm()));
    }
  }

  std::string m_where;
  IndexArray m_indices;
  NumberArray m_depths;
  NumberArray m_normals;
};

/// Over one bone.
class PythonStructure final : public BoneStructure {
 public:
  PythonStructure(py::object structure, std::string where)
      : m_where(std::move(where)),
        m_bound(bound_of(structure, m_where)),
        m_bytes(bytes_of(structure, m_where)),
        m_structure(keep(std::move(structure))) {}

  [[nodiscard]] AnswerBound answer_bound() const override { return m_bound; }
  [[nodiscard]] std::size_t bytes() const override { return m_bytes; }

  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) override {
    const py::gil_scoped_acquire lock;
    // Of a position that is not finite, Python is not asked: it has no contact.
    std::vector<int> nodes;
    std::vector<Vec3> points;
    for (const int node : batch.nodes) {
      const Vec3& position = batch.positions[static_cast<std::size_t>(node)];
      if (!position.allFinite()) continue;
      nodes.push_back(node);
      points.push_back(batch.pose.apply_inverse(position));
    }
    if (nodes.empty()) return;
    const PythonAnswer answer(m_structure->attr("detect")(array_of(std::move(points))), nodes.size(), m_where);
    for (py::ssize_t i = 0; i < answer.size(); ++i) {
      contacts.push_back(
          {nodes[answer.index(i)], batch.bone, answer.depth_m(i), batch.pose.apply_to_direction(answer.normal(i))});
    }
  }

 private:
  std::string m_where;
  AnswerBound m_bound;
  std::size_t m_bytes;
  KeptObject m_structure;
};

std::unique_ptr<BoneStructure> build_structure(const py::object& method, const std::string& where, const Bone& bone) {
  const py::gil_scoped_acquire lock;
  const TriangleMesh& mesh = bone.surface.mesh;  // copied: Python may keep it for longer than the bone lives
  return std::make_unique<PythonStructure>(
      method.attr("build")(bone.name, array_of(mesh.vertices), array_of(mesh.triangles)),
      fmt::format("{} over {}", where, bone.name));
}

ParameterSpec specification(const std::string& name, const ParameterValue& value) {
  constexpr double any = std::numeric_limits<double>::max();
  if (const auto* flag = std::get_if<bool>(&value)) return parameter::flag({.name = name, .default_value = *flag});
  if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    return parameter::integer({.name = name, .default_value = *integer});
  }
  if (const auto* number = std::get_if<double>(&value)) {
    return parameter::number({.name = name, .default_value = *number, .minimum = -any, .maximum = any});
  }
  const auto& word = std::get<std::string>(value);
  return parameter::choice({.name = name, .choices = {word}});
}

}  // namespace

BackendEntry python_backend_entry(const py::object& method) {
  BackendEntry entry;
  entry.name = py::str(attribute(method, "name", "backend", "give a backend's name, or an object that has one"))
                   .cast<std::string>();
  const std::string where = "backend '" + entry.name + "'";
  for (const BackendEntry& known : backend_registry()) {
    if (known.name == entry.name) throw InputError(where, "has the name of a backend of this build; give it another");
  }
  if (entry.name.empty() ||
      entry.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos) {
    throw InputError(where, "names may have small letters, digits and _ only");
  }
  const char* cure = "say whose code it is, which version, which licence";
  entry.implementation = py::str(attribute(method, "implementation", where, cure)).cast<std::string>() + " (in Python)";
  attribute(method, "build", where, "write build(name, vertices, triangles)");
  entry.help = "a backend in Python";
  if (const std::optional<py::object> told = find_attribute(method, "parameters")) {
    if (!py::isinstance<py::dict>(*told)) throw InputError(where, "has parameters that are no dict");
    for (const auto& [name, value] : values_of(told->cast<py::dict>(), where)) {
      entry.parameters.push_back(specification(name, value));
    }
  }
  entry.make = [kept = keep(method), where](const Parameters& /*parameters*/) {
    return make_point_backend(
        {.nodes_a_batch = std::numeric_limits<std::size_t>::max(),  // one thread
         .build = [kept, where](const Bone& bone, int /*threads*/, const ShareReport& /*report*/) {
           return build_structure(*kept, where, bone);
         }});
  };
  return entry;
}

ChosenBackend choose_backend(const py::object& backend, const py::object& given) {
  if (!given.is_none() && !py::isinstance<py::dict>(given)) throw InputError("parameters", "are no dict");
  const py::dict parameters = given.is_none() ? py::dict() : given.cast<py::dict>();
  ChosenBackend chosen{nullptr, Parameters({}, {}, ""), !py::isinstance<py::str>(backend)};
  if (chosen.is_python) {
    if (!parameters.empty()) {
      throw InputError("parameters", "belong to the object itself, where a backend is written in Python");
    }
    chosen.entry = std::make_shared<const BackendEntry>(python_backend_entry(backend));
  } else {
    const BackendEntry& entry = find_backend(backend.cast<std::string>(), "backend");
    chosen.entry = {std::shared_ptr<void>(), &entry};  // of the table, which lives as long as the module
  }
  const std::string where = "parameters (" + chosen.entry->name + ")";
  chosen.parameters = Parameters(chosen.entry->parameters, values_of(parameters, where), where);
  (void)chosen.entry->make(chosen.parameters);  // refuses what does not go together
  return chosen;
}

}  // namespace musclebench

#include "bench/python/arrays.hpp"

#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace py = pybind11;

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Triangle) == 3 * sizeof(int));

std::string shape_of(const py::array& array) {
  std::string text;
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis)
    text += fmt::format("{}{}", axis ? ", " : "", array.shape(axis));
  return fmt::format("({})", text);
}

void require_rows_of_three(const py::array& array, const std::string& what) {
  if (array.ndim() == 2 && array.shape(1) == 3) return;
  throw InputError(what, fmt::format("has the shape {}; give an array of shape (n, 3)", shape_of(array)));
}

py::array read_only(py::array array) {
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// A field of a record: numbers of one type from `offset` on.
struct RecordField {
  const char* name;
  const char* type;
  std::size_t offset;
};

py::dtype record_type(std::initializer_list<RecordField> fields, std::size_t bytes) {
  py::list names, formats, offsets;
  for (const RecordField& field : fields) {
    names.append(field.name);
    formats.append(field.type);
    offsets.append(field.offset);
  }
  py::dict record;
  record["names"] = names;
  record["formats"] = formats;
  record["offsets"] = offsets;
  record["itemsize"] = bytes;
  return py::dtype::from_args(record);
}

template <typename Member, typename Record>
std::size_t offset_in(const Record& record, const Member& member) {
  return static_cast<std::size_t>(reinterpret_cast<const char*>(&member) - reinterpret_cast<const char*>(&record));
}

py::dtype record_type_of(const Contact& contact) {
  return record_type({{"node", "i4", offset_in(contact, contact.node)},
                      {"bone", "i4", offset_in(contact, contact.bone)},
                      {"depth_m", "f8", offset_in(contact, contact.depth_m)},
                      {"normal", "3f8", offset_in(contact, contact.normal)}},
                     sizeof(Contact));
}

py::dtype record_type_of(const SurfaceAnswer& answer) {
  return record_type({{"signed_distance_m", "f8", offset_in(answer, answer.signed_distance_m)},
                      {"normal", "3f8", offset_in(answer, answer.gradient)},
                      {"closest_m", "3f8", offset_in(answer, answer.closest_m)}},
                     sizeof(SurfaceAnswer));
}

/// What an array keeps alive.
template <typename Value>
py::capsule owner_of(std::vector<Value>* values) {
  return {values, [](void* memory) { delete static_cast<std::vector<Value>*>(memory); }};
}

template <typename Record>
py::array records_in(std::vector<Record> records) {
  auto* kept = new std::vector<Record>(std::move(records));
  return {record_type_of(Record{}), {kept->size()}, {sizeof(Record)}, kept->data(), owner_of(kept)};
}

template <typename Number, typename Row>
py::array rows_in(std::vector<Row> rows) {
  auto* kept = new std::vector<Row>(std::move(rows));
  return py::array_t<Number>({kept->size(), std::size_t{3}}, reinterpret_cast<const Number*>(kept->data()),
                             owner_of(kept));
}

std::string type_of(const py::handle& value) { return py::type::of(value).attr("__name__").cast<std::string>(); }

bool is_scalar_of_numpy(const py::handle& value, const char* kind) {
  return py::isinstance(value, py::module_::import("numpy").attr(kind));
}

ParameterValue value_of(const py::handle& value, const std::string& what) {
  if (is_truth_value(value)) return py::bool_(value.attr("__bool__")()).cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (PyFloat_Check(value.ptr()) || is_scalar_of_numpy(value, "floating")) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (!std::isfinite(number)) throw InputError(what, fmt::format("is {}; give a finite number", number));
    return number;
  }
  if (PyLong_Check(value.ptr()) || is_scalar_of_numpy(value, "integer")) return integer_of(value, what);
  throw InputError(what, fmt::format("has a value of type {}; give a bool, a number or a string", type_of(value)));
}

/// The array that NumPy makes of it. `kinds`: of the types that are taken (numpy.dtype.kind).
py::array array_from(const py::object& values, std::string_view kinds, const std::string& what, const char* wanted) {
  if (py::isinstance(values, py::module_::import("numpy").attr("ma").attr("MaskedArray"))) {
    throw InputError(what, "is a masked array, whose mask would be ignored; fill or leave out what is masked");
  }
  const py::array array = py::array::ensure(values);
  if (!array) {
    PyErr_Clear();
    throw InputError(what, fmt::format("is no array of numbers but of type {}; give {}", type_of(values), wanted));
  }
  if (array.size() > 0 && kinds.find(array.dtype().kind()) == std::string_view::npos) {
    throw InputError(
        what, fmt::format("has elements of type {}; give {}", py::str(array.dtype()).cast<std::string>(), wanted));
  }
  return array;
}

/// Row after row and aligned, as C++ reads it: the same array where it is so already.
py::array in_rows(const py::array& array, const char* type) {
  return py::module_::import("numpy").attr("require")(array, type, "CA");
}

}  // namespace

NumberArray numbers_in(const py::object& values, const std::string& what) {
  return in_rows(array_from(values, "fiu", what, "real numbers"), "float64");
}

IndexArray indices_in(const py::object& values, const std::string& what) {
  const py::array array = array_from(values, "iu", what, "integers");
  if (array.dtype().kind() == 'u' && array.itemsize() == 8 && array.size() > 0 &&
      py::bool_(array.attr("max")().attr("__gt__")(std::numeric_limits<std::int64_t>::max()))) {
    throw InputError(what, "has an index that is too large");
  }
  return in_rows(array, "int64");
}

std::int64_t integer_of(const py::handle& value, const std::string& what) {
  const py::object exact = PyBool_Check(value.ptr()) || py::isinstance<py::array>(value)
                               ? py::object()
                               : py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!exact) {
    PyErr_Clear();
    throw InputError(what, fmt::format("is of type {}; give an integer", type_of(value)));
  }
  int is_too_large = 0;
  const std::int64_t number = PyLong_AsLongLongAndOverflow(exact.ptr(), &is_too_large);
  if (is_too_large != 0) throw InputError(what, fmt::format("is too large: {}", py::str(exact).cast<std::string>()));
  return number;
}

bool is_truth_value(const py::handle& value) {
  return py::isinstance<py::bool_>(value) || is_scalar_of_numpy(value, "bool_");
}

bool can_be_asked(const Vec3& point) { return (point.array().abs() <= farthest_m).all(); }

std::span<const Vec3> points_in(const NumberArray& array, const std::string& what) {
  require_rows_of_three(array, what);
  return {reinterpret_cast<const Vec3*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

TriangleMesh mesh_of(const py::object& vertices, const py::object& triangles, const std::string& what) {
  const NumberArray coordinates = numbers_in(vertices, what + ": vertices");
  const IndexArray indices = indices_in(triangles, what + ": triangles");
  const std::span<const Vec3> points = points_in(coordinates, what + ": vertices");
  require_rows_of_three(indices, what + ": triangles");
  TriangleMesh mesh{{points.begin(), points.end()}, {}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) throw InputError(what, fmt::format("vertex {} is not finite; leave it out", i));
    if (!can_be_asked(points[i])) {
      throw InputError(what,
                       fmt::format("vertex {} is farther than {:g} m from the origin; give metres", i, farthest_m));
    }
  }
  const auto at = indices.unchecked<2>();
  for (py::ssize_t i = 0; i < indices.shape(0); ++i) {
    Triangle& triangle = mesh.triangles.emplace_back();
    for (int corner = 0; corner < 3; ++corner) {
      const std::int64_t vertex = at(i, corner);
      if (vertex < 0 || vertex >= std::ssize(points)) {
        throw InputError(
            what, fmt::format("triangle {} names vertex {}, and there are 0 to {}", i, vertex, std::ssize(points) - 1));
      }
      triangle[static_cast<std::size_t>(corner)] = static_cast<int>(vertex);
    }
  }
  return mesh;
}

py::array view_of(std::span<const Vec3> points, py::handle owner) {
  return read_only(
      py::array_t<double>({points.size(), std::size_t{3}}, reinterpret_cast<const double*>(points.data()), owner));
}

py::array view_of(std::span<const Triangle> triangles, py::handle owner) {
  return read_only(
      py::array_t<int>({triangles.size(), std::size_t{3}}, reinterpret_cast<const int*>(triangles.data()), owner));
}

py::array array_of(std::vector<Vec3> points) { return rows_in<double>(std::move(points)); }

py::array array_of(std::vector<Triangle> triangles) { return rows_in<int>(std::move(triangles)); }

py::array array_of(std::vector<Contact> contacts) { return records_in(std::move(contacts)); }

py::array array_of(std::vector<SurfaceAnswer> answers) { return records_in(std::move(answers)); }

py::array_t<double> matrices_of(std::span<const RigidMotion> poses) {
  py::array_t<double> matrices({poses.size(), std::size_t{4}, std::size_t{4}});
  auto at = matrices.mutable_unchecked<3>();
  for (py::ssize_t bone = 0; bone < std::ssize(poses); ++bone) {
    const RigidMotion& pose = poses[static_cast<std::size_t>(bone)];
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        at(bone, row, column) = row == 3      ? (column == 3 ? 1 : 0)
                                : column == 3 ? pose.translation_m[row]
                                              : pose.rotation(row, column);
      }
    }
  }
  return matrices;
}

std::vector<RigidMotion> poses_of(const NumberArray& matrices, std::size_t bones) {
  if (matrices.ndim() != 3 || matrices.shape(0) != static_cast<py::ssize_t>(bones) || matrices.shape(1) != 4 ||
      matrices.shape(2) != 4) {
    throw InputError("poses", fmt::format("has the shape {}; give one matrix a bone, of shape ({}, 4, 4)",
                                          shape_of(matrices), bones));
  }
  const auto at = matrices.unchecked<3>();
  std::vector<RigidMotion> poses(bones);
  for (std::size_t bone = 0; bone < bones; ++bone) {
    const auto i = static_cast<py::ssize_t>(bone);
    for (int row = 0; row < 3; ++row) {
      poses[bone].translation_m[row] = at(i, row, 3);
      for (int column = 0; column < 3; ++column) poses[bone].rotation(row, column) = at(i, row, column);
    }
    const Mat3& rotation = poses[bone].rotation;
    const bool is_rigid = (rotation * rotation.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-9 &&
                          rotation.determinant() > 0 && poses[bone].translation_m.allFinite() && at(i, 3, 0) == 0 &&
                          at(i, 3, 1) == 0 && at(i, 3, 2) == 0 && at(i, 3, 3) == 1;
    if (!is_rigid) {
      throw InputError(
          "poses",
          fmt::format("matrix {} is no rigid motion to 1e-9; give a rotation in float64, a translation in metres and "
                      "the last row 0 0 0 1",
                      bone));
    }
  }
  return poses;
}

std::map<std::string, ParameterValue> values_of(const py::dict& values, const std::string& what) {
  std::map<std::string, ParameterValue> converted;
  for (const auto& [key, value] : values) {
    const std::string name = py::str(key).cast<std::string>();
    converted[name] = value_of(value, what + "." + name);
  }
  return converted;
}

}  // namespace musclebench

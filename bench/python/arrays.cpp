#include "bench/python/arrays.hpp"

#include <cmath>
#include <memory>

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

ParameterValue value_of(const py::handle& value, const std::string& what) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (PyIndex_Check(value.ptr())) return py::int_(py::reinterpret_borrow<py::object>(value)).cast<std::int64_t>();
  if (PyFloat_Check(value.ptr())) return value.cast<double>();
  throw InputError(what, fmt::format("has a value of type {}; give a bool, a number or a string",
                                     py::str(py::type::of(value).attr("__name__")).cast<std::string>()));
}

}  // namespace

std::span<const Vec3> points_in(const PointArray& array, const std::string& what) {
  require_rows_of_three(array, what);
  return {reinterpret_cast<const Vec3*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

TriangleMesh mesh_of(const PointArray& vertices, const TriangleArray& triangles, const std::string& what) {
  const std::span<const Vec3> points = points_in(vertices, what + ": vertices");
  require_rows_of_three(triangles, what + ": triangles");
  TriangleMesh mesh{{points.begin(), points.end()}, {}};
  const auto* first = reinterpret_cast<const Triangle*>(triangles.data());
  mesh.triangles.assign(first, first + triangles.shape(0));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) throw InputError(what, fmt::format("vertex {} is not finite; leave it out", i));
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const int vertex : mesh.triangles[i]) {
      if (vertex >= 0 && vertex < std::ssize(mesh.vertices)) continue;
      throw InputError(what, fmt::format("triangle {} names vertex {}, and there are 0 to {}", i, vertex,
                                         std::ssize(mesh.vertices) - 1));
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

std::vector<RigidMotion> poses_of(const PointArray& matrices, std::size_t bones) {
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
      throw InputError("poses",
                       fmt::format("matrix {} is no rigid motion; give a rotation, a translation in metres and "
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

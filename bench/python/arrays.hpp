#pragma once

#include <cstdint>
#include <map>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <span>
#include <string>
#include <vector>

#include "core/base/parameters.hpp"
#include "core/contact/contact.hpp"
#include "core/contact/surface_queries.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

/// Numbers as Python gives them: arrays of doubles that are contiguous are read where they are, other numbers
/// converted.
using NumberArray = pybind11::array_t<double, pybind11::array::c_style>;
using IndexArray = pybind11::array_t<std::int64_t, pybind11::array::c_style>;

/// Throw InputError that names `what` for something else than real numbers or integers: complex ones, texts, masked
/// arrays, and for indices also fractions and truth values. Nothing at all is both.
NumberArray numbers_in(const pybind11::object& values, const std::string& what);
IndexArray indices_in(const pybind11::object& values, const std::string& what);

/// The rows of an array of shape (n, 3), where they are. Throws InputError that names `what` for another shape.
std::span<const Vec3> points_in(const NumberArray& array, const std::string& what);

/// Backends square coordinates, some in single precision: farther than this, in metres, no distance is asked for.
constexpr double farthest_m = 1e9;
/// Finite, and no farther than that.
bool can_be_asked(const Vec3& point);

/// A mesh from arrays of shape (n, 3) and (m, 3). Throws InputError that names `what` where an index is out of range or
/// a vertex not finite or too far.
TriangleMesh mesh_of(const pybind11::object& vertices, const pybind11::object& triangles, const std::string& what);

/// Views without a copy, which can't be written and keep `owner` alive.
pybind11::array view_of(std::span<const Vec3> points, pybind11::handle owner);
pybind11::array view_of(std::span<const Triangle> triangles, pybind11::handle owner);

/// Arrays over the memory that they are given: of shape (n, 3), or of records.
pybind11::array array_of(std::vector<Vec3> points);
pybind11::array array_of(std::vector<Triangle> triangles);
pybind11::array array_of(std::vector<Contact> contacts);
pybind11::array array_of(std::vector<SurfaceAnswer> answers);

/// Matrices of shape (n, 4, 4) from the rest frames of bones to the world frame, and back. Throws InputError where one
/// is no rigid motion, or their number is not `bones`.
pybind11::array_t<double> matrices_of(std::span<const RigidMotion> poses);
std::vector<RigidMotion> poses_of(const NumberArray& matrices, std::size_t bones);

/// An integer of Python or NumPy. Throws InputError that names `what` for another type, and where it is too large.
std::int64_t integer_of(const pybind11::handle& value, const std::string& what);

/// Of Python or NumPy.
bool is_truth_value(const pybind11::handle& value);

/// Throws InputError that names `what` for a value that is no bool, finite number or string.
std::map<std::string, ParameterValue> values_of(const pybind11::dict& values, const std::string& what);

}  // namespace musclebench

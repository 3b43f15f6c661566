#pragma once

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

/// Points as Python gives them. Arrays of doubles that are contiguous are read where they are; others are converted.
using PointArray = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;
using TriangleArray = pybind11::array_t<int, pybind11::array::c_style | pybind11::array::forcecast>;

/// The rows of an array of shape (n, 3), where they are. Throws InputError that names `what` for another shape.
std::span<const Vec3> points_in(const PointArray& array, const std::string& what);

/// A mesh from arrays of shape (n, 3) and (m, 3). Throws InputError that names `what` where an index is out of range or
/// a vertex not finite.
TriangleMesh mesh_of(const PointArray& vertices, const TriangleArray& triangles, const std::string& what);

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
std::vector<RigidMotion> poses_of(const PointArray& matrices, std::size_t bones);

/// Throws InputError that names `what` for a value that is no bool, number or string.
std::map<std::string, ParameterValue> values_of(const pybind11::dict& values, const std::string& what);

}  // namespace musclebench

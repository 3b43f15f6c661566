#pragma once

#include <pybind11/pybind11.h>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// The row of a backend that is written in Python.
///
/// `method` has `name`, `implementation` (whose code it is, version, licence), perhaps `parameters` (a dict, told in
/// results) and `build(name, vertices, triangles)`, called once a bone. That returns a structure with `bound_m`
/// (metres, or a pair: missed depth and false distance, see AnswerBound), perhaps `bytes`, and `detect(points)` with
/// points of shape (n, 3) in the bone's rest frame, in metres. It returns `(indices, depths_m, normals)` of the points
/// inside: ascending, at least 0, unit and outwards. What does not fit is an InputError.
///
/// It is called in one thread at a time. It tells no distance outside, so it has no clearance cache.
BackendEntry python_backend_entry(const pybind11::object& method);

}  // namespace musclebench

#pragma once

#include <pybind11/pybind11.h>

namespace musclebench {

/// Each adds a part of the module.
void bind_scene(pybind11::module_& module);
void bind_queries(pybind11::module_& module);
void bind_cases(pybind11::module_& module);

}  // namespace musclebench

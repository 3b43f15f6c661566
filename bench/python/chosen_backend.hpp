#pragma once

#include <memory>
#include <pybind11/pybind11.h>
#include <string>

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// A backend with its parameters, as Python names it.
struct ChosenBackend {
  std::shared_ptr<const BackendEntry> entry;
  Parameters parameters;
  bool is_python = false;
};

/// `backend`: a name of the table, or an object of Python that is a backend (see python_backend.hpp). `parameters`: a
/// dict or nothing. Throws InputError.
ChosenBackend choose_backend(const pybind11::object& backend, const pybind11::object& parameters);

}  // namespace musclebench

// The module musclebench.native. What a user sees is package/__init__.py; types are in package/native.pyi.
#include "bench/python/bindings.hpp"
#include "bench/results/build_info.hpp"
#include "bench/results/catalogue.hpp"
#include "core/base/unsupported_input.hpp"

namespace py = pybind11;

PYBIND11_MODULE(native, module) {
  using namespace musclebench;
  module.doc() = "Scenes, backends and measurements of musclebench. Lengths are in metres.";
  const auto& input_error = py::register_exception<InputError>(module, "InputError", PyExc_ValueError);
  input_error.doc() = "Input that the user can correct: one line with the place, what is wrong, and the cure.";
  py::register_exception<UnsupportedInput>(module, "UnsupportedInput", input_error).doc() =
      "Input that is right, but that this backend can't take: another one can.";
  module.def(
      "catalogue", [] { return catalogue().dump(); },
      "What this build has, as JSON: backends, effects, loop, presets, scenes (`musclebench list --json`).");
  bind_scene(module);
  bind_queries(module);
  bind_cases(module);
}

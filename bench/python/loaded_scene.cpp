#include "bench/python/loaded_scene.hpp"

#include <chrono>
#include <pybind11/pybind11.h>
#include <unistd.h>

#include "bench/cases/case.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

const pid_t first_process = getpid();

}  // namespace

void require_threads(int threads) {
  if (const std::string why = refusal_of_threads(threads); !why.empty()) throw InputError("threads", why);
  if (threads > 1 && getpid() != first_process) {
    throw InputError("threads",
                     "work only in the process that imported musclebench; start others by \"spawn\", not by "
                     "\"fork\"");
  }
}

std::unique_lock<InUse> wait_for(InUse& in_use) {
  constexpr std::chrono::milliseconds between_looks(100);
  std::unique_lock<InUse> lock(in_use, std::defer_lock);
  while (!lock.try_lock_for(between_looks)) {
    const pybind11::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }
  return lock;
}

}  // namespace musclebench

#pragma once

#include <functional>
#include <string>

#include "bench/hard/hard_case.hpp"

namespace musclebench {

/// Runs `work` in a process of its own, so that whatever becomes of it ends this cell only. A crash, a hang of more
/// than `seconds` and an exception that is no InputError break the cell. The process that calls has used no threads
/// yet: a fork keeps one of them only. Throws std::system_error where no process can be started.
HardCell run_in_process(const std::function<HardCell()>& work, double seconds);

/// A cell as one line of text, and back. Throws std::runtime_error for what is no such line.
std::string packed(const HardCell& cell);
HardCell unpacked(const std::string& text);

}  // namespace musclebench

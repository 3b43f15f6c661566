#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <string>

#include "bench/hard/hard_case.hpp"

namespace musclebench {

/// Runs `work` in a process of its own, so that whatever becomes of it ends this cell only; several may be at work at a
/// time. A crash, a hang of more than `seconds` and an exception that is no InputError break the cell. The process that
/// calls has used no threads yet: a fork keeps one of them only. Throws std::system_error where no process can be
/// started.
class CellProcess {
 public:
  CellProcess(const std::function<HardCell()>& work, double seconds);
  CellProcess(CellProcess&& other) noexcept;
  CellProcess(const CellProcess&) = delete;
  CellProcess& operator=(const CellProcess&) = delete;
  CellProcess& operator=(CellProcess&& other) noexcept;
  ~CellProcess();

  /// Waits for it. Once.
  HardCell result();

  /// Waits until one of them has a result, or has had its time; its index. There is at least one.
  static std::size_t wait_for_any(const std::deque<CellProcess>& at_work);

 private:
  double m_seconds;
  std::chrono::steady_clock::time_point m_deadline;
  int m_pipe = -1;
  int m_child = -1;  ///< -1: waited for, or another object's
};

/// One at a time.
inline HardCell run_in_process(const std::function<HardCell()>& work, double seconds) {
  return CellProcess(work, seconds).result();
}

/// A cell as one line of text, and back. Throws std::runtime_error for what is no such line.
std::string packed(const HardCell& cell);
HardCell unpacked(const std::string& text);

}  // namespace musclebench

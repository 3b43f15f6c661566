#pragma once

#include <chrono>
#include <cstdint>

namespace musclebench {

using Nanoseconds = std::int64_t;

inline Nanoseconds monotonic_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Adds the time from its construction to its destruction to `total_ns`.
class ScopedTimer {
 public:
  explicit ScopedTimer(Nanoseconds& total_ns) : m_total_ns(total_ns), m_start_ns(monotonic_now_ns()) {}
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;
  ~ScopedTimer() { m_total_ns += monotonic_now_ns() - m_start_ns; }

 private:
  Nanoseconds& m_total_ns;
  Nanoseconds m_start_ns;
};

}  // namespace musclebench

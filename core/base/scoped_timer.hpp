#pragma once

#include <chrono>
#include <cstdint>

namespace musclebench {

/// A duration in nanoseconds.
using Nanoseconds = std::int64_t;

/// Wall time in nanoseconds since an arbitrary start. It never runs backwards. Safe from several threads.
inline Nanoseconds monotonic_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Measures the wall time of a scope: the destructor adds it to `total_ns`, which must outlive the timer. Two threads
/// must not share one `total_ns`.
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

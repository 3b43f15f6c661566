#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace musclebench {

/// A spinning barrier for the threads of a team. Each thread counts its visits in its own cache line and reads those of
/// the others. It spins, because a wait is shorter than a system call. After a while it yields the core. With more
/// threads than cores it yields at once, because the thread that it waits for may need the core.
class Barrier {
 public:
  explicit Barrier(int threads)
      : m_seats(static_cast<std::size_t>(threads)), m_spins(spins(threads, std::thread::hardware_concurrency())) {}

  /// How often a thread reads another thread's visits before it yields the core. `cores` is 0 if unknown, which counts
  /// as enough.
  static int spins(int threads, unsigned cores) {
    return cores == 0 || static_cast<unsigned>(threads) <= cores ? spins_before_yielding : 0;
  }

  /// Call it before a team starts.
  void reset() {
    for (Seat& seat : m_seats) {
      seat.visits.store(0, std::memory_order_relaxed);
    }
  }

  /// Returns when all `threads` threads have arrived. `visit` counts the calls of this thread, from 1.
  void wait(int thread, int threads, unsigned visit) {
    m_seats[static_cast<std::size_t>(thread)].visits.store(visit, std::memory_order_release);
    for (int other = 0; other < threads; ++other) {
      const std::atomic<unsigned>& visits = m_seats[static_cast<std::size_t>(other)].visits;
      for (int spin = 0; visits.load(std::memory_order_acquire) < visit; ++spin) {
        if (spin < m_spins) {
          pause();
        } else {
          std::this_thread::yield();
        }
      }
    }
  }

 private:
  struct alignas(64) Seat {
    std::atomic<unsigned> visits = 0;
  };
  /// About 50 us. On a busy machine, a thread that yields gets its core back only after another process's time slice,
  /// which takes milliseconds.
  static constexpr int spins_before_yielding = 1000;

  /// Frees resources of the core for its other hardware thread; 10 to 50 ns.
  static void pause() {
#ifdef __x86_64__
    __builtin_ia32_pause();
#endif
  }

  std::vector<Seat> m_seats;
  int m_spins;
};

/// A member of a team of threads that run the same code, each on its share of the work. Each thread has its own object.
class Team {
 public:
  /// A range of indices from `first` to before `last`.
  struct Share {
    std::size_t first = 0;
    std::size_t last = 0;
  };

  /// A team of one.
  Team() = default;
  Team(int thread, int threads, Barrier& barrier) : m_thread(thread), m_threads(threads), m_barrier(&barrier) {}

  [[nodiscard]] bool is_first() const { return m_thread == 0; }
  /// This thread's range of `count` indices. The ranges of all threads cover all indices without overlap.
  [[nodiscard]] Share share(std::size_t count) const {
    const auto part = [&](int thread) {
      return count * static_cast<std::size_t>(thread) / static_cast<std::size_t>(m_threads);
    };
    return {part(m_thread), part(m_thread + 1)};
  }
  /// For a list whose entries are sorted by `row_of(entry)`: the entries whose rows are in this thread's share of all
  /// rows. If all stages use the same shares, a row stays in the cache of one core.
  template <typename RowOf>
  [[nodiscard]] Share share_by_row(std::size_t count, std::size_t row_count, const RowOf& row_of) const {
    const auto first_from = [&](std::size_t row) {
      std::size_t low = 0;
      std::size_t high = count;
      while (low < high) {
        const std::size_t middle = low + (high - low) / 2;
        if (static_cast<std::size_t>(row_of(middle)) < row) {
          low = middle + 1;
        } else {
          high = middle;
        }
      }
      return low;
    };
    const auto [first, last] = share(row_count);
    return {first_from(first), first_from(last)};
  }
  /// Returns when all threads of the team have called it. All then see what any of them wrote before.
  void wait() const {
    if (m_threads > 1) m_barrier->wait(m_thread, m_threads, ++m_visits);
  }

 private:
  int m_thread = 0;
  int m_threads = 1;
  Barrier* m_barrier = nullptr;
  mutable unsigned m_visits = 0;
};

}  // namespace musclebench

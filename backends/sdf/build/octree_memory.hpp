#pragma once

#include <cstddef>
#include <string>

namespace musclebench {

/// Watches what an octree takes of the memory while it is built, and guesses from it what the wanted error will take.
/// Refuses, with the error that fits, as early as it is certain enough.
class OctreeMemory {
 public:
  /// `max_error_m` is the wanted error; the builder aims at `aim_m`, which is a little less. `bytes`: that there are;
  /// 0: what this machine has.
  OctreeMemory(std::string bone, double max_error_m, double aim_m, std::size_t bytes);

  /// So many cells err by `p99_m`. `exhausted`: no more cells would mend anything. Throws InputError where the aim
  /// cannot be reached.
  void learn(std::size_t cells, double p99_m, bool exhausted);

  [[nodiscard]] bool has_room_for(std::size_t cells) const;

  /// Throws InputError: `cells` do not fit. Those that there are err by `p99_m`.
  [[noreturn]] void refuse(std::size_t cells, double p99_m) const;

  /// Throws InputError: it fits in no memory. What there is errs by `p99_m`.
  [[noreturn]] void refuse_any_size(double p99_m) const;

 private:
  [[nodiscard]] double growth_from(double p99_m) const;
  [[noreturn]] void refuse_bytes(double needed, double fitting_aim_m) const;

  std::string m_bone;
  double m_max_error_m;
  double m_aim_m;
  double m_available_bytes;

  /// Of the error, that memory grows with. Until it is learnt, as on scanned bones from 0.3 to 0.01 mm: 1.3 to 1.8.
  double m_growth_power = 1.5;
  int m_learnt_from = 0;
  double m_last_p99_m = 0;
  double m_last_bytes = 0;
};

}  // namespace musclebench

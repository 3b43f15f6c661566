#pragma once

#include <csignal>
#include <filesystem>

namespace musclebench {

/// While it lives, Ctrl-C and termination end the process at once with one line and exit code 130: for work that has
/// nothing on the disk yet but one temporary file. One at a time.
class EndAtOnce {
 public:
  EndAtOnce();
  EndAtOnce(const EndAtOnce&) = delete;
  EndAtOnce& operator=(const EndAtOnce&) = delete;
  ~EndAtOnce();

  /// The temporary file.
  void remove_first(const std::filesystem::path& file);
  /// From here on there is something worth keeping: the first signal only makes `is_stopped` true, so that the work can
  /// end and be written; the second ends the process at once.
  void stop_and_keep();
  [[nodiscard]] bool is_stopped() const;
};

/// Holds back Ctrl-C and termination while files are being moved.
class HeldSignals {
 public:
  HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;
  ~HeldSignals();
};

}  // namespace musclebench

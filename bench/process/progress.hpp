#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace musclebench {

/// Progress on standard error for work of more than two seconds: a bar with an ETA on a terminal; lines
/// `progress DONE TOTAL` for programs that ask for them.
class Progress {
 public:
  enum class Style : std::uint8_t { none, bar, lines };

  Progress(Style style, std::string label, int total);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  void show(int done);

 private:
  using Clock = std::chrono::steady_clock;

  Style m_style;
  std::string m_label;
  int m_total;
  Clock::time_point m_start;
  Clock::time_point m_last_shown;
  bool m_on_screen = false;
};

/// Lines when asked for, else a bar on a terminal.
Progress::Style progress_style(bool lines_wanted);

}  // namespace musclebench

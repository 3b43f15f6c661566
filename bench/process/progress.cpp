#include "bench/process/progress.hpp"

#include <cstdio>
#include <unistd.h>

#include <fmt/format.h>

namespace musclebench {

namespace {

constexpr std::chrono::milliseconds silence{2000};
constexpr std::chrono::milliseconds interval{200};
constexpr int bar_width = 30;

}  // namespace

Progress::Progress(Style style, std::string label, int total)
    : m_style(style), m_label(std::move(label)), m_total(total), m_start(Clock::now()), m_last_shown(m_start) {}

Progress::~Progress() {
  if (m_on_screen) {
    std::fputs("\r\033[K", stderr);
  }
}

void Progress::show(int done) {
  const Clock::time_point now = Clock::now();
  if (m_style == Style::none || now - m_last_shown < interval) {
    return;
  }
  if (m_style == Style::lines) {
    m_last_shown = now;
    fmt::print(stderr, "progress {} {}\n", done, m_total);
    return;
  }
  if (now - m_start < silence) {
    return;
  }
  m_last_shown = now;
  m_on_screen = true;
  const double part = static_cast<double>(done) / m_total;
  const double seconds = std::chrono::duration<double>(now - m_start).count();
  const int filled = static_cast<int>(part * bar_width);
  fmt::print(stderr, "\r\033[K{} [{:#<{}}{:.<{}}] {:3.0f} % ETA {:.0f} s", m_label, "", filled, "", bar_width - filled,
             100 * part, part > 0 ? seconds * (1 - part) / part : 0.0);
  std::fflush(stderr);
}

Progress::Style progress_style(bool lines_wanted) {
  if (lines_wanted) {
    return Progress::Style::lines;
  }
  return isatty(STDERR_FILENO) != 0 ? Progress::Style::bar : Progress::Style::none;
}

}  // namespace musclebench

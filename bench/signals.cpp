#include "bench/signals.hpp"

#include <unistd.h>

#include "bench/commands.hpp"

namespace musclebench {

namespace {

void end_at_once(int /*signal*/) {
  static constexpr char message[] = "\nmusclebench: interrupted; nothing was written\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message, sizeof message - 1);
  _exit(exit_interrupted);
}

}  // namespace

EndAtOnce::EndAtOnce() {
  std::signal(SIGINT, end_at_once);
  std::signal(SIGTERM, end_at_once);
}

EndAtOnce::~EndAtOnce() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

HeldSignals::HeldSignals() {
  sigset_t held;
  sigemptyset(&held);
  sigaddset(&held, SIGINT);
  sigaddset(&held, SIGTERM);
  sigprocmask(SIG_BLOCK, &held, &m_before);
}

HeldSignals::~HeldSignals() { sigprocmask(SIG_SETMASK, &m_before, nullptr); }

}  // namespace musclebench

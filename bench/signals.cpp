#include "bench/signals.hpp"

#include <string>
#include <unistd.h>

#include <climits>

#include "bench/commands.hpp"

namespace musclebench {

namespace {

/// A handler can be told nothing; this is what it removes.
char temporary_file[PATH_MAX] = "";

void end_at_once(int /*signal*/) {
  if (temporary_file[0] != '\0') {
    unlink(temporary_file);
  }
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
  temporary_file[0] = '\0';
}

void EndAtOnce::remove_first(const std::filesystem::path& file) {
  const HeldSignals held;
  const std::string name = std::filesystem::absolute(file).string();
  if (name.size() < sizeof temporary_file) {
    name.copy(temporary_file, name.size());
    temporary_file[name.size()] = '\0';
  }
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

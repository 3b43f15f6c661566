#include "bench/process/signals.hpp"

#include <string>
#include <unistd.h>

#include <climits>

#include "bench/process/exit_code.hpp"

namespace musclebench {

namespace {

/// A handler can be told nothing; this is what it removes.
char temporary_file[PATH_MAX] = "";

/// More than 0: files are being moved. A mask would not do: it holds for one thread, and the system may hand the signal
/// to another.
volatile std::sig_atomic_t held_count = 0;
volatile std::sig_atomic_t was_signalled = 0;

/// 1: the first signal stops the run. 2: it has come.
volatile std::sig_atomic_t stop_state = 0;

void say(const char* message, std::size_t length) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message, length);
}

void end_at_once(int /*signal*/) {
  if (held_count > 0) {
    was_signalled = 1;
    return;
  }
  if (stop_state == 1) {
    stop_state = 2;
    static constexpr char message[] = "\nmusclebench: interrupted; ends and keeps its rows (once more: at once)\n";
    say(message, sizeof message - 1);
    return;
  }
  if (temporary_file[0] != '\0') {
    unlink(temporary_file);
  }
  static constexpr char message[] = "\nmusclebench: interrupted; nothing was written\n";
  say(message, sizeof message - 1);
  _exit(exit_interrupted);
}

int end_at_once_count = 0;

void choose_handler() {
  const auto handler = end_at_once_count > 0 || held_count > 0 ? end_at_once : SIG_DFL;
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
}

}  // namespace

EndAtOnce::EndAtOnce() {
  ++end_at_once_count;
  choose_handler();
}

EndAtOnce::~EndAtOnce() {
  --end_at_once_count;
  stop_state = 0;
  choose_handler();
  temporary_file[0] = '\0';
}

void EndAtOnce::stop_and_keep() { stop_state = stop_state == 0 ? 1 : stop_state; }

bool EndAtOnce::is_stopped() const { return stop_state == 2; }

void EndAtOnce::remove_first(const std::filesystem::path& file) {
  const HeldSignals held;
  const std::string name = std::filesystem::absolute(file).string();
  if (name.size() < sizeof temporary_file) {
    name.copy(temporary_file, name.size());
    temporary_file[name.size()] = '\0';
  }
}

HeldSignals::HeldSignals() {
  held_count = held_count + 1;
  choose_handler();
}

HeldSignals::~HeldSignals() {
  held_count = held_count - 1;
  choose_handler();
  if (held_count == 0 && was_signalled != 0) {
    was_signalled = 0;
    std::raise(SIGTERM);
  }
}

}  // namespace musclebench

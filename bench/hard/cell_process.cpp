#include "bench/hard/cell_process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <poll.h>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

HardCell run_here(const std::function<HardCell()>& work) {
  try {
    return work();
  } catch (const InputError& refused) {
    return {Verdict::refused, refused.what(), {}};
  } catch (const std::exception& unexpected) {
    return {Verdict::breaks, fmt::format("unexpected failure: {}", unexpected.what()), {}};
  }
}

[[noreturn]] void run_as_child(const std::function<HardCell()>& work, int pipe, pid_t parent) {
  // Ends with the one that started it, however that ends.
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  (void)std::signal(SIGINT, SIG_DFL);
  (void)std::signal(SIGTERM, SIG_DFL);
  const std::string line = packed(run_here(work));
  for (std::size_t sent = 0; sent < line.size();) {
    const ssize_t now = write(pipe, line.data() + sent, line.size() - sent);
    if (now < 0 && errno != EINTR) _exit(1);
    if (now > 0) sent += static_cast<std::size_t>(now);
  }
  _exit(0);
}

/// All that is written into `pipe` until it is closed; false once `seconds` are over.
bool read_within(int pipe, double seconds, std::string& text) {
  const auto deadline = Clock::now() + std::chrono::duration<double>(seconds);
  std::array<char, 4096> part{};
  while (true) {
    const double left_ms = std::chrono::duration<double, std::milli>(deadline - Clock::now()).count();
    if (left_ms <= 0) return false;
    pollfd waited{pipe, POLLIN, 0};
    const int ready = poll(&waited, 1, static_cast<int>(std::min(left_ms + 1, 1e6)));
    if (ready < 0 && errno != EINTR) fail("poll");
    if (ready <= 0) continue;
    const ssize_t count = read(pipe, part.data(), part.size());
    if (count < 0 && errno != EINTR) fail("read");
    if (count == 0) return true;
    if (count > 0) text.append(part.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

HardCell run_in_process(const std::function<HardCell()>& work, double seconds) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) fail("pipe");
  (void)std::fflush(nullptr);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    fail("fork");
  }
  if (child == 0) {
    close(ends[0]);
    run_as_child(work, ends[1], parent);
  }
  close(ends[1]);
  std::string text;
  const bool is_in_time = read_within(ends[0], seconds, text);
  close(ends[0]);
  if (!is_in_time) (void)kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!is_in_time) return {Verdict::breaks, fmt::format("still at work after {:g} s", seconds), {}};
  if (WIFSIGNALED(status)) return {Verdict::breaks, fmt::format("ended by signal {}", strsignal(WTERMSIG(status))), {}};
  if (WEXITSTATUS(status) != 0) return {Verdict::breaks, fmt::format("exit code {}", WEXITSTATUS(status)), {}};
  return unpacked(text);
}

std::string packed(const HardCell& cell) {
  Json figures = Json::array();
  for (const HardFigure& figure : cell.figures) {
    // JSON has no NaN and no infinity.
    figures.push_back({figure.name, fmt::format("{}", figure.value), fmt::format("{}", figure.bar), figure.unit});
  }
  return Json{static_cast<int>(cell.verdict), cell.detail, figures}.dump(-1, ' ', false,
                                                                         Json::error_handler_t::replace);
}

HardCell unpacked(const std::string& text) {
  const Json json = Json::parse(text);
  HardCell cell{static_cast<Verdict>(json.at(0).get<int>()), json.at(1).get<std::string>(), {}};
  for (const Json& figure : json.at(2)) {
    cell.figures.push_back({figure.at(0).get<std::string>(), std::stod(figure.at(1).get<std::string>()),
                            std::stod(figure.at(2).get<std::string>()), figure.at(3).get<std::string>()});
  }
  return cell;
}

}  // namespace musclebench

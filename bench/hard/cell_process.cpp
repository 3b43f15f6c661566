#include "bench/hard/cell_process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

HardCell timed(const std::function<HardCell()>& work) {
  const auto start = Clock::now();
  HardCell cell = work();
  cell.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return cell;
}

HardCell run_here(const std::function<HardCell()>& work) {
  try {
    return timed(work);
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

/// All that is written into `pipe` until it is closed; false where that is not so at `deadline`.
bool read_until(Clock::time_point deadline, int pipe, std::string& text) {
  std::array<char, 4096> part{};
  while (true) {
    const double left_ms = std::chrono::duration<double, std::milli>(deadline - Clock::now()).count();
    pollfd waited{pipe, POLLIN, 0};
    const int ready = poll(&waited, 1, static_cast<int>(std::clamp(left_ms + 1, 0.0, 1e6)));
    if (ready < 0 && errno != EINTR) fail("poll");
    if (ready <= 0 && left_ms <= 0) return false;
    if (ready <= 0) continue;
    const ssize_t count = read(pipe, part.data(), part.size());
    if (count < 0 && errno != EINTR) fail("read");
    if (count == 0) return true;
    if (count > 0) text.append(part.data(), static_cast<std::size_t>(count));
  }
}

int status_of(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

CellProcess::CellProcess(const std::function<HardCell()>& work, double seconds)
    : m_seconds(seconds),
      m_deadline(Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds))) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) fail("pipe");
  (void)std::fflush(nullptr);
  const pid_t parent = getpid();
  m_child = fork();
  if (m_child < 0) {
    close(ends[0]);
    close(ends[1]);
    fail("fork");
  }
  if (m_child == 0) {
    close(ends[0]);
    run_as_child(work, ends[1], parent);
  }
  close(ends[1]);
  m_pipe = ends[0];
}

CellProcess::CellProcess(CellProcess&& other) noexcept
    : m_seconds(other.m_seconds),
      m_deadline(other.m_deadline),
      m_pipe(std::exchange(other.m_pipe, -1)),
      m_child(std::exchange(other.m_child, -1)) {}

CellProcess& CellProcess::operator=(CellProcess&& other) noexcept {
  std::swap(m_seconds, other.m_seconds);
  std::swap(m_deadline, other.m_deadline);
  std::swap(m_pipe, other.m_pipe);
  std::swap(m_child, other.m_child);
  return *this;
}

CellProcess::~CellProcess() {
  if (m_pipe >= 0) close(m_pipe);
  if (m_child < 0) return;
  (void)kill(m_child, SIGKILL);
  (void)status_of(m_child);
}

HardCell CellProcess::result() {
  std::string text;
  const bool is_in_time = read_until(m_deadline, m_pipe, text);
  if (!is_in_time) (void)kill(m_child, SIGKILL);
  const int status = status_of(std::exchange(m_child, -1));
  if (!is_in_time) return {Verdict::breaks, fmt::format("still at work after {:g} s", m_seconds), {}};
  if (WIFSIGNALED(status)) return {Verdict::breaks, fmt::format("ended by signal {}", strsignal(WTERMSIG(status))), {}};
  if (WEXITSTATUS(status) != 0) return {Verdict::breaks, fmt::format("exit code {}", WEXITSTATUS(status)), {}};
  return unpacked(text);
}

std::size_t CellProcess::wait_for_any(const std::deque<CellProcess>& at_work) {
  std::vector<pollfd> pipes;
  Clock::time_point deadline = Clock::time_point::max();
  for (const CellProcess& each : at_work) {
    pipes.push_back({each.m_pipe, POLLIN, 0});
    deadline = std::min(deadline, each.m_deadline);
  }
  while (true) {
    const double left_ms = std::chrono::duration<double, std::milli>(deadline - Clock::now()).count();
    const int ready = poll(pipes.data(), pipes.size(), static_cast<int>(std::clamp(left_ms + 1, 0.0, 1e6)));
    if (ready < 0 && errno != EINTR) fail("poll");
    if (ready < 0 || (ready == 0 && left_ms > 0)) continue;
    for (std::size_t i = 0; i < pipes.size(); ++i) {
      if (ready > 0 ? pipes[i].revents != 0 : at_work[i].m_deadline <= deadline) return i;
    }
  }
}

std::string packed(const HardCell& cell) {
  Json figures = Json::array();
  for (const HardFigure& figure : cell.figures) {
    // JSON has no NaN and no infinity.
    figures.push_back({figure.name, fmt::format("{}", figure.value), fmt::format("{}", figure.bar), figure.unit});
  }
  return Json{static_cast<int>(cell.verdict), cell.detail, figures, cell.seconds}.dump(-1, ' ', false,
                                                                                       Json::error_handler_t::replace);
}

HardCell unpacked(const std::string& text) {
  const Json json = Json::parse(text);
  HardCell cell{
      static_cast<Verdict>(json.at(0).get<int>()), json.at(1).get<std::string>(), {}, json.at(3).get<double>()};
  for (const Json& figure : json.at(2)) {
    cell.figures.push_back({figure.at(0).get<std::string>(), std::stod(figure.at(1).get<std::string>()),
                            std::stod(figure.at(2).get<std::string>()), figure.at(3).get<std::string>()});
  }
  return cell;
}

}  // namespace musclebench

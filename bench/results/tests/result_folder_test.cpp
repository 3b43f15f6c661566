#include "bench/results/result_folder.hpp"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/temporary_folder.hpp"

namespace musclebench {
namespace {

namespace fs = std::filesystem;

/// Takes away the parents of a result folder whenever they are empty, as another run does that made them.
class OtherRun {
 public:
  explicit OtherRun(fs::path parent)
      : m_thread([this, parent = std::move(parent)] {
          while (!m_stops) {
            if (rmdir(parent.c_str()) == 0) (void)rmdir(parent.parent_path().c_str());
            // Without a rest no one else would get a folder made on some file systems.
            std::this_thread::sleep_for(std::chrono::microseconds(100));
          }
        }) {}
  OtherRun(const OtherRun&) = delete;
  OtherRun& operator=(const OtherRun&) = delete;
  ~OtherRun() {
    m_stops = true;
    m_thread.join();
  }

 private:
  std::atomic<bool> m_stops = false;
  std::thread m_thread;
};

TEST(ResultFolder, IsMadeWhileAnotherRunTakesItsEmptyParentsAway) {
  const TemporaryFolder root;
  const fs::path folder = root / "new" / "x" / "r1";
  int failures = 0;
  {
    const OtherRun other(folder.parent_path());
    for (int run = 0; run < 1000; ++run) {
      try {
        require_writable(folder);
        write_result_folder(folder, [](const fs::path& part) { std::ofstream(part / "run.json") << "{}"; });
        failures += fs::exists(folder / "run.json") ? 0 : 1;
      } catch (const InputError&) {
        ++failures;
      }
      fs::remove_all(folder);
    }
  }
  EXPECT_EQ(failures, 0);
}

}  // namespace
}  // namespace musclebench

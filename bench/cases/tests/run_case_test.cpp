#include "bench/cases/run_case.hpp"

#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

class NoContacts final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {}; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> /*positions*/, std::span<const int> /*nodes*/,
                 std::vector<Contact>& /*contacts*/) override {}
};

/// Whether each frame is marked; as many of them as by default, unless told.
std::vector<bool> warm_up_of(int frames, std::optional<int> warm_up_frames = {}) {
  Scene scene;
  scene.muscle.mesh = make_sphere(0.1, 0);
  scene.loop.frames = frames;
  const BackendEntry entry{
      .name = "none", .help = "", .make = [](const Parameters& /*none*/) { return std::make_unique<NoContacts>(); }};
  RunCase run{{scene, entry, Parameters({}, {}, entry.name)}};
  run.judge = false;
  run.warm_up_frames = warm_up_frames.value_or(run.warm_up_frames);
  std::vector<bool> marked;
  for (const StepRecord& record : run_case(run, [](int /*frames*/) {}).records) {
    marked.push_back(record.warm_up);
  }
  return marked;
}

TEST(RunCase, MarksTheFirstFramesAsWarmUp) {
  EXPECT_EQ(warm_up_of(4), (std::vector<bool>{true, true, false, false}));
  EXPECT_EQ(warm_up_of(3, 0), (std::vector<bool>{false, false, false}));
  EXPECT_EQ(warm_up_of(2, 5), (std::vector<bool>{true, true}));
}

}  // namespace
}  // namespace musclebench

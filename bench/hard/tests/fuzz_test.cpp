#include "bench/hard/fuzz.hpp"

#include <set>

#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {
namespace {

const std::vector<std::string> usual_backends = {"bvh", "sdf"};

TEST(FuzzScene, IsFixedByItsSeed) {
  std::set<std::string> texts;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::string text = text_of(fuzz_scene(seed, usual_backends), "synthetic:", "");
    EXPECT_EQ(text, text_of(fuzz_scene(seed, usual_backends), "synthetic:", ""));
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), 20U);
}

TEST(FuzzScene, MostCanBeReadAndNoneThrowsAnythingElse) {
  int read = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    try {
      (void)read_fuzz_scene(fuzz_scene(seed, usual_backends));
      ++read;
    } catch (const InputError&) {
      // One line with the cure.
    }
  }
  EXPECT_GT(read, 15);
}

/// Without each piece in turn: what is left is a smaller scene, and in the end there is none.
TEST(FuzzScene, GetsSmallerUntilNothingCanBeLeftOut) {
  FuzzScene scene = fuzz_scene(3, usual_backends);
  int steps = 0;
  for (std::vector<FuzzScene> smaller = smaller_scenes(scene); !smaller.empty(); smaller = smaller_scenes(scene)) {
    scene = smaller.front();
    ASSERT_LT(++steps, 200);
  }
  EXPECT_EQ(scene.bones.size(), 1U);
  EXPECT_TRUE(scene.effects.empty());
  EXPECT_TRUE(scene.muscle.defect.empty());
}

}  // namespace
}  // namespace musclebench

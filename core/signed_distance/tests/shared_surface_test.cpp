#include "core/signed_distance/shared_surface.hpp"

#include <memory>

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

RepairedMesh shared_ball() { return {make_sphere(0.02, 3), false, {}}; }

TEST(SharedSurface, IsBuiltOnceForAllWhoAsk) {
  const RepairedMesh surface = shared_ball();
  const SharedSurface shared;
  const TriangleBvh* tree = &shared.tree(surface);
  EXPECT_EQ(&shared.tree(surface), tree);
  const SignedSurface* exact = &shared.signed_distance(surface);
  EXPECT_EQ(&shared.signed_distance(surface), exact);
  EXPECT_EQ(&shared.tree(surface), &exact->tree()) << "the tree has moved into the signed distance";
  EXPECT_EQ(shared.kept_signed_distance(surface).get(), exact);
}

TEST(SharedSurface, WhatIsKeptOutlivesTheRelease) {
  const RepairedMesh surface = shared_ball();
  const SharedSurface shared;
  const std::shared_ptr<const SignedSurface> kept = shared.kept_signed_distance(surface);
  EXPECT_EQ(kept.use_count(), 2);
  shared.release();
  EXPECT_EQ(kept.use_count(), 1);
  EXPECT_TRUE(kept->locate(Vec3::Zero()).inside);
  EXPECT_NE(&shared.signed_distance(surface), kept.get()) << "built anew";
}

TEST(SharedSurface, ACopyStartsEmpty) {
  const RepairedMesh surface = shared_ball();
  const SharedSurface shared;
  const SignedSurface* exact = &shared.signed_distance(surface);
  const SharedSurface copy(shared);  // NOLINT(performance-unnecessary-copy-initialization): it is what is tested
  EXPECT_NE(&copy.signed_distance(surface), exact);
  EXPECT_EQ(&shared.signed_distance(surface), exact);
}

TEST(SharedSurface, WhatOthersBuiltIsPaidOnceByWhoAsks) {
  const RepairedMesh surface = shared_ball();
  const SharedSurface shared;
  shared.start_accounting();
  (void)shared.signed_distance(surface);
  EXPECT_EQ(shared.reused_build_ns(), 0) << "the caller built it, and its own clock ran";
  shared.start_accounting();
  EXPECT_EQ(shared.reused_build_ns(), 0) << "nobody has asked yet";
  (void)shared.tree(surface);
  const Nanoseconds tree_ns = shared.reused_build_ns();
  EXPECT_GT(tree_ns, 0);
  (void)shared.tree(surface);
  EXPECT_EQ(shared.reused_build_ns(), tree_ns);
  (void)shared.signed_distance(surface);
  const Nanoseconds both_ns = shared.reused_build_ns();
  EXPECT_GT(both_ns, tree_ns);
  (void)shared.signed_distance(surface);
  EXPECT_EQ(shared.reused_build_ns(), both_ns);
}

}  // namespace
}  // namespace musclebench

// Bullet's reader of Discregrid's format, which shares no code with ours.
#include <BulletCollision/CollisionShapes/btMiniSDF.h>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/files/discregrid_file.hpp"
#include "core/base/random_numbers.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

btMiniSDF read_with_bullet(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string content((std::istreambuf_iterator<char>(in)), {});
  btMiniSDF bullet;
  bullet.load(content.data(), static_cast<int>(content.size()));
  return bullet;
}

TEST(DiscregridFile, SaysTheSameToBullet) {
  // Unequal edges and counts, so that no axis can stand for another.
  const RepairedMesh bone{make_box({0.1, 0.06, 0.04}, 3), true, {}};
  GridShape shape = grid_over(bone.mesh, {.cells = 7}, "box");
  shape.cells = {7, 5, 4};
  shape.cell_size_m = shape.cell_size_m.cwiseProduct(Vec3(1, 7.0 / 5, 7.0 / 4));
  const CubicField field = build_field(SignedSurface(bone), shape, 1);
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "field.cdf";
  write_discregrid(field, path);
  const btMiniSDF bullet = read_with_bullet(path);
  ASSERT_TRUE(bullet.isValid());
  RandomNumbers random(1);
  for (int i = 0; i < 5000; ++i) {
    const double x = random.share();
    const double y = random.share();
    const Vec3 share(x, y, random.share());
    const Vec3 point = shape.lower_m + share.cwiseProduct(shape.upper_m() - shape.lower_m);
    double value = 0;
    btVector3 gradient;
    ASSERT_TRUE(bullet.interpolate(0, value, {point[0], point[1], point[2]}, &gradient));
    const FieldSample ours = field.sample(point).value();
    constexpr double rounding = 1e-13;
    EXPECT_NEAR(value, ours.value_m, 0.1 * rounding);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(gradient[axis], ours.gradient[axis], 100 * rounding);
    }
  }
}

}  // namespace
}  // namespace musclebench

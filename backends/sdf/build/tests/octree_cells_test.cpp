#include "backends/sdf/build/octree_cells.hpp"

#include <gtest/gtest.h>

#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

constexpr double half_edge_m = 0.008;
constexpr double every_threshold_m3 = 0;
constexpr double no_threshold_m3 = 1;

/// A cell at the surface of a ball, and its neighbours.
class OctreeCells : public testing::Test {
 protected:
  [[nodiscard]] OctreeCell cell(const Vec3& offset = Vec3::Zero()) {
    return m_maker.root(Vec3(0.05, 0.001, 0.002) + offset, half_edge_m, m_block);
  }
  [[nodiscard]] std::array<OctreeCell, 8> split(OctreeCell parent, const NeighbourChildren& neighbours = {},
                                                double threshold_m3 = every_threshold_m3) {
    std::array<OctreeCell, 8> children;
    m_maker.split(parent, neighbours, threshold_m3, children, m_block);
    return children;
  }
  [[nodiscard]] const OctreeCellMaker& maker() const { return m_maker; }

 private:
  RepairedMesh m_ball{make_sphere(0.05, 3), true, {}};
  SignedSurface m_surface{m_ball};
  OctreeCellMaker m_maker{m_surface, {.wanted_m = 1e-4, .near_m = 0.02, .finest_edge_m = 1e-5}};
  SampleBlock m_block{m_surface};
};

TEST_F(OctreeCells, ChildrenTakeWhatThoseOfNeighboursKnowOfTheCommonFace) {
  const std::array<OctreeCell, 8> alone = split(cell());
  for (std::size_t face = 0; face < 6; ++face) {
    const auto axis = static_cast<Eigen::Index>(face / 2);
    const double side = face % 2 == 0 ? -1 : 1;
    std::array<OctreeCell, 8> beyond = split(cell(2 * side * half_edge_m * Vec3::Unit(axis)));
    constexpr double mark_m = 1;
    for (OctreeCell& child : beyond) {
      for (DistanceSample& sample : child.leaf->samples) {
        sample.value_m += mark_m;
      }
    }
    NeighbourChildren neighbours{};
    neighbours[face] = beyond.data();
    const std::array<OctreeCell, 8> children = split(cell(), neighbours);
    for (std::size_t octant = 0; octant < 8; ++octant) {
      for (std::size_t s = 0; s < lattice_samples; ++s) {
        const Vec3 in_parent = sample_position(lattice_samples + octant) + 0.5 * sample_position(s);
        const bool parent_knows = in_parent == in_parent.array().round().matrix();
        const bool taken = in_parent[axis] == side && !parent_knows;
        EXPECT_NEAR(children[octant].leaf->samples[s].value_m,
                    alone[octant].leaf->samples[s].value_m + (taken ? mark_m : 0), 1e-12)
            << "face " << face << ", octant " << octant << ", sample " << s;
      }
    }
  }
}

TEST_F(OctreeCells, AsksForWhatANeighboursChildKnowsNoMore) {
  const std::array<OctreeCell, 8> alone = split(cell());
  std::array<OctreeCell, 8> beyond = split(cell(2 * half_edge_m * Vec3::UnitX()));
  for (OctreeCell& child : beyond) {
    child.leaf.reset();
  }
  NeighbourChildren neighbours{};
  neighbours[1] = beyond.data();
  const std::array<OctreeCell, 8> children = split(cell(), neighbours);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    for (std::size_t s = 0; s < lattice_samples; ++s) {
      EXPECT_EQ(children[octant].leaf->samples[s].value_m, alone[octant].leaf->samples[s].value_m);
      EXPECT_GE(children[octant].leaf->samples[s].triangle, 0);
    }
  }
}

TEST_F(OctreeCells, CubicPolynomialsAreFittedWhenAThresholdMayTakeThemAndAreTheSameThen) {
  const std::array<OctreeCell, 8> early = split(cell());
  std::array<OctreeCell, 8> late = split(cell(), {}, no_threshold_m3);
  for (std::size_t octant = 0; octant < 8; ++octant) {
    EXPECT_TRUE(early[octant].has_cubic);
    EXPECT_FALSE(early[octant].lacks_cubic(every_threshold_m3));
    EXPECT_FALSE(late[octant].has_cubic);
    EXPECT_FALSE(late[octant].lacks_cubic(no_threshold_m3));
    EXPECT_FALSE(late[octant].takes_cubic(no_threshold_m3));
    ASSERT_TRUE(late[octant].lacks_cubic(every_threshold_m3));
    maker().fit_cubic(late[octant]);
    EXPECT_EQ(late[octant].cubic_indicator_m3, early[octant].cubic_indicator_m3);
    EXPECT_LT(late[octant].cubic_indicator_m3, late[octant].quadratic_indicator_m3);
    EXPECT_EQ(late[octant].leaf->cubic.coefficients, early[octant].leaf->cubic.coefficients);
  }
}

}  // namespace
}  // namespace musclebench

#include "backends/sdf/octree/octree_kernel.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "backends/sdf/grid/tests/query_positions.hpp"
#include "backends/sdf/octree/octree_entry.hpp"
#include "backends/sdf/octree/octree_field.hpp"
#include "backends/sdf/octree/octree_polynomial.hpp"
#include "core/base/random_numbers.hpp"

namespace musclebench {
namespace {

using octree_entry::Kind;

OctreeQuality reaching_little() {
  OctreeQuality quality;
  quality.sign_error_distance_m = 0.01;
  quality.excess_m = 0.005;
  return quality;
}

/// A tree and polynomials without any pattern, in which leaves of all kinds and sizes are neighbours.
class NoisyTree {
 public:
  static constexpr int levels = 5;

  explicit NoisyTree(const OctreeShape& shape) {
    m_entries.resize(shape.root_count());
    for (std::size_t root = 0; root < shape.root_count(); ++root) {
      fill(root, 0);
    }
    m_coefficients.resize(m_coefficients.size() + cubic_terms);
  }

  [[nodiscard]] OctreeField field(const OctreeShape& shape, const OctreeQuality& quality = reaching_little()) const {
    return {shape, quality, m_entries, m_coefficients};
  }

 private:
  void fill(std::size_t entry, int level) {
    if (level < levels && m_random.share() < 0.4) {
      const std::size_t first = m_entries.size();
      m_entries[entry] = octree_entry::entry(Kind::split, first);
      m_entries.resize(first + 8);
      for (std::size_t octant = 0; octant < 8; ++octant) {
        fill(first + octant, level + 1);
      }
      return;
    }
    const Kind kind = std::array{Kind::outside, Kind::quadratic, Kind::cubic}[m_random.below(3)];
    m_entries[entry] = octree_entry::entry(kind, m_coefficients.size());
    const std::size_t terms = kind == Kind::outside ? 1 : kind == Kind::quadratic ? quadratic_terms : cubic_terms;
    for (std::size_t term = 0; term < terms; ++term) {
      m_coefficients.push_back(static_cast<float>(m_random.share() - (kind == Kind::outside ? -1 : 0.5)));
    }
  }

  RandomNumbers m_random{21};
  std::vector<std::uint32_t> m_entries;
  std::vector<float> m_coefficients;
};

OctreeShape shape() { return {Vec3(-0.3, 0.1, 0.2), 0.125, {5, 3, 4}}; }

const OctreeField& noisy_field() {
  static const OctreeField made = NoisyTree(shape()).field(shape());
  return made;
}

struct Answer {
  Vec3 roots;
  double value_m;
  Vec3 slope;
  double clearance_m;
};

/// By node.
std::vector<std::optional<Answer>> query_all(const OctreeField& field, const RigidMotion& pose,
                                             const std::vector<Vec3>& positions, std::span<const int> nodes) {
  const CellMap map(field.shape().grid(), pose);
  std::vector<std::optional<Answer>> answers(positions.size());
  FieldBlock block;
  LeafBlock leaves;
  FieldBlock::Lanes<double> clearance_m;
  for (std::size_t next = 0; next < nodes.size();) {
    block.count = 0;
    const std::size_t first = next;
    next = field.sample(map, positions, nodes, next, block, leaves);
    field.clear(block, leaves, clearance_m);
    EXPECT_GT(next, first);
    for (std::size_t n = 0; n < block.count; ++n) {
      EXPECT_TRUE(block.query[n] >= first && block.query[n] < next);
      answers[static_cast<std::size_t>(nodes[block.query[n]])] =
          Answer{block.cells(n), block.value_m[n], block.slope(n), clearance_m[n]};
    }
  }
  return answers;
}

void expect_equal(const std::optional<Answer>& one, const std::optional<Answer>& other) {
  ASSERT_EQ(one.has_value(), other.has_value());
  if (one) {
    ASSERT_EQ(one->roots, other->roots);
    ASSERT_EQ(one->value_m, other->value_m);
    ASSERT_EQ(one->slope, other->slope);
    ASSERT_EQ(one->clearance_m, other->clearance_m);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(std::signbit(one->slope[axis]), std::signbit(other->slope[axis]));
    }
  }
}

struct PlainLeaf {
  std::uint32_t entry;
  Vec3 at;
  double half_edge_m;
};

/// The leaf at a point in edges of roots, by halving.
PlainLeaf plain_leaf(const OctreeField& field, Vec3 at) {
  std::array<std::size_t, 3> root{};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    root[a] = static_cast<std::size_t>(std::min(std::floor(at[axis]), field.shape().roots[a] - 1.0));
    at[axis] -= static_cast<double>(root[a]);
  }
  PlainLeaf leaf{field.entries()[field.shape().root_grid().index(root)], at, 0.5 * field.shape().root_edge_m};
  while (octree_entry::kind_of(leaf.entry) == Kind::split) {
    std::size_t octant = 0;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const bool upper = leaf.at[axis] >= 0.5;
      leaf.at[axis] = 2 * leaf.at[axis] - (upper ? 1 : 0);
      octant |= static_cast<std::size_t>(upper) << axis;
    }
    leaf.half_edge_m *= 0.5;
    leaf.entry = field.entries()[octree_entry::offset_of(leaf.entry) + octant];
  }
  leaf.at = 2 * leaf.at - Vec3::Ones();
  return leaf;
}

/// Against plain code.
void expect_leaf(const OctreeField& field, const Answer& answer) {
  const PlainLeaf leaf = plain_leaf(field, answer.roots);
  const float* coefficients = field.coefficients().data() + octree_entry::offset_of(leaf.entry);
  Vec3 slope;
  double value_m = 0;
  if (octree_entry::kind_of(leaf.entry) == Kind::outside) {
    value_m = coefficients[0] - leaf.half_edge_m * leaf.at.norm();
    slope = -leaf.half_edge_m * leaf.at.normalized();
  } else {
    value_m = octree_entry::kind_of(leaf.entry) == Kind::cubic
                  ? evaluate_polynomial<true>(coefficients, leaf.at, slope)
                  : evaluate_polynomial<false>(coefficients, leaf.at, slope);
  }
  EXPECT_NEAR(answer.value_m, value_m, 1e-14);
  EXPECT_NEAR((answer.slope * leaf.half_edge_m - slope).norm(), 0, 1e-13);
}

TEST(OctreeKernel, EvaluatesWhatTheLeavesSay) {
  const std::vector<Vec3> positions = positions_about(shape().grid(), oblique_pose(), 5000);
  const auto answers = query_all(noisy_field(), oblique_pose(), positions, all_of(positions));
  std::size_t found = 0;
  for (std::size_t n = 0; n < positions.size(); ++n) {
    const Vec3 roots = (oblique_pose().apply_inverse(positions[n]) - shape().lower_m) / shape().root_edge_m;
    ASSERT_EQ(answers[n].has_value(), shape().grid().contains(roots)) << n;
    if (answers[n]) {
      ++found;
      EXPECT_NEAR((answers[n]->roots - roots).norm(), 0, 1e-13);
      expect_leaf(noisy_field(), *answers[n]);
    }
  }
  EXPECT_GT(found, 2000U);
  EXPECT_LT(found, 4000U);
}

TEST(OctreeKernel, KnowsTheBordersOfLeavesAndOfTheDomain) {
  // Roots of 1 m, so that borders are hit to the bit.
  const OctreeShape exact{Vec3::Zero(), 1, {5, 3, 4}};
  const OctreeField field = NoisyTree(exact).field(exact);
  RandomNumbers random(4);
  std::vector<Vec3> positions;
  constexpr std::size_t finest = std::size_t{1} << NoisyTree::levels;
  const auto border = [&](std::size_t roots) {
    const double at = static_cast<double>(random.below(roots * finest + 1)) / static_cast<double>(finest);
    return random.below(2) == 0 ? at : std::nextafter(at, random.below(2) == 0 ? -1.0 : 9.0);
  };
  for (int n = 0; n < 3000; ++n) {
    const double x = border(5), y = border(3);
    positions.emplace_back(x, y, border(4));
  }
  const auto answers = query_all(field, {}, positions, all_of(positions));
  std::size_t beyond = 0;
  for (std::size_t n = 0; n < positions.size(); ++n) {
    ASSERT_EQ(answers[n].has_value(), exact.grid().contains(positions[n])) << positions[n].transpose();
    beyond += answers[n] ? 0 : 1;
    if (answers[n]) {
      expect_leaf(field, *answers[n]);
    }
  }
  EXPECT_GT(beyond, 30U);
}

/// Of each leaf for itself: neighbours know nothing of each other here, so only their own clearance is right.
TEST(OctreeKernel, ALeafIsPositiveWithinItsClearance) {
  OctreeQuality quality;
  quality.sign_error_distance_m = 1e9;
  const OctreeField field = NoisyTree(shape()).field(shape(), quality);
  RandomNumbers random(31);
  int clear = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto share = [&] {
      const double x = random.share(), y = random.share();
      return Vec3(x, y, random.share());
    };
    const Vec3 point = shape().lower_m + share().cwiseProduct(shape().upper_m() - shape().lower_m);
    const double radius_m = field.clearance_m(point);
    clear += radius_m > 0 ? 1 : 0;
    const std::uint32_t leaf = plain_leaf(field, (point - shape().lower_m) / shape().root_edge_m).entry;
    const bool outside = octree_entry::kind_of(leaf) == Kind::outside;
    ASSERT_TRUE(outside || radius_m == 0 || field.value(point) > 0);
    for (int j = 0; radius_m > 0 && j < 20; ++j) {
      const Vec3 there = point + radius_m * (2 * share() - Vec3::Ones()).normalized();
      ASSERT_EQ(plain_leaf(field, (there - shape().lower_m) / shape().root_edge_m).entry, leaf);
      ASSERT_TRUE(outside || *field.value(there) >= 0) << *field.value(there);
    }
  }
  EXPECT_GT(clear, 1000);
}

TEST(OctreeKernel, AnAnswerDoesNotDependOnWhoElseAsks) {
  const std::vector<Vec3> positions = positions_about(shape().grid(), oblique_pose(), 400);
  const std::vector<int> nodes = all_of(positions);
  const auto together = query_all(noisy_field(), oblique_pose(), positions, nodes);
  for (const std::size_t length : {0U, 1U, 2U, 3U, 5U, 7U, 8U, 9U, 127U, 128U, 129U, 300U}) {
    const std::size_t first = 11 + length / 5;
    const auto some = query_all(noisy_field(), oblique_pose(), positions, std::span(nodes).subspan(first, length));
    for (std::size_t n = 0; n < positions.size(); ++n) {
      expect_equal(some[n], n >= first && n < first + length ? together[n] : std::nullopt);
    }
  }
  for (const int node : nodes) {
    const auto alone = query_all(noisy_field(), oblique_pose(), positions, {&node, 1});
    expect_equal(alone[static_cast<std::size_t>(node)], together[static_cast<std::size_t>(node)]);
  }
}

/// A quadratic polynomial that is computed beside a cubic one is computed as if it were one.
TEST(OctreeKernel, AZeroHasTheSameSignWhoeverElseAsks) {
  const OctreeShape two{Vec3::Zero(), 1, {2, 1, 1}};
  std::vector<float> coefficients(quadratic_terms + 2 * cubic_terms, 0.5F);
  std::fill_n(coefficients.begin(), quadratic_terms, -0.0F);
  const OctreeField field(two, {},
                          {octree_entry::entry(Kind::quadratic, 0), octree_entry::entry(Kind::cubic, quadratic_terms)},
                          coefficients);
  const std::vector<Vec3> positions{Vec3::Constant(0.75), Vec3(1.5, 0.5, 0.5)};
  const std::vector<int> nodes{0, 1};
  const auto together = query_all(field, {}, positions, nodes);
  const auto alone = query_all(field, {}, positions, std::span(nodes).first(1));
  ASSERT_EQ(together[0]->value_m, 0);
  EXPECT_EQ(std::signbit(together[0]->value_m), std::signbit(alone[0]->value_m));
  expect_equal(together[0], alone[0]);
}

/// Every kind of SIMD that this machine has gives the same bits as the one without.
TEST(OctreeKernel, GivesTheSameBitsOnEveryMachine) {
  const std::vector<Vec3> positions = positions_about(shape().grid(), oblique_pose(), 3000);
  std::optional<std::vector<std::optional<Answer>>> expected;
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
    hwy::GetChosenTarget().Update(rest & -rest);
    const auto answers = query_all(noisy_field(), oblique_pose(), positions, all_of(positions));
    hwy::GetChosenTarget().DeInit();
    if (!expected) {
      expected = answers;
    }
    for (std::size_t n = 0; n < positions.size(); ++n) {
      expect_equal(answers[n], (*expected)[n]);
    }
  }
}

TEST(OctreeKernel, ALeafBendsDownFromWhereItIsFlat) {
  const OctreeShape one{Vec3::Zero(), 2, {1, 1, 1}};
  OctreeQuality quality;
  quality.sign_error_distance_m = 1e9;
  for (const auto& [kind, term, zero] :
       {std::tuple(Kind::quadratic, 4, std::sqrt(0.1)), std::tuple(Kind::cubic, 4, std::sqrt(0.1)),
        std::tuple(Kind::cubic, 10, std::cbrt(0.1))}) {
    std::vector<float> coefficients(2 * cubic_terms, 0);
    coefficients[0] = 0.1F;
    coefficients[static_cast<std::size_t>(term)] = -1;
    const double clearance_m =
        OctreeField(one, quality, {octree_entry::entry(kind, 0)}, coefficients).clearance_m(Vec3::Ones());
    EXPECT_LE(clearance_m, zero * (1 + 1e-7));
    EXPECT_GT(clearance_m, 0.3 * zero);
  }
}

/// In leaves without a slope there is no direction to go farther out.
TEST(OctreeKernel, AFlatFieldIsAsClearAsItsSamplesSay) {
  const OctreeShape one{Vec3::Zero(), 1, {1, 1, 1}};
  std::vector<float> coefficients(2 * cubic_terms, 0);
  coefficients[0] = 0.9F;
  OctreeQuality quality;
  quality.sign_error_distance_m = 0.2;
  quality.excess_m = 0.1;
  for (const Kind kind : {Kind::quadratic, Kind::cubic}) {
    const OctreeField field(one, quality, {octree_entry::entry(kind, 0)}, coefficients);
    EXPECT_NEAR(field.clearance_m({0.5, 0.5, 0.5}), 0.6, 1e-7);
    EXPECT_NEAR(field.clearance_m({0.6, 0.5, 0.5}), 0.5, 1e-7);
    EXPECT_NEAR(field.clearance_m({1, 0, 1}), 0.6, 1e-7);
  }
  const OctreeField outside(one, quality, {octree_entry::entry(Kind::outside, 0)}, coefficients);
  EXPECT_NEAR(outside.clearance_m({0.5, 0.5, 0.5}), 0.7, 1e-7);
  EXPECT_NEAR(outside.clearance_m({0.6, 0.5, 0.5}), 0.6, 1e-7);
  EXPECT_NEAR(outside.clearance_m({1.5, 0.5, 0.5}), 0.5, 1e-7);
}

}  // namespace
}  // namespace musclebench

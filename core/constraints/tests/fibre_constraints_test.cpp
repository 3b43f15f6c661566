#include "core/constraints/fibre_constraints.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

/// The curves as they were published (Thelen 2003, equations 2, 3, 6 and 7), of fully active muscle; `length` over the
/// optimal one, `speed` over the fastest, > 0 where the fibre is stretched.
double published_active(double length) { return std::exp(-(length - 1) * (length - 1) / 0.45); }
double published_passive(double length) {
  return length <= 1 ? 0 : (std::exp(5 * (length - 1) / 0.6) - 1) / (std::exp(5) - 1);
}
/// The force at which the published speed is `speed`, found by halving.
double published_over_speed(double speed) {
  const auto speed_at = [](double force) {
    const double b = force <= 1 ? 1 + force / 0.25 : (2 + 2 / 0.25) * (1.4 - force) / (1.4 - 1);
    return (force - 1) / b;
  };
  double low = 0, high = 1.4 - 1e-12;
  for (int i = 0; i < 100; ++i) (speed_at(0.5 * (low + high)) < speed ? low : high) = 0.5 * (low + high);
  return low;
}

/// Two triangles that share the volume of a square sheet of 1 m, whose fibres run along x.
class Sheet {
 public:
  explicit Sheet(const FibreLaw& law, double inverse_mass = 0, double activation = 1)
      : m_inverse_mass(inverse_mass),
        m_bodies({{"sheet", 0, 4, 0, 2, activation}}),
        m_constraints(constraints(), m_bodies, m_order, law) {}

  /// A substep at whose start the sheet has the one stretch, and at whose end the other. The nominal stress, Pa, that
  /// the fibres pulled with.
  double stress_pa(double stretch, double next, double activation, double step_s = time_step) {
    NodeRows rows = rows_at(stretch);
    m_constraints.forget_pulls();
    m_constraints.begin_substep(rows, activation, step_s, Team());
    rows = rows_at(next);
    m_constraints.project(rows, step_s, Team());
    return m_constraints.pulls_n_m_s()[0] / (volume_m3 * step_s);
  }

  static constexpr double volume_m3 = 0.01;
  static constexpr double time_step = 1e-5;

 private:
  static std::vector<FibreConstraint> constraints() {
    return {{{0, 1, 2}, {-1, 1, 0}, 0.5 * volume_m3}, {{0, 2, 3}, {0, 1, -1}, 0.5 * volume_m3}};
  }
  [[nodiscard]] NodeRows rows_at(double stretch) const {
    const std::vector<Vec3> at = {{0, 0, 0}, {stretch, 0, 0}, {stretch, 1, 0}, {0, 1, 0}};
    return {m_order, at, std::vector<double>(4, m_inverse_mass)};
  }

  double m_inverse_mass;
  std::vector<Vec3> m_rest = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<Body> m_bodies;
  NodeOrder m_order{m_rest, m_bodies};
  FibreConstraints m_constraints;
};

TEST(FibreConstraints, BearWhatWasPublishedAtAnyLength) {
  for (const double optimal : {1.0, 1.4, 0.8}) {
    for (const double activation : {0.0, 0.05, 1.0}) {
      FibreLaw law;
      law.optimal_stretch = optimal;
      for (double stretch = 0.4; stretch < 1.6 * optimal; stretch += 0.05) {
        Sheet sheet(law);
        const double length = stretch / optimal;
        const double wanted = activation * published_active(length) + published_passive(length);
        EXPECT_NEAR(sheet.stress_pa(stretch, stretch, activation) / law.peak_stress_pa, wanted, 1e-8)
            << optimal << " " << activation << " " << stretch;
      }
    }
  }
}

TEST(FibreConstraints, OfAMuscleWithAShareOfTheActivationBearAsIfThatWereAll) {
  const FibreLaw law;
  for (const double share : {0.0, 0.25, 1.0}) {
    Sheet shared(law, 1, share);
    Sheet alone(law, 1);
    for (const double stretch : {1.0, 1.01, 0.99}) {
      EXPECT_EQ(shared.stress_pa(stretch, stretch, 0.5), alone.stress_pa(stretch, stretch, 0.5 * share)) << share;
    }
  }
}

TEST(FibreConstraints, BearLessTheFasterTheyShortenAndMoreWhereTheyAreStretched) {
  const FibreLaw law;
  for (double speed = -1.2; speed < 1.5; speed += 0.1) {
    Sheet sheet(law);
    const double move = speed * law.fastest_per_s * Sheet::time_step;
    sheet.stress_pa(1 - 2 * move, 1 - move, 1);
    sheet.stress_pa(1 - move, 1, 1);
    const double wanted = speed <= -1 ? 0 : published_over_speed(speed);
    // The substep begins where the fibre has its optimal length, and ends a little farther.
    EXPECT_NEAR(sheet.stress_pa(1, 1 + move, 1) / law.peak_stress_pa, wanted, 1e-3) << speed;
  }
}

TEST(FibreConstraints, WithoutAFastestSpeedBearAllAtAnySpeed) {
  FibreLaw law;
  law.fastest_per_s = 0;
  Sheet sheet(law);
  sheet.stress_pa(1.1, 1.0, 1);
  EXPECT_NEAR(sheet.stress_pa(1.0, 0.9, 1) / law.peak_stress_pa, 1, 1e-8);
}

TEST(FibreConstraints, BearInProportionBeyondThePassiveStrain) {
  FibreLaw law;
  law.passive_strain = 0.2;
  const auto bears = [&](double stretch) { return Sheet(law).stress_pa(stretch, stretch, 0) / law.peak_stress_pa; };
  const double slope = 5 / 0.2 * std::exp(5) / (std::exp(5) - 1);
  EXPECT_NEAR(bears(1.2), 1, 1e-8);
  EXPECT_NEAR(bears(1.7), 1 + 0.5 * slope, 1e-6);
  EXPECT_NEAR(bears(20), 1 + 18.8 * slope, 1e-4);
}

TEST(FibreConstraints, NeverPush) {
  Sheet sheet({});
  EXPECT_EQ(sheet.stress_pa(0.7, 0.7, 0), 0);
  // Flung together within a substep: the tangent would push.
  EXPECT_EQ(sheet.stress_pa(1.3, 0.2, 0), 0);
  EXPECT_EQ(sheet.stress_pa(0, 0, 0), 0);
}

/// One of the two triangles is longer than their mean, and the other as much shorter.
TEST(FibreConstraints, BearMoreWhereTheyAreLongerThanTheMean) {
  FibreLaw law;
  const std::vector<Body> bodies = {{"two", 0, 6, 0, 2}};
  const std::vector<Vec3> rest = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  const NodeOrder order(rest, bodies);
  const std::vector<FibreConstraint> pair = {{{0, 1, 2}, {-1, 1, 0}, 1}, {{3, 4, 5}, {-1, 1, 0}, 1}};
  for (const double off : {0.02, 0.2}) {
    FibreConstraints constraints(pair, bodies, order, law);
    std::vector<Vec3> at = rest;
    at[1].x() += off;
    at[4].x() -= off;
    NodeRows rows(order, at, std::vector<double>(6, 0.0));
    std::vector<NodeRow> impulses(7);
    rows.set_impulses(impulses.data());
    constraints.begin_substep(rows, 1, 1, Team());
    constraints.project(rows, 1, Team());
    const auto pulled = [&](int node) { return -impulses[static_cast<std::size_t>(order.row_of(node))].x; };
    const double passive = law.peak_stress_pa * published_passive(1 + off);
    EXPECT_NEAR(pulled(1), law.peak_stress_pa * (1 + 10 * off) + passive, 1e-6 * law.peak_stress_pa);
    // It takes away no more than there is.
    EXPECT_NEAR(pulled(4), law.peak_stress_pa * std::max(0.0, 1 - 10 * off), 1e-6 * law.peak_stress_pa);
  }
}

/// One end is free and weighs so little that the pull decides its speed within a substep: large steps follow small
/// ones, and neither overshoots the fastest speed.
TEST(FibreConstraints, OfLightNodesShortenAtTheSpeedThatTheyCan) {
  const FibreLaw law;
  const std::vector<Body> bodies = {{"one", 0, 3, 0, 1}};
  const std::vector<Vec3> rest = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const NodeOrder order(rest, bodies);
  const std::vector<FibreConstraint> fibre = {{{0, 1, 2}, {-1, 1, 0}, 1e-3}};
  const auto end_after = [&](double step_s, double mass_kg) {
    FibreConstraints constraints(fibre, bodies, order, law);
    NodeRows rows(order, rest, std::vector<double>{0, 1 / mass_kg, 0});
    const auto row = static_cast<std::size_t>(order.row_of(1));
    double speed = 0;
    double fastest = 0;
    for (double time_s = 0; time_s < 0.04 - 0.5 * step_s; time_s += step_s) {
      const double before = rows[row].x;
      constraints.begin_substep(rows, 1, step_s, Team());
      rows[row].x += step_s * speed;
      constraints.project(rows, step_s, Team());
      speed = (rows[row].x - before) / step_s;
      fastest = std::min(fastest, speed);
    }
    EXPECT_GT(fastest, -1.05 * law.fastest_per_s);
    return rows[row].x;
  };
  for (const double mass_kg : {1.0, 0.1, 0.02}) {
    const double fine = end_after(2e-6, mass_kg);
    EXPECT_LT(fine, 0.95) << mass_kg;
    EXPECT_NEAR(end_after(1e-3, mass_kg), fine, 0.1 * (1 - fine)) << mass_kg;
  }
}

TEST(FibreConstraints, MoveFreeNodesTogetherByWhatTheyPull) {
  FibreLaw law;
  law.fastest_per_s = 0;
  Sheet sheet(law, 2.0);
  // A mass of half a kilogram at each corner: the sheet's inertia over a substep is far larger than the pull.
  EXPECT_NEAR(sheet.stress_pa(1, 1, 1) / law.peak_stress_pa, 1, 1e-3);
}

}  // namespace
}  // namespace musclebench

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/reference/scalar_effect.hpp"
#include "core/effects/tests/effects_fixture.hpp"

// Bending where both triangles lie in one plane: flat (0 degrees), or folded onto each other (180 degrees).
namespace musclebench {
namespace {

constexpr double step_s = 1e-3;
constexpr int steps = 300;

/// `off_rad` from flat or folded; where that is 0 all nodes lie in z = 0 to the bit.
struct HingePose {
  bool is_folded;
  double off_rad;
};

std::vector<HingePose> poses_at_the_limits() {
  return {{false, 0}, {false, 1e-9}, {false, -1e-9}, {true, 0}, {true, 1e-9}, {true, -1e-9}};
}

std::vector<HingePose> poses_from_limit_to_limit() {
  std::vector<HingePose> poses = poses_at_the_limits();
  for (const double off_rad : {1e-3, -1e-3, 0.1, -0.1, 1.5, -1.5, 3.0, -3.0}) {
    poses.push_back({false, off_rad});
    poses.push_back({true, off_rad});
  }
  return poses;
}

/// The edge is from the origin to (0.1, 0, 0), the left triangle in z = 0.
struct HingeShape {
  std::string name;
  Vec3 left;
  double right_x_m;
  double right_height_m;

  [[nodiscard]] TriangleMesh in(const HingePose& pose) const {
    const double side = pose.is_folded ? right_height_m : -right_height_m;
    const Vec3 right(right_x_m, side * std::cos(pose.off_rad), -side * std::sin(pose.off_rad));
    return {{{0, 0, 0}, {0.1, 0, 0}, left, right}, {{0, 1, 2}, {1, 0, 3}}};
  }
};

struct HingeCase {
  HingeShape shape;
  std::string masses;
  std::vector<double> inverse_masses;
  HingePose rest;
  HingePose now;
  std::map<std::string, ParameterValue> parameters;
  bool is_scalar;

  /// By nodes of the edge alone the angle of an even hinge can't be changed while its tips are at one position, and
  /// it folds only as the edge goes to infinity.
  [[nodiscard]] bool has_a_way_back() const { return shape.name != "even" || !masses.ends_with("tips"); }
};

std::ostream& operator<<(std::ostream& out, const HingeCase& of) {
  const auto degrees = [](const HingePose& pose) { return pose.is_folded ? "180 deg + " : "0 deg + "; };
  return out << of.shape.name << ", " << of.masses << ", rest " << degrees(of.rest) << of.rest.off_rad << ", now "
             << degrees(of.now) << of.now.off_rad << ", " << (of.is_scalar ? "scalar" : "lanes") << ", compliance "
             << of.parameters.count("compliance_rad_per_n_m") << ", stiffness "
             << std::get<double>(of.parameters.at("stiffness"));
}

/// `now`: none for all at rest.
std::vector<HingeCase> hinge_cases(const std::vector<HingePose>& now) {
  const std::vector<HingeShape> shapes = {{"uneven", {0.03, 0.1, 0}, 0.06, 0.08},
                                          {"even", {0.05, 0.1, 0}, 0.05, 0.1},  // its tips meet where it is folded
                                          {"obtuse", {0.15, 0.1, 0}, -0.02, 0.05}};
  const std::map<std::string, std::vector<double>> masses = {
      {"free", {1, 1, 1, 1}},      {"unlike", {1, 0.5, 2, 0.01}},      {"held edge", {0, 0, 1, 1}},
      {"held tips", {1, 1, 0, 0}}, {"heavy tips", {1, 1, 1e-9, 1e-9}}, {"held but one", {0, 0, 0, 1}}};
  const std::vector<std::map<std::string, ParameterValue>> forms = {
      {{"stiffness", 1.0}}, {{"stiffness", 0.3}}, {{"stiffness", 1.0}, {"compliance_rad_per_n_m", 1e-4}}};
  std::vector<HingeCase> cases;
  for (const HingeShape& shape : shapes) {
    for (const auto& [name, inverse_masses] : masses) {
      for (const HingePose& rest : poses_at_the_limits()) {
        for (const HingePose& pose : now.empty() ? std::vector{rest} : now) {
          for (const auto& parameters : forms) {
            for (const bool is_scalar : {false, true}) {
              cases.push_back({shape, name, inverse_masses, rest, pose, parameters, is_scalar});
            }
          }
        }
      }
    }
  }
  return cases;
}

/// One projection a step.
class HingeRun {
 public:
  explicit HingeRun(const HingeCase& of) : m_fixture(of.shape.in(of.rest)), m_nodes(m_fixture.particles()) {
    m_nodes.predicted = of.shape.in(of.now).vertices;
    m_nodes.inverse_masses = of.inverse_masses;
    const Fixture& f = m_fixture;
    if (of.is_scalar) {
      m_scalar = make_scalar_effect("bending", {f.mesh, f.bodies, f.order, f.fibres, f.bound, f.poses},
                                    Parameters(find_effect("bending")->parameters, of.parameters, "test"));
    } else {
      m_lanes = m_fixture.make("bending", of.parameters);
    }
  }

  void step() {
    if (m_scalar) {
      m_scalar->begin_substep();
      m_scalar->project(m_nodes.predicted, m_nodes.inverse_masses, {step_s, m_fixture.poses});
    } else {
      m_fixture.apply_force(*m_lanes, m_nodes, step_s);
      m_fixture.project(*m_lanes, m_nodes, 1, step_s);
    }
  }

  [[nodiscard]] const std::vector<Vec3>& positions() const { return m_nodes.predicted; }
  /// Angle less rest angle.
  [[nodiscard]] double error_rad() const {
    return std::remainder(hinge_angle(m_nodes.predicted) - hinge_angle(m_fixture.mesh.vertices), 2 * M_PI);
  }

 private:
  Fixture m_fixture;
  Nodes m_nodes;
  std::unique_ptr<Effect> m_lanes;
  std::unique_ptr<ScalarEffect> m_scalar;
};

double larger_height_m(const std::vector<Vec3>& x) {
  const Vec3 along = (x[1] - x[0]).normalized();
  return std::max((x[2] - x[0]).cross(along).norm(), (x[3] - x[0]).cross(along).norm());
}

TEST(FlatAndFoldedHinge, StaysAtRest) {
  for (const HingeCase& of : hinge_cases({})) {
    HingeRun run(of);
    const std::vector<Vec3> before = run.positions();
    for (int i = 0; i < steps; ++i) run.step();
    for (std::size_t node = 0; node < before.size(); ++node) {
      ASSERT_LE((run.positions()[node] - before[node]).norm(), of.rest.off_rad == 0 ? 0 : 1e-15) << of;
    }
  }
}

/// No step takes it farther from rest, and so none past the half turn to the other side. Where its tips move, a step
/// goes beyond rest by no more than a twentieth; the nodes of the edge alone can overshoot, as heights change under
/// them.
TEST(FlatAndFoldedHinge, ReturnsToRestFromAnyAngle) {
  for (const HingeCase& of : hinge_cases(poses_from_limit_to_limit())) {
    if (!of.has_a_way_back()) continue;
    HingeRun run(of);
    double before_rad = run.error_rad();
    for (int i = 0; i < steps; ++i) {
      run.step();
      const double error_rad = run.error_rad();
      ASSERT_LE(std::abs(error_rad), std::abs(before_rad) + 1e-14) << of << ", step " << i;
      const bool is_half_turn = std::abs(before_rad) > M_PI - 1e-8;  // both directions are as long
      const bool is_beyond = error_rad * before_rad < 0 && std::abs(error_rad) > 0.05 * std::abs(before_rad) + 1e-14;
      ASSERT_FALSE(is_beyond && !is_half_turn && !of.masses.ends_with("tips")) << of << ", step " << i;
      before_rad = error_rad;
    }
    ASSERT_LE(std::abs(before_rad), 1e-9) << of;
    for (const Vec3& x : run.positions()) ASSERT_LE(x.norm(), 1) << of;
  }
}

/// Whatever can move: where only nodes of the edge can, the angle hardly depends on them as the hinge folds.
TEST(FlatAndFoldedHinge, NoStepThrowsANodeAway) {
  for (const HingeCase& of : hinge_cases(poses_from_limit_to_limit())) {
    HingeRun run(of);
    for (int i = 0; i < steps; ++i) {
      const std::vector<Vec3> before = run.positions();
      run.step();
      const double limit_m = 4.5 * larger_height_m(before);
      for (std::size_t node = 0; node < before.size(); ++node) {
        ASSERT_TRUE(run.positions()[node].allFinite()) << of << ", step " << i;
        ASSERT_LE((run.positions()[node] - before[node]).norm(), limit_m) << of << ", step " << i;
      }
    }
  }
}

/// With velocities, and edges that keep their lengths: swings about its rest angle and no farther.
TEST(FlatAndFoldedHinge, SwingsNoFartherThanItWasTurned) {
  const std::vector<std::map<std::string, ParameterValue>> forms = {
      {{"stiffness", 1.0}}, {{"stiffness", 0.1}}, {{"stiffness", 1.0}, {"compliance_rad_per_n_m", 0.1}}};
  for (const HingePose& rest : poses_at_the_limits()) {
    for (const double off_rad : {0.1, -0.1, 1e-6}) {
      for (const auto& parameters : forms) {
        const HingeShape shape = {"uneven", {0.03, 0.1, 0}, 0.06, 0.08};
        Fixture f(shape.in(rest));
        const auto bending = f.make("bending", parameters);
        const auto length = f.make("edge_length", {{"stiffness", 1.0}});
        Nodes p = f.particles();
        p.predicted = shape.in({rest.is_folded, rest.off_rad + off_rad}).vertices;
        for (int i = 0; i < 2 * steps; ++i) {
          const std::vector<Vec3> before = p.predicted;
          f.apply_force(*bending, p, step_s);
          for (std::size_t node = 0; node < p.size(); ++node) p.predicted[node] += step_s * p.velocities[node];
          f.project(*bending, p, 1, step_s);
          f.project(*length, p, 1, step_s);
          for (std::size_t node = 0; node < p.size(); ++node) {
            p.velocities[node] = (p.predicted[node] - before[node]) / step_s;
          }
          const double error_rad = std::remainder(hinge_angle(p.predicted) - hinge_angle(f.mesh.vertices), 2 * M_PI);
          ASSERT_LE(std::abs(error_rad), 1.02 * std::abs(off_rad) + 1e-9)
              << rest.is_folded << " " << rest.off_rad << " + " << off_rad << ", step " << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace musclebench

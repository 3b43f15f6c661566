#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/effects/surface_edges.hpp"
#include "core/effects/tests/effects_fixture.hpp"
#include "core/mesh/shapes.hpp"

// Compliant constraints against XPBD as it was published (Macklin, Mueller and Chentanez 2016, equations 17 and 18):
//   delta_lambda = (-C - alpha~ lambda) / (sum_i w_i |grad_i C|^2 + alpha~),   alpha~ = alpha / dt^2,
//   x_i += w_i grad_i C delta_lambda,   lambda += delta_lambda,   lambda = 0 at the start of a substep.
namespace musclebench {
namespace {

constexpr double time_step_s = 0.01;
constexpr int iterations = 4;

struct PublishedConstraint {
  std::vector<int> nodes;
  std::function<double(const std::vector<Vec3>&)> value;
  std::function<std::vector<Vec3>(const std::vector<Vec3>&)> gradients;  ///< one a node of `nodes`
  double compliance = 0;                                                 ///< alpha
  double multiplier = 0;                                                 ///< lambda
};

/// `part` of delta_lambda is applied: what the parameter `stiffness` means; 1 in the paper.
void solve_as_published(PublishedConstraint& constraint, std::vector<Vec3>& x, const std::vector<double>& weights,
                        double part = 1) {
  const double compliance = constraint.compliance / (time_step_s * time_step_s);
  const std::vector<Vec3> gradients = constraint.gradients(x);
  double denominator = compliance;
  for (std::size_t i = 0; i < gradients.size(); ++i) {
    denominator += weights[constraint.nodes[i]] * gradients[i].squaredNorm();
  }
  const double change = part * (-constraint.value(x) - compliance * constraint.multiplier) / denominator;
  for (std::size_t i = 0; i < gradients.size(); ++i) {
    x[constraint.nodes[i]] += weights[constraint.nodes[i]] * change * gradients[i];
  }
  constraint.multiplier += change;
}

PublishedConstraint published_length(int start, int end, double rest_length_m, double compliance) {
  return {{start, end},
          [=](const std::vector<Vec3>& x) { return (x[end] - x[start]).norm() - rest_length_m; },
          [=](const std::vector<Vec3>& x) {
            const Vec3 along = (x[end] - x[start]).normalized();
            return std::vector<Vec3>{-along, along};
          },
          compliance};
}

/// The dihedral angle of the hinge, with gradients by central differences.
PublishedConstraint published_angle(double rest_angle_rad, double compliance) {
  return {{0, 1, 2, 3},
          [=](const std::vector<Vec3>& x) { return std::remainder(hinge_angle(x) - rest_angle_rad, 2 * M_PI); },
          [](const std::vector<Vec3>& x) {
            constexpr double step_m = 1e-6;
            std::vector<Vec3> gradients(4);
            for (int node = 0; node < 4; ++node) {
              for (int axis = 0; axis < 3; ++axis) {
                std::vector<Vec3> forwards = x;
                std::vector<Vec3> backwards = x;
                forwards[node][axis] += step_m;
                backwards[node][axis] -= step_m;
                gradients[node][axis] = (hinge_angle(forwards) - hinge_angle(backwards)) / (2 * step_m);
              }
            }
            return gradients;
          },
          compliance};
}

void start_substep(Effect& effect, Nodes& p, const Fixture& f) { f.apply_force(effect, p, time_step_s); }

void iterate(Effect& effect, Nodes& p, Fixture& f, int times) { f.project(effect, p, times, time_step_s); }

void expect_close(const std::vector<Vec3>& found, const std::vector<Vec3>& expected, double tolerance_m) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LT((found[i] - expected[i]).norm(), tolerance_m) << "node " << i;
  }
}

/// A sphere out of shape, whose nodes differ in mass.
struct Bruised : Fixture {
  Nodes start;

  explicit Bruised(std::vector<FibreSegment> with_fibres = {}) : Fixture(make_sphere(1, 1), std::move(with_fibres)) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    start = particles();
    for (Vec3& x : start.predicted) {
      x += 0.2 * Vec3(unit(random), unit(random), unit(random));
    }
    for (double& weight : start.inverse_masses) {
      weight = 1.5 + unit(random);
    }
    start.inverse_masses[5] = 0;
  }

  [[nodiscard]] std::vector<PublishedConstraint> published_lengths(double compliance) const {
    std::vector<PublishedConstraint> constraints;
    for (const SurfaceEdge& edge : surface_edges(mesh)) {
      const Vec3 along = mesh.vertices[edge.end] - mesh.vertices[edge.start];
      constraints.push_back(published_length(edge.start, edge.end, along.norm(), compliance));
    }
    return constraints;
  }

  [[nodiscard]] std::vector<Vec3> solved_as_published(std::vector<PublishedConstraint> constraints, int passes,
                                                      double part = 1) const {
    std::vector<Vec3> x = start.predicted;
    for (int pass = 0; pass < passes; ++pass) {
      for (PublishedConstraint& constraint : constraints) {
        solve_as_published(constraint, x, start.inverse_masses, part);
      }
    }
    return x;
  }
};

constexpr double edge_compliance = 2e-4;  // alpha~ is 2, as large as the weights

TEST(EdgeLengthCompliance, EveryIterationIsThatOfXpbd) {
  Bruised f;
  for (int times = 1; times <= iterations; ++times) {
    const auto effect = f.make("edge_length", {{"compliance_m_per_n", edge_compliance}});
    Nodes p = f.start;
    start_substep(*effect, p, f);
    iterate(*effect, p, f, times);
    expect_close(p.predicted, f.solved_as_published(f.published_lengths(edge_compliance), times), 1e-12);
  }
}

TEST(EdgeLengthCompliance, ASecondVisitGoesOnFromTheFirst) {
  Bruised f;
  const auto effect =
      f.make("edge_length", {{"compliance_m_per_n", edge_compliance}, {"visits_per_edge", std::int64_t{2}}});
  Nodes p = f.start;
  start_substep(*effect, p, f);
  iterate(*effect, p, f, iterations);
  expect_close(p.predicted, f.solved_as_published(f.published_lengths(edge_compliance), 2 * iterations), 1e-12);
}

TEST(EdgeLengthCompliance, StiffnessScalesEveryStep) {
  Bruised f;
  const auto effect = f.make("edge_length", {{"compliance_m_per_n", edge_compliance}, {"stiffness", 0.5}});
  Nodes p = f.start;
  start_substep(*effect, p, f);
  iterate(*effect, p, f, iterations);
  expect_close(p.predicted, f.solved_as_published(f.published_lengths(edge_compliance), iterations, 0.5), 1e-12);
}

/// Along a fibre the compliance is larger by the factor of the anisotropy, and infinite for an edge on the fibre.
TEST(EdgeLengthCompliance, GrowsAlongTheFibres) {
  const Vec3 fibre = Vec3(1, 2, 3).normalized();
  Bruised f({{-5 * fibre, 5 * fibre}});
  constexpr double exponent = 1.5;
  const auto effect =
      f.make("edge_length", {{"compliance_m_per_n", edge_compliance}, {"anisotropy_exponent", exponent}});
  std::vector<PublishedConstraint> published = f.published_lengths(edge_compliance);
  for (PublishedConstraint& constraint : published) {
    const Vec3 edge = f.mesh.vertices[constraint.nodes[1]] - f.mesh.vertices[constraint.nodes[0]];
    constraint.compliance /= std::pow(1 - std::abs(edge.normalized().dot(fibre)), exponent);
  }
  Nodes p = f.start;
  start_substep(*effect, p, f);
  iterate(*effect, p, f, iterations);
  expect_close(p.predicted, f.solved_as_published(published, iterations), 1e-12);
}

/// Of the triangles that have both ends, by Heron's formula, over the same of equilateral triangles.
double published_share(const TriangleMesh& mesh, const std::vector<int>& ends) {
  const auto length_m = [&](int a, int b) { return (mesh.vertices[a] - mesh.vertices[b]).norm(); };
  double area_m2 = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    if (std::ranges::count(std::array{i, j, k}, ends[0]) + std::ranges::count(std::array{i, j, k}, ends[1]) < 2)
      continue;
    const double a = length_m(i, j), b = length_m(j, k), c = length_m(k, i), s = (a + b + c) / 2;
    area_m2 += std::sqrt(s * (s - a) * (s - b) * (s - c));
  }
  const double side_m = length_m(ends[0], ends[1]);
  return area_m2 / (2 * std::sqrt(3.0) / 4 * side_m * side_m);
}

TEST(EdgeLengthCompliance, PerAreaIsThatOfTheTrianglesBesideIt) {
  Bruised f;
  for (Vec3& vertex : f.mesh.vertices) vertex.z() *= 1.7;  // far from equilateral
  std::vector<PublishedConstraint> published = f.published_lengths(edge_compliance);
  for (PublishedConstraint& constraint : published) constraint.compliance /= published_share(f.mesh, constraint.nodes);
  const auto effect = f.make("edge_length", {{"compliance_m_per_n", edge_compliance}, {"per_area", true}});
  Nodes p = f.start;
  start_substep(*effect, p, f);
  iterate(*effect, p, f, iterations);
  expect_close(p.predicted, f.solved_as_published(published, iterations), 1e-12);
}

/// A surface that grows by the same share everywhere takes the same energy on any mesh of the same area.
TEST(EdgeLengthCompliance, PerAreaMakesTheEnergyOfGrowthOneOfTheArea) {
  for (const double height_m : {0.1, 1.0, 7.0}) {
    TriangleMesh mesh = make_box(Vec3(0.5, 0.5, height_m), 3);
    double sum_m2 = 0;
    for (const SurfaceEdge& edge : surface_edges(mesh)) {
      sum_m2 += relative_area(mesh, edge) * (mesh.vertices[edge.end] - mesh.vertices[edge.start]).squaredNorm();
    }
    const double area_m2 = 2 + 8 * height_m;
    EXPECT_NEAR(sum_m2, 2 * std::sqrt(3.0) * area_m2, 1e-12 * area_m2);
  }
}

TEST(EdgeLengthCompliance, PerAreaStaysFiniteWhereTrianglesHaveNone) {
  const TriangleMesh flat{{{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0.5, 0, 0}}, {{0, 1, 2}, {2, 3, 2}}};
  for (const SurfaceEdge& edge : surface_edges(flat)) EXPECT_EQ(relative_area(flat, edge), 1e-6);
}

/// A second substep from the same start ends as the first did.
template <typename Muscle>
void expect_multipliers_of_the_substep(Effect& used, Muscle& f) {
  Nodes before = f.start;
  start_substep(used, before, f);
  iterate(used, before, f, iterations);
  Nodes p = f.start;
  start_substep(used, p, f);
  iterate(used, p, f, iterations);
  expect_close(p.predicted, before.predicted, 1e-15);
}

TEST(EdgeLengthCompliance, MultipliersAreThoseOfTheSubstep) {
  Bruised f;
  expect_multipliers_of_the_substep(*f.make("edge_length", {{"compliance_m_per_n", edge_compliance}}), f);
}

constexpr double rest_angle_rad = 0.4;
constexpr double angle_compliance = 1e-3;  // alpha~ is 10; weights and gradients sum up to 3 to 6

struct Folded : Fixture {
  Nodes start;

  explicit Folded(double angle_rad) : Fixture(hinge(rest_angle_rad)) {
    start = particles();
    start.predicted = hinge(angle_rad).vertices;
    start.inverse_masses = {1.0, 0.5, 2.0, 1.5};
  }

  std::vector<Vec3> solved(double part, int times, double compliance = angle_compliance, bool is_per_area = false) {
    const auto effect =
        make("bending", {{"stiffness", part}, {"compliance_rad_per_n_m", compliance}, {"per_area", is_per_area}});
    Nodes p = start;
    start_substep(*effect, p, *this);
    iterate(*effect, p, *this, times);
    return p.predicted;
  }

  [[nodiscard]] std::vector<Vec3> solved_as_published(double part, int times,
                                                      double compliance = angle_compliance) const {
    PublishedConstraint constraint = published_angle(hinge_angle(mesh.vertices), compliance);
    std::vector<Vec3> x = start.predicted;
    for (int i = 0; i < times; ++i) {
      solve_as_published(constraint, x, start.inverse_masses, part);
    }
    return x;
  }
};

TEST(BendingCompliance, EveryIterationIsThatOfXpbd) {
  for (const double angle_rad : {1.2, -0.9}) {
    Folded f(angle_rad);
    for (int times = 1; times <= iterations; ++times) {
      expect_close(f.solved(1, times), f.solved_as_published(1, times), 1e-8);
    }
  }
}

TEST(BendingCompliance, StiffnessScalesEveryStep) {
  Folded f(1.2);
  expect_close(f.solved(0.5, iterations), f.solved_as_published(0.5, iterations), 1e-8);
}

TEST(BendingCompliance, PerAreaIsThatOfTheTrianglesBesideIt) {
  Folded f(1.2);
  for (Vec3& vertex : f.mesh.vertices) vertex = vertex.cwiseProduct(Vec3(1, 2, 2));
  const double share = published_share(f.mesh, {0, 1});
  ASSERT_GT(share, 1.5);
  expect_close(f.solved(1, iterations, angle_compliance, true),
               f.solved_as_published(1, iterations, angle_compliance * share), 1e-8);
}

TEST(BendingCompliance, WithoutComplianceItIsPbd) {
  Folded f(1.2);
  expect_close(f.solved(0.5, iterations, 0), f.solved_as_published(0.5, iterations, 0), 1e-8);
}

TEST(BendingCompliance, MultipliersAreThoseOfTheSubstep) {
  Folded f(1.2);
  expect_multipliers_of_the_substep(
      *f.make("bending", {{"stiffness", 1.0}, {"compliance_rad_per_n_m", angle_compliance}}), f);
}

/// Rest lengths are those of edges that have shortened to 0.7 along the fibre and are 1 / sqrt(0.7) as long across.
void expect_activation_as_published(bool is_per_area) {
  const Vec3 fibre = Vec3(1, 2, 3).normalized();
  Bruised f({{-fibre, fibre}});
  for (Vec3& vertex : f.mesh.vertices) vertex.z() *= is_per_area ? 1.7 : 1;
  std::vector<PublishedConstraint> published;
  for (const SurfaceEdge& edge : surface_edges(f.mesh)) {
    const Vec3 side = f.mesh.vertices[edge.end] - f.mesh.vertices[edge.start];
    const Vec3 along = fibre.dot(side) * fibre;
    const double cosine = along.norm() / side.norm();
    if (cosine < 0.5) continue;
    const double length_m = (0.7 * along + (side - along) / std::sqrt(0.7)).norm();
    const double share = is_per_area ? published_share(f.mesh, {edge.start, edge.end}) : 1;
    published.push_back(published_length(edge.start, edge.end, length_m, edge_compliance / (cosine * share)));
  }
  ASSERT_GT(published.size(), 20U);
  for (int times = 1; times <= iterations; ++times) {
    const auto effect = f.make(
        "activation",
        {{"compliance_m_per_n", edge_compliance}, {"shortening", 0.3}, {"rise_s", 0.0}, {"per_area", is_per_area}});
    Nodes p = f.start;
    start_substep(*effect, p, f);
    iterate(*effect, p, f, times);
    expect_close(p.predicted, f.solved_as_published(published, times), 1e-12);
  }
}

TEST(ActivationCompliance, EveryIterationIsThatOfXpbdOnShortenedEdges) { expect_activation_as_published(false); }

TEST(ActivationCompliance, PerAreaIsThatOfTheTrianglesBesideIt) { expect_activation_as_published(true); }

/// A compliance that comes with an effect wants a test against the published formula.
TEST(Compliance, TheseTestsKnowAllThereAre) {
  std::set<std::string> compliant;
  for (const EffectEntry& entry : effect_registry()) {
    for (const ParameterSpec& parameter : entry.parameters) {
      if (parameter.name.starts_with("compliance")) {
        compliant.insert(entry.name);
      }
    }
  }
  EXPECT_EQ(compliant, (std::set<std::string>{"activation", "bending", "edge_length"}));
}

/// What was stored in the substep before is no multiplier of this one, even where the first projection had nothing to
/// do.
TEST(BendingCompliance, AHingeThatActsLateInASubstepStartsFromZero) {
  Folded f(1.0);
  const auto used = f.make("bending", {{"compliance_rad_per_n_m", angle_compliance}});
  Nodes before = f.start;
  start_substep(*used, before, f);
  iterate(*used, before, f, iterations);
  Nodes folded_up = f.start;  // the left triangle has no height
  folded_up.predicted[2] = 0.3 * folded_up.predicted[0] + 0.7 * folded_up.predicted[1];
  const std::vector<Vec3> unmoved = folded_up.predicted;
  start_substep(*used, folded_up, f);
  iterate(*used, folded_up, f, 1);
  EXPECT_EQ(folded_up.predicted, unmoved);
  Nodes p = f.start;
  iterate(*used, p, f, 1);
  const auto fresh = f.make("bending", {{"compliance_rad_per_n_m", angle_compliance}});
  Nodes expected = f.start;
  start_substep(*fresh, expected, f);
  iterate(*fresh, expected, f, 1);
  expect_close(p.predicted, expected.predicted, 1e-15);
}

}  // namespace
}  // namespace musclebench

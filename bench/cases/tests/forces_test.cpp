#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/forces/force_watch.hpp"
#include "bench/cases/run_case.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/cases/tests/done_simulation.hpp"
#include "bench/cases/tests/force_scenes.hpp"

namespace musclebench {
namespace {

constexpr double gravity_m_per_s2 = 9.80665;

RunResult told(const Scene& scene) {
  RunCase run = combination_case(scene);
  run.forces = true;
  return run_case(run, [](int) {});
}

/// The mean over the last `frames` frames of what `figure` tells of the rows of `source` and `other`.
template <typename Figure>
double late_mean(const RunResult& run, ForceSource source, const std::string& by, int frames, const Figure& figure) {
  double sum = 0;
  int rows = 0;
  for (const ForceRow& row : run.forces) {
    if (row.frame <= run.records.back().frame - frames || row.source != source || row.other != by) continue;
    sum += figure(row);
    ++rows;
  }
  EXPECT_EQ(rows, frames) << by;
  return sum / rows;
}

double weight_n(const Scene& scene) {
  double weight = 0;
  for (const Muscle& muscle : scene.muscles) {
    weight += gravity_m_per_s2 * node_mass_kg(scene, muscle) * (muscle.body.last_node - muscle.body.first_node);
  }
  return weight;
}

const auto told_upward = [](const ForceRow& row) { return row.force_n.z(); };
const auto told_normal = [](const ForceRow& row) { return row.normal_n.value(); };
const auto told_area = [](const ForceRow& row) { return row.area_m2.value(); };
const auto told_friction = [](const ForceRow& row) { return row.friction_n.value(); };

TEST(Forces, OfAPlateCarryTheWeightOfWhatLiesOnIt) {
  const Scene scene = load_scene({"hard/loaded_plate", "", "", {}});
  const RunResult run = told(scene);
  EXPECT_NEAR(late_mean(run, ForceSource::bone, "plate", 20, told_upward), weight_n(scene), 0.005 * weight_n(scene));
  EXPECT_NEAR(late_mean(run, ForceSource::bone, "plate", 20, told_normal), weight_n(scene), 0.005 * weight_n(scene));
  // The block is 40 mm wide; its sides do not count.
  EXPECT_NEAR(late_mean(run, ForceSource::bone, "plate", 20, told_area), 1.6e-3, 2e-5);
}

TEST(Forces, OfTwoRailsCarryAHalfEach) {
  const Scene scene = force_scenes::block_on_rails();
  const RunResult run = told(scene);
  const double half_n = weight_n(scene) / 2;
  EXPECT_NEAR(late_mean(run, ForceSource::bone, "left", 20, told_upward), half_n, 0.01 * half_n);
  EXPECT_NEAR(late_mean(run, ForceSource::bone, "right", 20, told_upward), half_n, 0.01 * half_n);
}

/// By nodes, faces and edges: the slope falls by 3 in 4.
TEST(Forces, OfAnInclineAreTheWeightTimesCosineAndSine) {
  for (const auto& [name, bone] : {std::pair("hard/incline_nodes", "slope"), std::pair("hard/incline_faces", "rails"),
                                   std::pair("hard/incline_edges", "ridges")}) {
    const Scene scene = load_scene(
        {name,
         "",
         "",
         {{"frames", std::int64_t{40}}},
         {{"test", "friction", false, {{"coefficient", 1.0}}}, {"test", "damping", false, {{"rate_per_s", 200.0}}}}});
    const RunResult run = told(scene);
    EXPECT_NEAR(late_mean(run, ForceSource::bone, bone, 20, told_normal), 0.8 * weight_n(scene), 0.01 * weight_n(scene))
        << name;
    EXPECT_NEAR(late_mean(run, ForceSource::bone, bone, 20, told_friction), 0.6 * weight_n(scene),
                0.01 * weight_n(scene))
        << name;
  }
}

const auto told_active = [](const ForceRow& row) { return row.active_n.value(); };
const auto told_passive = [](const ForceRow& row) { return row.passive_n.value(); };

/// Fibres pull the apex of a tetrahedron down against the springs of its three edges.
TEST(Forces, OfAnActivatedMuscleAreThoseOfTheSpringsThatItPulls) {
  Scene scene = load_scene({"hard/pressed_spring",
                            "",
                            "",
                            {{"frames", std::int64_t{60}}, {"rest_frames", std::int64_t{0}}},
                            {{"test", "gravity", true},
                             {"test", "activation", false, {{"rise_s", 0.1}, {"compliance_m_per_n", 0.002}}},
                             {"test", "edge_length", false, {{"anisotropy_exponent", 0.0}}}}});
  scene.motions.assign(scene.motions.size(), {});
  scene.muscles[0].fibres = {{Vec3(0, 0, 0), Vec3(0, 0, 0.03)}};
  RunCase run_of = combination_case(scene);
  run_of.forces = true;
  run_of.snapshots = {scene.loop.frames};
  const RunResult run = run_case(run_of, [](int) {});
  const std::vector<Vec3>& at = run.snapshots.front().positions;
  const std::vector<Vec3>& rest = scene.muscle_mesh.vertices;
  const auto apex = static_cast<std::size_t>(
      std::ranges::max_element(rest, {}, [](const Vec3& node) { return node.z(); }) - rest.begin());
  double springs_n = 0;
  for (std::size_t node = 0; node < rest.size(); ++node) {
    if (node == apex) continue;
    const Vec3 edge = at[apex] - at[node];
    const double force_n = ((rest[apex] - rest[node]).norm() - edge.norm()) / 1e-3;
    springs_n += force_n * edge.normalized().z();
  }
  EXPECT_GT(springs_n, 0.1);
  const double tension_n = late_mean(run, ForceSource::attachment, "base", 10, told_active);
  EXPECT_NEAR(std::abs(tension_n), springs_n, 0.001 * springs_n);
  EXPECT_NEAR(late_mean(run, ForceSource::attachment, "base", 10, told_passive), -tension_n, 0.001 * springs_n);
}

/// Virtual work: the torque is the tension times the change of the fibres' length with the angle.
TEST(Forces, OfATautStrapTurnItsBoneByTheMomentArmTimesTheTension) {
  const Scene scene = force_scenes::taut_strap();
  const RunResult run = told(scene);
  std::vector<std::string> names{"strap"};
  const FibreTables fibres = fibre_tables(names, run.fibres);
  int compared = 0;
  for (const ForceRow& row : run.forces) {
    if (row.source != ForceSource::attachment || row.other != "insertion" || row.frame < 10 || row.frame > 28) continue;
    const auto arm = std::ranges::find(fibres.muscles, row.frame, &FibreRow::frame);
    ASSERT_TRUE(arm != fibres.muscles.end() && arm->of_mean);
    // A longer strap is tauter: it turns the bone back.
    EXPECT_NEAR(*row.torque_n_m, -arm->of_mean->arm_m * row.force_n.norm(), 0.02 * std::abs(*row.torque_n_m))
        << "frame " << row.frame;
    ++compared;
  }
  EXPECT_EQ(compared, 19);
}

/// The same of fibres that a Hill muscle pulls with, whose force is told. The bone turns towards the strap's other end,
/// so that nothing but its fibres keeps it taut; so little that its edges, which resist that, bear 2 % of the force.
TEST(Forces, OfActiveFibresTurnTheirBoneByTheMomentArmTimesTheirForce) {
  Scene scene = force_scenes::taut_strap(
      "[effects.edge_length]\ncompliance_m_per_n = 0.1\n[effects.fibre_force]\nlevel = 0.3\nrise_s = 0\n");
  scene.loop.substeps = 80;
  scene.loop.time_step_s = 0.25e-3;
  for (BoneMotion& motion : scene.motions) {
    for (BoneRotation& rotation : motion.rotations) {
      for (double& angle_rad : rotation.angles_rad) angle_rad *= -0.25;
    }
  }
  const RunResult run = told(scene);
  const FibreTables fibres = fibre_tables(std::vector<std::string>{"strap"}, run.fibres);
  int compared = 0;
  for (const ForceRow& row : run.forces) {
    if (row.source != ForceSource::attachment || row.other != "insertion" || row.frame < 15 || row.frame > 28) continue;
    const auto arm = std::ranges::find(fibres.muscles, row.frame, &FibreRow::frame);
    ASSERT_TRUE(arm != fibres.muscles.end() && arm->of_mean && row.fibres_n);
    EXPECT_GT(*row.fibres_n, 3);
    EXPECT_NEAR(*row.torque_n_m, -arm->of_mean->arm_m * *row.fibres_n, 0.03 * std::abs(*row.torque_n_m))
        << "frame " << row.frame << " " << *row.fibres_n;
    ++compared;
  }
  EXPECT_EQ(compared, 14);
}

/// Imbert and Fick: a sphere full of liquid in a thin skin presses on what flattens it with the pressure inside,
/// which the force of the volume on its free nodes tells.
TEST(Forces, OfABallOfLiquidPressWithThePressureInside) {
  for (const bool two : {false, true}) {
    DoneSimulation done(force_scenes::pressed_ball(two), false);
    done.simulation().record_impulses(done.scene.bodies());
    const ForceWatch watch(done.scene, {}, {}, done.simulation());
    done.simulation().step_frame(done.scene.loop.frames);
    const FrameImpulses& impulses = done.impulses();
    const std::vector<Vec3>& at = done.simulation().positions();
    const auto volume = static_cast<std::size_t>(std::ranges::find(done.prepared.effect_names, "volume") -
                                                 done.prepared.effect_names.begin());
    // At the side, where nothing touches the ball: area vectors of its triangles.
    const Body& ball = done.scene.muscles[0].body;
    std::vector<Vec3> areas_m2(at.size(), Vec3::Zero());
    for (std::size_t t = ball.first_triangle; t < ball.last_triangle; ++t) {
      const auto& [a, b, c] = done.scene.muscle_mesh.triangles[t];
      const auto corner = [&](int node) { return at[static_cast<std::size_t>(node)]; };
      const Vec3 third = (corner(b) - corner(a)).cross(corner(c) - corner(a)) / 6;
      for (const int node : {a, b, c}) areas_m2[static_cast<std::size_t>(node)] += third;
    }
    double inner_pa = 0;
    int nodes = 0;
    for (int node = ball.first_node; node < ball.last_node; ++node) {
      const auto i = static_cast<std::size_t>(node);
      if (std::abs(at[i].z() - 0.018) > 0.003) continue;
      inner_pa += impulses.of_effect(volume, node).dot(areas_m2[i]) / areas_m2[i].squaredNorm() / impulses.duration_s();
      ++nodes;
    }
    ASSERT_GT(nodes, 100);
    inner_pa /= nodes;
    EXPECT_GT(inner_pa, 10);
    // In the middle of each flat, away from its rim, whose nodes bear a part only.
    const NodeForces contact = watch.at_nodes(done.simulation());
    std::map<int, std::vector<double>> of_flats;  // by height in mm
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (std::hypot(at[i].x(), at[i].y()) > 0.005 || !(contact.pressures_pa[i] > 0)) continue;
      of_flats[static_cast<int>(std::lround(1e3 * at[i].z()))].push_back(contact.pressures_pa[i]);
    }
    EXPECT_EQ(of_flats.size(), two ? 3U : 2U);
    for (const auto& [height_mm, pressures] : of_flats) {
      EXPECT_GT(pressures.size(), 20U);
      const double mean_pa =
          std::accumulate(pressures.begin(), pressures.end(), 0.0) / static_cast<double>(pressures.size());
      EXPECT_NEAR(mean_pa, inner_pa, (height_mm == 0 ? 0.01 : 0.1) * inner_pa) << height_mm << " mm";
    }
    // The plate feels the same, and all of it.
    Vec3 whole_n = Vec3::Zero();
    double sum_pa = 0;
    int vertices = 0;
    for (const BoneVertexRow& row : watch.on_bones(done.simulation())) {
      if (row.bone != "plate") continue;
      const Vec3& vertex = done.scene.bones.front().surface.mesh.vertices[static_cast<std::size_t>(row.vertex)];
      whole_n += row.force_n;
      if (vertex.z() < -1e-6 || std::hypot(vertex.x(), vertex.y()) > 0.005) continue;
      sum_pa += row.pressure_pa;
      ++vertices;
    }
    ASSERT_GT(vertices, 8);
    EXPECT_NEAR(sum_pa / vertices, inner_pa, 0.03 * inner_pa);
    double pushed_n = 0;
    for (std::size_t i = 0; i < at.size(); ++i) pushed_n += impulses.by_collider().push_at(0, static_cast<int>(i)).z();
    EXPECT_NEAR(whole_n.z(), -pushed_n / impulses.duration_s(), 1e-9 * pushed_n / impulses.duration_s());
  }
}

/// The lower ball is attached whole: its bone bears the upper one.
TEST(Forces, OfAMuscleOnAnAttachedOneReachItsBone) {
  const Scene scene = force_scenes::stacked_boxes();
  ASSERT_EQ(scene.bound_nodes().size(), static_cast<std::size_t>(scene.muscles[0].body.last_node));
  const RunResult run = told(scene);
  const double upper_n = gravity_m_per_s2 * node_mass_kg(scene, scene.muscles[1]) *
                         (scene.muscles[1].body.last_node - scene.muscles[1].body.first_node);
  EXPECT_NEAR(late_mean(run, ForceSource::muscle, "lower", 20, told_upward), upper_n, 0.01 * upper_n)
      << "on the upper one";
  EXPECT_NEAR(late_mean(run, ForceSource::muscle, "upper", 20, told_upward), -upper_n, 0.01 * upper_n)
      << "on the lower one";
  EXPECT_NEAR(late_mean(run, ForceSource::attachment, "foot", 20, told_upward), upper_n, 0.01 * upper_n);
}

TEST(Forces, OfAGuardAreOfItsBone) {
  const RunResult run = told(load_scene({"hard/turned_fast", "", "", {}}));
  double largest_n = 0;
  for (const ForceRow& row : run.forces) {
    EXPECT_NE(row.source, ForceSource::unknown) << "frame " << row.frame;
    if (row.source == ForceSource::bone) largest_n = std::max(largest_n, row.force_n.norm());
  }
  EXPECT_GT(largest_n, 0.1);
}

/// The pull of the strap with one iteration and with four, with this time step.
std::pair<double, double> pulls_n(double time_step_s) {
  std::vector<double> pulls;
  for (const int iterations : {1, 4}) {
    Scene scene = force_scenes::taut_strap();
    scene.fibre_count = 0;
    scene.loop.substeps = static_cast<int>(std::lround(scene.loop.substeps * scene.loop.time_step_s / time_step_s));
    scene.loop.time_step_s = time_step_s;
    scene.loop.iterations = iterations;
    pulls.push_back(late_mean(told(scene), ForceSource::attachment, "insertion", 3,
                              [](const ForceRow& row) { return row.force_n.norm(); }));
  }
  return {pulls[0], pulls[1]};
}

TEST(ForceObstacles, TellATimeStepWithWhichOneIterationIsEnough) {
  const Scene scene = force_scenes::taut_strap();
  const ForceObstacles obstacles = force_obstacles(scene, {ResponseKind::project});
  EXPECT_LT(obstacles.settled_step_s, scene.loop.time_step_s);
  const auto [one, four] = pulls_n(obstacles.settled_step_s);
  EXPECT_NEAR(one, four, 0.05 * four);
  const auto [one_as_it_is, four_as_it_is] = pulls_n(scene.loop.time_step_s);
  EXPECT_GT(std::abs(four_as_it_is - one_as_it_is), 0.1 * four);
}

TEST(ForceObstacles, NameWhatMakesForcesMeaningless) {
  const Scene paper = load_scene({"synthetic/iliacus", "paper", "", {{"frames", std::int64_t{2}}}});
  const ForceObstacles of_paper = force_obstacles(paper, {ResponseKind::backtrack});
  for (const char* word : {"1 kg", "density_kg_per_m3", "jump", "interpolated", "backtrack"}) {
    EXPECT_THAT(of_paper.contacts, testing::HasSubstr(word));
  }
  for (const char* word : {"edge_length", "volume", "bending", "iterations"}) {
    EXPECT_THAT(of_paper.attachments, testing::HasSubstr(word));
  }
  RunCase run = combination_case(paper);
  run.forces = true;
  run.snapshots = {2};
  const RunResult result = run_case(run, [](int) {});
  EXPECT_TRUE(result.forces.empty());
  EXPECT_TRUE(result.snapshots.front().contact.pressures_pa.empty());
  const Scene isometric = load_scene({"hard/isometric", "", "", {}});
  const ForceObstacles of_stiff = force_obstacles(isometric, {ResponseKind::project});
  EXPECT_THAT(of_stiff.attachments, testing::HasSubstr("activation is too stiff for its time step"));
  EXPECT_EQ(of_stiff.contacts, "");
  const Scene hard =
      load_scene({"hard/isometric", "", "", {}, {{"test", "activation", false, {{"compliance_m_per_n", 0.0}}}}});
  EXPECT_THAT(force_obstacles(hard, {ResponseKind::project}).attachments,
              testing::HasSubstr("activation has no compliance"));
  const Scene standard = load_scene({"synthetic/iliacus", "standard", "", {}});
  EXPECT_EQ(force_obstacles(standard, {ResponseKind::project}).text(), "");
  EXPECT_THAT(force_obstacles(standard, {ResponseKind::project}).unsettled,
              testing::HasSubstr("edge_length is softer in this loop than its compliance says"));
}

}  // namespace
}  // namespace musclebench

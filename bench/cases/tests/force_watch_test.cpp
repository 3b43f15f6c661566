#include "bench/cases/force_watch.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/cases/build_backend.hpp"
#include "bench/cases/run_case.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/cases/tests/combination_scene.hpp"
#include "core/mesh/shapes.hpp"
#include "core/referee/tests/test_bones.hpp"
#include "core/scene/prepare_simulation.hpp"
#include "core/scene/read_scene.hpp"

namespace musclebench {
namespace {

constexpr double gravity_m_per_s2 = 9.80665;

/// A simulation that has done `frames` frames, and what its last one left.
struct Done {
  Scene scene;
  std::unique_ptr<CollisionBackend> backend;
  PreparedSimulation prepared;
  std::vector<Vec3> velocities_before;  ///< of the last frame
  std::vector<double> masses_kg;        ///< by node; 0: attached

  Done(Scene of, bool records, int threads = 1) : scene(std::move(of)) {
    RunCase run = combination_case(scene);
    run.threads = threads;
    backend = build_backend(run, {}).backend;
    prepared = prepare_simulation(scene, *backend, run.responses, threads,
                                  make_muscle_detectors(scene, run.colliders, threads));
    if (records) prepared.simulation->record_impulses(scene.bodies());
    for (const Muscle& muscle : scene.muscles) {
      masses_kg.resize(static_cast<std::size_t>(muscle.body.last_node), node_mass_kg(scene, muscle));
    }
    for (const BoundNode& bound : prepared.bound_nodes) masses_kg[static_cast<std::size_t>(bound.node)] = 0;
    for (int frame = 1; frame <= scene.loop.frames; ++frame) {
      velocities_before = simulation().velocities();
      simulation().step_frame(frame);
    }
  }
  [[nodiscard]] Simulation& simulation() { return *prepared.simulation; }
  [[nodiscard]] const FrameImpulses& impulses() const { return *prepared.simulation->impulses(); }
  [[nodiscard]] Vec3 of_effects(int node) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < prepared.effect_names.size(); ++i) sum += impulses().of_effect(i, node);
    return sum;
  }
};

const std::vector<std::string> all_effects = {
    "gravity",  "damping",      "attachment",   "activation", "edge_length",
    "volume",   "bending",      "local_volume", "margin",     "tunnelling_guard",
    "friction", "self_contact", "multi_bone",   "no_passage", "surface_contact",
};

TEST(FrameImpulses, AddUpToTheChangeOfMomentumOfEachNode) {
  Done done(combination_scene(all_effects), true);
  const std::vector<Vec3> after = done.simulation().velocities();
  double largest = 0;
  double off = 0;
  for (int node = 0; node < static_cast<int>(after.size()); ++node) {
    const auto i = static_cast<std::size_t>(node);
    if (done.masses_kg[i] == 0) continue;
    const Vec3 change = done.masses_kg[i] * (after[i] - done.velocities_before[i]);
    const Vec3 sum = done.of_effects(node) + done.impulses().of_contacts(node);
    largest = std::max(largest, change.norm());
    off = std::max(off, (sum - change).norm());
  }
  EXPECT_GT(largest, 0);
  EXPECT_LT(off, 1e-9 * largest);
}

TEST(FrameImpulses, AreToldByColliderWithoutARest) {
  Done done(combination_scene(all_effects), true);
  const ContactImpulses& contacts = done.impulses().by_collider();
  std::vector<double> of_collider(contacts.colliders(), 0.0);
  for (int node = 0; node < static_cast<int>(done.masses_kg.size()); ++node) {
    Vec3 sum = Vec3::Zero();
    if (done.masses_kg[static_cast<std::size_t>(node)] == 0) continue;
    for (std::size_t collider = 0; collider < contacts.colliders(); ++collider) {
      sum += contacts.at(collider, node);
      of_collider[collider] += contacts.at(collider, node).norm();
    }
    EXPECT_LT((sum - done.impulses().of_contacts(node)).norm(), 1e-9 * (1 + sum.norm()));
  }
  EXPECT_GT(of_collider[0], 0) << "the plate";
  EXPECT_GT(of_collider[1], 0) << "the rod";
  EXPECT_GT(of_collider[2], 0) << "the ball";
  EXPECT_GT(of_collider[3], 0) << "the other ball";
}

TEST(FrameImpulses, OfInternalConstraintsAddUpToNothing) {
  Done done(combination_scene({"attachment", "activation", "edge_length", "volume", "bending", "local_volume"}), true);
  for (std::size_t effect = 0; effect < done.prepared.effect_names.size(); ++effect) {
    if (done.prepared.effect_names[effect] == "attachment") continue;
    Vec3 sum = Vec3::Zero();
    double sizes = 0;
    for (int node = 0; node < static_cast<int>(done.masses_kg.size()); ++node) {
      sum += done.impulses().of_effect(effect, node);
      sizes += done.impulses().of_effect(effect, node).norm();
    }
    EXPECT_GT(sizes, 0) << done.prepared.effect_names[effect];
    EXPECT_LT(sum.norm(), 1e-12 * sizes) << done.prepared.effect_names[effect];
  }
}

TEST(FrameImpulses, BetweenMusclesAreOppositeAndEqual) {
  Done done(combination_scene({"attachment", "edge_length", "volume", "friction"}), true);
  const ContactImpulses& contacts = done.impulses().by_collider();
  const std::vector<Body> bodies = done.scene.bodies();
  Vec3 on_ball = Vec3::Zero();
  Vec3 on_other = Vec3::Zero();
  for (int node = 0; node < bodies[1].last_node; ++node) {
    (bodies[0].has_node(node) ? on_ball : on_other) +=
        contacts.at(contacts.of_muscle(bodies[0].has_node(node) ? 1 : 0), node);
  }
  EXPECT_GT(on_ball.norm(), 0);
  EXPECT_LT((on_ball + on_other).norm(), 1e-9 * on_ball.norm());
}

TEST(FrameImpulses, ChangeNoBitOfTheMotionAndAreTheSameOnTwoThreads) {
  Done without(combination_scene(all_effects), false);
  Done with(combination_scene(all_effects), true);
  Done on_two(combination_scene(all_effects), true, 2);
  EXPECT_EQ(without.simulation().positions(), with.simulation().positions());
  EXPECT_EQ(on_two.simulation().positions(), with.simulation().positions());
  for (int node = 0; node < static_cast<int>(with.masses_kg.size()); ++node) {
    EXPECT_EQ(on_two.impulses().of_contacts(node), with.impulses().of_contacts(node));
    EXPECT_EQ(on_two.of_effects(node), with.of_effects(node));
  }
}

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

/// A block of 60 x 20 x 20 mm over two rails 0.4 mm wide, 15 mm to its left and right.
Scene block_on_rails() {
  SceneRequest request;
  request.name = request.file = "rails.toml";
  request.text = R"(
[loop]
frames = 60
substeps = 20
time_step_s = 1e-3
density_kg_per_m3 = 1060
[effects.gravity]
[effects.damping]
rate_per_s = 50
[effects.edge_length]
compliance_m_per_n = 1e-5
[effects.volume]
[effects.bending]
[effects.friction]
[effects.surface_contact]
[[bone]]
name = "left"
mesh = "synthetic:left"
[[bone]]
name = "right"
mesh = "synthetic:right"
[muscle]
name = "block"
mesh = "synthetic:block"
)";
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "block") return moved(make_box(Vec3(0.03, 0.01, 0.01), 6), Vec3(0, 0, 0.01));
    return moved(make_box(Vec3(0.0002, 0.02, 0.005), 1), Vec3(name == "left" ? -0.015 : 0.015, 0, -0.005));
  };
  return read_scene(request);
}

TEST(Forces, OfTwoRailsCarryAHalfEach) {
  const Scene scene = block_on_rails();
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

/// A strap of 100 mm from a bone that stands to one that turns about an axis 30 mm below its end.
Scene taut_strap() {
  SceneRequest request;
  request.name = request.file = "strap.toml";
  request.text = R"(
[loop]
frames = 30
substeps = 20
time_step_s = 1e-3
density_kg_per_m3 = 1060
bone_motion = "interpolated"
[effects.damping]
rate_per_s = 100
[effects.attachment]
[effects.edge_length]
compliance_m_per_n = 0.05
[effects.volume]
[[bone]]
name = "left"
mesh = "synthetic:left"
[[bone]]
name = "right"
mesh = "synthetic:right"
[bone.motion]
axis = [0, 1, 0]
centre_m = [0.05, 0, -0.03]
from_deg = 0
to_deg = 20
course = "there"
[muscle]
name = "strap"
mesh = "synthetic:strap"
fibres = "between_attachments"
[[attachment]]
name = "origin"
bone = "left"
outline_m = [[-0.05, -0.01, -0.01], [-0.05, 0.01, -0.01], [-0.05, 0.01, 0.01], [-0.05, -0.01, 0.01]]
distance_m = 0.001
[[attachment]]
name = "insertion"
bone = "right"
outline_m = [[0.05, -0.01, -0.01], [0.05, 0.01, -0.01], [0.05, 0.01, 0.01], [0.05, -0.01, 0.01]]
distance_m = 0.001
)";
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "strap") return make_box(Vec3(0.05, 0.005, 0.002), 10);
    return moved(make_box(Vec3(0.002, 0.02, 0.02), 1), Vec3(name == "left" ? -0.052 : 0.052, 0, 0));
  };
  request.fibres = {4, "test"};
  return read_scene(request);
}

/// Virtual work: the torque is the tension times the change of the fibres' length with the angle.
TEST(Forces, OfATautStrapTurnItsBoneByTheMomentArmTimesTheTension) {
  const Scene scene = taut_strap();
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

/// A ball that liquid inflates by 30 %, between a plate and a lid that comes down by 6 mm; with `two`, a second ball
/// lies on the first.
Scene pressed_ball(bool two) {
  SceneRequest request;
  request.name = request.file = "pressed.toml";
  request.text = R"(
[loop]
frames = 120
rest_frames = 80
substeps = 20
time_step_s = 1e-3
density_kg_per_m3 = 500
bone_motion = "interpolated"
[effects.damping]
rate_per_s = 40
[effects.edge_length]
compliance_m_per_n = 0.01
[effects.volume]
pressure = 1.3
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[[bone]]
name = "lid"
mesh = "synthetic:lid"
[bone.motion]
axis = [0, 1, 0]
centre_m = [-10, 0, 0.05]
from_deg = 0
to_deg = 0.03438
course = "there"
)";
  request.text += "[[muscle]]\nname = \"ball\"\nmesh = \"synthetic:ball\"\n";
  if (two) {
    request.text += "[[muscle]]\nname = \"other\"\nmesh = \"synthetic:other\"\n[contact]\nmuscle_contact = true\n";
  }
  const double top_m = two ? 0.0801 : 0.0401;
  request.synthetic_mesh = [top_m](const std::string& name) {
    if (name == "ball") return moved(make_sphere(0.02, 4), Vec3(0, 0, 0.02005));
    if (name == "other") return moved(make_sphere(0.02, 4), Vec3(0, 0, 0.06005));
    return moved(make_box(Vec3(0.04, 0.04, 0.005), 1), Vec3(0, 0, name == "plate" ? -0.005 : top_m + 0.005));
  };
  return read_scene(request);
}

/// Imbert and Fick: a sphere full of liquid in a thin skin presses on what flattens it with the pressure inside,
/// which the force of the volume on its free nodes tells.
TEST(Forces, OfABallOfLiquidPressWithThePressureInside) {
  for (const bool two : {false, true}) {
    Done done(pressed_ball(two), false);
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
  }
}

/// The lower ball is attached whole: its bone bears the upper one.
TEST(Forces, OfAMuscleOnAnAttachedOneReachItsBone) {
  SceneRequest request;
  request.name = request.file = "stacked.toml";
  request.text = R"(
[loop]
frames = 60
substeps = 20
time_step_s = 1e-3
density_kg_per_m3 = 1060
[effects.gravity]
[effects.damping]
rate_per_s = 50
[effects.attachment]
[effects.edge_length]
compliance_m_per_n = 0.05
[effects.volume]
[effects.friction]
[[bone]]
name = "plate"
mesh = "synthetic:plate"
[[muscle]]
name = "lower"
mesh = "synthetic:lower"
[[muscle]]
name = "upper"
mesh = "synthetic:upper"
[contact]
muscle_contact = true
[[attachment]]
name = "foot"
bone = "plate"
muscle = "lower"
outline_m = [[-0.03, -0.03, 0], [0.03, -0.03, 0], [0.03, 0.03, 0], [-0.03, 0.03, 0]]
distance_m = 0.05
)";
  request.synthetic_mesh = [](const std::string& name) {
    if (name == "plate") return moved(make_box(Vec3(0.04, 0.04, 0.005), 4), Vec3(0, 0, -0.005));
    if (name == "lower") return moved(make_box(Vec3(0.02, 0.02, 0.005), 4), Vec3(0, 0, 0.0051));
    return moved(make_box(Vec3(0.01, 0.01, 0.01), 4), Vec3(0, 0, 0.0202));
  };
  const Scene scene = read_scene(request);
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
  const Scene standard = load_scene({"synthetic/iliacus", "standard", "", {}});
  EXPECT_EQ(force_obstacles(standard, {ResponseKind::project}).text(), "");
}

}  // namespace
}  // namespace musclebench

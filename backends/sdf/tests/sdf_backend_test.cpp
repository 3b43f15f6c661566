#include "backends/sdf/sdf_backend.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "backends/sdf/files/kept_fields.hpp"
#include "core/base/input_error.hpp"
#include "core/base/temporary_folder.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/tests/random_points.hpp"

namespace musclebench {
namespace {

using Given = std::map<std::string, ParameterValue>;

std::unique_ptr<CollisionBackend> make_grid(const Given& given = {{"cells", std::int64_t{16}}}) {
  return make_sdf_backend(Parameters(sdf_parameters(), given, "test"));
}

std::vector<Bone> two_bones() {
  return {{"sphere", {make_sphere(0.1, 4), true, {}}}, {"box/of 2", {make_box({0.05, 0.1, 0.05}, 3), true, {}}}};
}

std::vector<Contact> contacts_of(CollisionBackend& backend, const std::vector<Vec3>& positions) {
  std::vector<int> nodes(positions.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<Contact> contacts{{99, 99, 1, Vec3::Zero()}};
  backend.detect(positions, nodes, contacts);
  return contacts;
}

TEST(SdfBackend, FindsDepthAndNormalInMovedBones) {
  const std::vector<Bone> bones = two_bones();
  const auto backend = make_grid();
  backend->build(bones, {}, 1);
  const RigidMotion away = RigidMotion::about_axis(Vec3(1, 2, 2) / 3, {0.1, 0.2, 0.3}, 2.5);
  const std::vector<RigidMotion> poses{RigidMotion{Mat3::Identity(), {0.3, 0, 0}}, away};
  const std::vector<Vec3> in_box = random_points(0.12, 3000, 21);
  std::vector<Vec3> positions;
  for (const Vec3& point : in_box) {
    positions.push_back(away.apply(point));
  }
  backend->update(poses, positions);
  const std::vector<Contact> contacts = contacts_of(*backend, positions);
  std::vector<bool> found(positions.size(), false);
  for (const Contact& contact : contacts) {
    const auto node = static_cast<std::size_t>(contact.node);
    ASSERT_EQ(contact.bone, 1);
    found[node] = true;
    const Vec3 gaps = Vec3(0.05, 0.1, 0.05) - in_box[node].cwiseAbs();
    EXPECT_NEAR(contact.depth_m, gaps.minCoeff(), 2e-3);
    EXPECT_NEAR(contact.normal.norm(), 1, 1e-12);
    if (contact.depth_m < 0.01 && (gaps.array() > 0.02).count() == 2) {
      int axis = 0;
      gaps.minCoeff(&axis);
      const Vec3 expected = away.apply_to_direction(Vec3::Unit(axis) * (in_box[node][axis] > 0 ? 1 : -1));
      EXPECT_GT(contact.normal.dot(expected), 0.98);
    }
  }
  for (std::size_t node = 0; node < positions.size(); ++node) {
    const double gap = (Vec3(0.05, 0.1, 0.05) - in_box[node].cwiseAbs()).minCoeff();
    if (std::abs(gap) > 1e-3) {
      EXPECT_EQ(found[node], gap > 0) << in_box[node].transpose();
    }
  }
}

TEST(SdfBackend, OrdersByBoneThenNodeAndAnswersForSubsets) {
  const std::vector<Bone> bones = two_bones();
  const auto backend = make_grid();
  backend->build(bones, {}, 1);
  const std::vector<Vec3> positions = random_points(0.12, 1000, 21);
  const std::vector<Contact> all = contacts_of(*backend, positions);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](const Contact& a, const Contact& b) {
    return std::pair(a.bone, a.node) < std::pair(b.bone, b.node);
  }));
  EXPECT_GT(std::count_if(all.begin(), all.end(), [](const Contact& c) { return c.bone == 0; }), 50);
  EXPECT_GT(std::count_if(all.begin(), all.end(), [](const Contact& c) { return c.bone == 1; }), 50);
  std::vector<Contact> subset;
  const std::vector<int> nodes{all[3].node, all[7].node};
  backend->detect(positions, nodes, subset);
  for (const Contact& contact : subset) {
    EXPECT_TRUE(contact.node == nodes[0] || contact.node == nodes[1]);
  }
  EXPECT_GE(subset.size(), 2U);
}

TEST(SdfBackend, NodesFarAwayAndNodesThatAreNoNumbersAreFree) {
  const std::vector<Bone> bones = two_bones();
  const auto backend = make_grid();
  backend->build(bones, {}, 1);
  EXPECT_TRUE(contacts_of(*backend, {{5, 5, 5}, {1e300, 0, 0}, {0, std::nan(""), 0}, {-INFINITY, 0, 0}}).empty());
}

TEST(SdfBackend, HasANormalWhereTheGradientVanishes) {
  // With one cell the field of a sphere is flat in the middle of the sphere.
  const std::vector<Bone> bones{{"sphere", {make_sphere(0.1, 3), true, {}}}};
  for (const std::int64_t cells : {1, 2, 3}) {
    const auto backend = make_grid({{"cells", cells}});
    backend->build(bones, {}, 1);
    for (const Contact& contact : contacts_of(*backend, {{0, 0, 0}, {1e-9, 0, 0}, {0, 1e-18, 0}})) {
      EXPECT_NEAR(contact.normal.norm(), 1, 1e-12);
    }
  }
}

/// Nodes that wander about the bones, some outside of all boxes.
std::vector<std::vector<Vec3>> wandering_nodes(int frames) {
  std::mt19937 generator(2);
  std::normal_distribution<double> normal(0, 1);
  std::vector<Vec3> positions = random_points(0.2, 1500, 21);
  std::vector<std::vector<Vec3>> path;
  for (int frame = 0; frame < frames; ++frame) {
    for (std::size_t n = 0; n < positions.size(); ++n) {
      const double step = n % 7 == 0 ? 0.02 : 0.002;
      positions[n] += step * Vec3(normal(generator), normal(generator), normal(generator));
    }
    if (frame == 3) {
      positions[5] = {std::nan(""), 0, 0};
    }
    path.push_back(positions);
  }
  return path;
}

void expect_equal_contacts(const std::vector<Contact>& one, const std::vector<Contact>& other) {
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].bone, other[i].bone);
    ASSERT_EQ(one[i].node, other[i].node);
    ASSERT_EQ(one[i].depth_m, other[i].depth_m);
    ASSERT_EQ(one[i].normal, other[i].normal);
  }
}

TEST(SdfBackend, CacheAndThreadsChangeNoContact) {
  const std::vector<Bone> bones = two_bones();
  const std::vector<std::vector<Vec3>> path = wandering_nodes(30);
  const auto made = [&](const std::string& cache, int threads) {
    auto backend = make_grid({{"cells", std::int64_t{24}}, {"clearance_cache", cache}});
    backend->build(bones, {}, threads);
    return backend;
  };
  const auto plain = made("off", 1);
  std::vector<std::unique_ptr<CollisionBackend>> others;
  others.push_back(made("on", 1));
  others.push_back(made("off", 2));
  others.push_back(made("on", 3));
  std::size_t found = 0;
  for (std::size_t frame = 0; frame < path.size(); ++frame) {
    const double turn = 0.02 * static_cast<double>(frame);
    const std::vector<RigidMotion> poses{RigidMotion::about_axis(Vec3::UnitZ(), {0.1, 0, 0}, turn),
                                         RigidMotion::about_axis(Vec3::UnitX(), {0, 0.05, 0}, -3 * turn)};
    plain->update(poses, path[frame]);
    const std::vector<Contact> expected = contacts_of(*plain, path[frame]);
    found += expected.size();
    for (const auto& backend : others) {
      backend->update(poses, path[frame]);
      expect_equal_contacts(contacts_of(*backend, path[frame]), expected);
    }
  }
  EXPECT_GT(found, 3000U);
}

TEST(SdfBackend, TellsTheErrorOfEachStructure) {
  const std::vector<Bone> bones = two_bones();
  const auto backend = make_grid({{"clearance_cache", std::string("off")}});
  backend->build(bones, {}, 1);
  const std::vector<StructureError> errors = backend->structure_errors();
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_EQ(errors[1].bone, "box/of 2");
  EXPECT_EQ(errors[0].bytes + errors[1].bytes, backend->structure_bytes());
  EXPECT_GT(errors[0].samples, 1000);
  EXPECT_GT(errors[0].largest_m, errors[0].p99_m);
  EXPECT_LT(errors[1].largest_m, 0.01);
  EXPECT_GT(errors[1].p99_m, 1e-6);
}

TEST(SdfBackend, CountsItsBytes) {
  const std::vector<Bone> bones = two_bones();
  const auto backend = make_grid({{"cells", std::int64_t{8}}, {"clearance_cache", std::string("off")}});
  backend->build(bones, {}, 1);
  const std::size_t fields = 2 * (9 * 9 * (7 * 9 - 2) * sizeof(float) + 512 / 8);
  EXPECT_EQ(backend->structure_bytes(), fields);
  const TriangleMesh muscle = make_sphere(0.01, 2);
  const auto with_cache = make_grid({{"cells", std::int64_t{8}}});
  with_cache->build(bones, muscle, 1);
  EXPECT_GE(with_cache->structure_bytes(), fields + 2 * 4 * sizeof(float) * muscle.vertices.size());
  EXPECT_TRUE(backend->capabilities().depth);
}

TEST(SdfBackend, StaysWithinTheBoundItDeclares) {
  const std::vector<Bone> bones = two_bones();
  const auto backend = make_grid();
  backend->build(bones, {}, 1);
  const std::vector<Vec3> positions = random_points(0.12, 3000, 21);
  std::vector<bool> found(positions.size(), false);
  for (const Contact& contact : contacts_of(*backend, positions)) {
    if (contact.bone == 1) {
      found[static_cast<std::size_t>(contact.node)] = true;
    }
  }
  const AnswerBound bound = backend->answer_bound(1);
  EXPECT_LT(bound.missed_depth_m, 0.01);
  for (std::size_t node = 0; node < positions.size(); ++node) {
    // Beyond a face, edge or corner of the box the distance is at least the largest overshoot.
    const double inner_gap = (Vec3(0.05, 0.1, 0.05) - positions[node].cwiseAbs()).minCoeff();
    EXPECT_TRUE(found[node] || inner_gap <= bound.missed_depth_m) << positions[node].transpose();
    EXPECT_TRUE(!found[node] || inner_gap >= -bound.false_distance_m) << positions[node].transpose();
  }
}

TEST(SdfBackend, RefusesAGridThatDoesNotFitBeforeItAllocates) {
  const std::vector<Bone> bones = two_bones();
  try {
    make_grid({{"cells", std::int64_t{4096}}})->build(bones, {}, 1);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("MB"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("cells fit"), std::string::npos) << error.what();
  }
  try {
    make_grid({{"cell_size_m", 5e-5}})->build(bones, {}, 1);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("sdf: cell_size_m"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(" m fit"), std::string::npos) << error.what();
  }
  EXPECT_THROW(make_grid({{"cell_size_m", 0.5}})->build(bones, {}, 1), InputError);
  EXPECT_THROW(make_grid({{"cells", std::int64_t{0}}}), InputError);
}

TEST(SdfBackend, RefusesWhatAnotherParameterMakesMeaningless) {
  const Given cells{{"cells", std::int64_t{8}}};
  const Given cell_size{{"cell_size_m", 0.01}};
  const Given margin{{"margin", 0.01}};
  const Given structures{{"structures", std::string("here")}};
  const Given discregrid{{"discregrid", std::string("here")}};
  const Given max_error{{"max_error_mm", 0.5}};
  const auto is_refused = [](Given given, const Given& chosen) {
    given.insert(chosen.begin(), chosen.end());
    try {
      (void)make_grid(given);
    } catch (const InputError& error) {
      return std::string(error.what()).find("leave out this or `" + chosen.begin()->first) != std::string::npos;
    }
    return false;
  };
  for (const Given& other : {cells, cell_size, discregrid}) {
    EXPECT_TRUE(is_refused(other, max_error)) << other.begin()->first;
  }
  for (const Given& other : {cells, cell_size, margin, structures}) {
    EXPECT_TRUE(is_refused(other, discregrid)) << other.begin()->first;
  }
  EXPECT_TRUE(is_refused(cells, cell_size));
  for (const Given& other : {cells, margin, structures}) {
    EXPECT_FALSE(is_refused(margin, other)) << other.begin()->first;
  }
}

TEST(SdfBackend, KeepsItsStructuresAndChecksThem) {
  const TemporaryFolder folder;
  const std::vector<Bone> bones = two_bones();
  const Given given{{"cells", std::int64_t{8}}, {"structures", folder.path().string()}};
  const std::vector<Vec3> positions = random_points(0.12, 500, 21);
  std::vector<std::vector<Contact>> answers;
  for (int run = 0; run < 2; ++run) {
    const auto backend = make_grid(given);
    backend->build(bones, {}, 1);
    EXPECT_EQ(backend->structure_origin().is_from_file, run == 1);
    answers.push_back(contacts_of(*backend, positions));
  }
  ASSERT_EQ(answers[0].size(), answers[1].size());
  for (std::size_t i = 0; i < answers[0].size(); ++i) {
    EXPECT_EQ(answers[0][i].node, answers[1][i].node);
    EXPECT_EQ(answers[0][i].depth_m, answers[1][i].depth_m);
    EXPECT_EQ(answers[0][i].normal, answers[1][i].normal);
  }
  const std::filesystem::path kept = folder / content_address("8cells", surface_digest(bones[0].surface), "field");
  ASSERT_TRUE(std::filesystem::exists(kept));
  std::ofstream(kept) << "rubbish";
  EXPECT_THROW(make_grid(given)->build(bones, {}, 1), InputError);
}

TEST(SdfBackend, KeepsMarginsApartAndSharesFieldsByTheirContent) {
  const TemporaryFolder folder;
  for (const Given& kind : {Given{{"cells", std::int64_t{4}}}, Given{{"max_error_mm", 5.0}}}) {
    bool is_kept = false;
    for (const char* name : {"hip-1", "hip_1", "../hip"}) {
      for (const double margin : {1e-3, 0.05, 0.2}) {
        Given given = kind;
        given["margin"] = margin;
        given["structures"] = folder.path().string();
        const auto backend = make_grid(given);
        backend->build(std::vector<Bone>{{name, {make_sphere(0.1, 2), true, {}}}}, {}, 1);
        EXPECT_EQ(backend->structure_origin().is_from_file, is_kept) << name << ", " << margin;
        EXPECT_EQ(backend->structure_origin().kept_build_ns.value_or(0) > 0, is_kept);
      }
      is_kept = true;
    }
  }
  const auto files =
      std::distance(std::filesystem::directory_iterator(folder.path()), std::filesystem::directory_iterator());
  EXPECT_EQ(files, 12) << "a field and its note for each of two kinds and three margins";
}

}  // namespace
}  // namespace musclebench

// The clearance cache changes no bit: a whole motion with and without it, on every backend that can keep one.
#include <algorithm>
#include <map>
#include <random>

#include "backends/tests/contract.hpp"
#include "core/base/input_error.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {
namespace {

/// Bones on which the side is not told by the closest triangle alone: a ball with a hole, over which the side changes
/// in empty space, and two balls of one bone that overlap.
TriangleMesh ball_with_a_hole() {
  TriangleMesh mesh = make_sphere(sphere_radius_m, 4);
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(t[i])]; };
    return (corner(0) + corner(1) + corner(2)).normalized().x() > 0.985;
  });
  return mesh;
}

TriangleMesh overlapping_balls() {
  TriangleMesh mesh = make_sphere(0.8 * sphere_radius_m, 3);
  const TriangleMesh other = make_sphere(0.7 * sphere_radius_m, 3);
  const auto first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& vertex : other.vertices) {
    mesh.vertices.emplace_back(vertex + Vec3(0, 0.9 * sphere_radius_m, 0));
  }
  for (const Triangle& t : other.triangles) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return mesh;
}

/// A muscle that slides, turns and shakes past two bones, with a jump in the middle; between the steps a response
/// queries some nodes at other positions.
void expect_that_the_cache_changes_no_bit(const BackendEntry& entry, const std::vector<Bone>& bones, const Vec3& start,
                                          const Vec3& slide, const Vec3& bones_at = Vec3::Zero()) {
  std::map<std::string, ParameterValue> common = entry.for_points;
  if (find_parameter(entry.parameters, "cells") != nullptr) {
    common["cells"] = std::int64_t{24};
  }
  const TriangleMesh mesh = muscle();
  const auto build_with = [&](const std::string& word, int threads) {
    std::map<std::string, ParameterValue> given = common;
    given[find_parameter(entry.parameters, ParameterRole::clearance_cache)->name] = word;
    auto backend = entry.make(Parameters(entry.parameters, given, "test"));
    backend->build(bones, mesh, threads);
    return backend;
  };
  // A library may refuse an open bone, or find no inside in it.
  const bool are_closed = std::ranges::all_of(bones, [](const Bone& bone) { return is_closed(bone.surface.mesh); });
  std::unique_ptr<CollisionBackend> plain;
  try {
    plain = build_with("off", 1);
  } catch (const InputError&) {
    ASSERT_FALSE(are_closed);
    return;
  }
  std::vector<std::unique_ptr<CollisionBackend>> with;
  with.push_back(build_with("on", 1));
  with.push_back(build_with("on", 3));
  std::mt19937 random(11);
  std::normal_distribution<double> shake(0, 1e-4);
  std::size_t met = 0;
  for (int step = 0; step < 20; ++step) {
    const double turn = 0.01 * step + (step > 16 ? 0.8 : 0);
    const RigidMotion to_origin{Mat3::Identity(), -bones_at};
    const std::vector<RigidMotion> poses = {
        RigidMotion::about_axis(Vec3(1, 2, -0.5).normalized(), Vec3(0.01, 0, 0), turn) * to_origin,
        RigidMotion::about_axis(Vec3::UnitZ(), Vec3(0, 0.02, 0), -turn) * to_origin};
    std::vector<Vec3> positions = moved(mesh.vertices, {Mat3::Identity(), start + step * slide});
    for (Vec3& position : positions) {
      position += Vec3(shake(random), shake(random), shake(random));
    }
    std::vector<int> some;
    for (const int node : all_nodes(mesh)) {
      if (node % 7 == step % 7) {
        some.push_back(node);
      }
    }
    const std::vector<Vec3> elsewhere = moved(positions, {Mat3::Identity(), Vec3(-0.002, 0.001, 0)});
    const std::vector<Contact> expected = Contract::detect(*plain, poses, positions, all_nodes(mesh));
    std::vector<Contact> expected_of_some;
    plain->detect(elsewhere, some, expected_of_some);
    std::vector<Vec3> pushed = positions;
    std::vector<int> in_contact;
    for (const Contact& contact : expected) {
      pushed[static_cast<std::size_t>(contact.node)] += contact.depth_m * contact.normal;
      in_contact.push_back(contact.node);
    }
    std::sort(in_contact.begin(), in_contact.end());
    in_contact.erase(std::unique(in_contact.begin(), in_contact.end()), in_contact.end());
    std::vector<Contact> expected_of_pushed;
    plain->detect(pushed, in_contact, expected_of_pushed);
    met += expected.size();
    for (const auto& backend : with) {
      expect_same_bits(Contract::detect(*backend, poses, positions, all_nodes(mesh)), expected);
      std::vector<Contact> of_some;
      backend->detect(elsewhere, some, of_some);
      expect_same_bits(of_some, expected_of_some);
      // Where a response puts them, and from there the next step begins.
      std::vector<Contact> of_pushed;
      backend->detect(pushed, in_contact, of_pushed);
      expect_same_bits(of_pushed, expected_of_pushed);
    }
  }
  if (are_closed) {
    EXPECT_GT(met, 500U);
  }
}

TEST_P(Contract, TheClearanceCacheChangesNoBitOfAMotion) {
  const BackendEntry& entry = find_backend(GetParam());
  if (find_parameter(entry.parameters, ParameterRole::clearance_cache) == nullptr) {
    GTEST_SKIP() << GetParam() << " keeps no clearance cache";
  }
  const auto bone = [](const TriangleMesh& mesh) { return Bone{"bone", repair_mesh(mesh, "bone")}; };
  const std::vector<AnalyticBone> shapes = analytic_bones();
  expect_that_the_cache_changes_no_bit(entry, {bone(shapes[0].mesh), bone(shapes[1].mesh)}, Vec3::Zero(),
                                       {-3e-4, 0, 6e-4});
  const Bone open{"bone", {ball_with_a_hole(), false, {}}};  // `repair_mesh` would close it
  expect_that_the_cache_changes_no_bit(entry, {open, bone(overlapping_balls())}, {0.027, -0.006, 0.004},
                                       {-1.1e-3, 0, 0});
  // As scans have it: far from the rest frame's origin, where a position has fewer digits than a touching distance.
  std::vector<Bone> far = {bone(shapes[0].mesh), bone(shapes[1].mesh)};
  const Vec3 away(1e4, -2e4, 3e4);
  for (Bone& bone_there : far) {
    for (Vec3& vertex : bone_there.surface.mesh.vertices) {
      vertex += away;
    }
  }
  expect_that_the_cache_changes_no_bit(entry, far, Vec3::Zero(), {-3e-4, 0, 6e-4}, away);
}

}  // namespace
}  // namespace musclebench

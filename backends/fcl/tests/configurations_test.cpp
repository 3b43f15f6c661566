// What each configuration of FCL 0.7 answers, compared with brute force while a scene moves and deforms. Where it is
// wrong, the test expects that it is wrong in the way that we know, so that a repaired FCL would be noticed.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include <gtest/gtest.h>

#include "backends/brute_force/brute_force_surface.hpp"
#include "backends/fcl/fcl_backend.hpp"
#include "backends/fcl/surfaces/surface_collider.hpp"
#include "backends/fcl/tests/intersecting_triangles.hpp"
#include "backends/fcl/tests/moving_scene.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {
namespace {

enum class Verdict {
  right,    ///< all that brute force finds, and nothing else
  loses,    ///< a part of that: bottom-up, FCL 0.7 merges RSS volumes along wrong axes
  blind,    ///< right up to the sphere's radius, nothing deeper
  refused,  ///< FCL cannot answer it, or it has no meaning
};
using enum Verdict;

struct Row {
  const char* query;
  const char* volume;
  Verdict refit;
  Verdict refit_top_down;
  Verdict rebuild;
};

// The same for both models and all managers, which only surfaces have, both solvers and any number of threads.
constexpr Row table[] = {
    // query         volume    refit    top down rebuild
    {"surfaces", "OBBRSS", right, right, right},
    {"surfaces", "OBB", right, right, right},
    {"surfaces", "RSS", loses, right, right},
    {"surfaces", "kIOS", right, right, right},
    {"surfaces", "AABB", right, right, right},
    {"surfaces", "KDOP24", right, right, right},
    {"node_distance", "OBBRSS", right, refused, refused},
    {"node_distance", "OBB", refused, refused, refused},
    {"node_distance", "RSS", right, refused, refused},
    {"node_distance", "kIOS", right, refused, refused},
    {"node_distance", "AABB", refused, refused, refused},
    {"node_distance", "KDOP24", refused, refused, refused},
    {"node_collide", "OBBRSS", blind, refused, refused},
    {"node_collide", "OBB", blind, refused, refused},
    {"node_collide", "RSS", blind, refused, refused},
    {"node_collide", "kIOS", blind, refused, refused},
    {"node_collide", "AABB", blind, refused, refused},
    {"node_collide", "KDOP24", blind, refused, refused},
};

constexpr int steps = 3;
constexpr double radius_m = 4e-3;

using Given = std::map<std::string, ParameterValue>;

struct Configuration {
  Given given;
  int threads;

  [[nodiscard]] Parameters parameters() const { return {fcl_parameters(), given, "test"}; }
  [[nodiscard]] std::string text() const {
    std::string all = std::to_string(threads) + " threads";
    for (const auto& [key, value] : given) {
      all += " " + key + "=" + format_parameter_value(value);
    }
    return all;
  }
};

/// A row's configurations with one way to update.
std::vector<Configuration> configurations(const Row& row, const char* update) {
  std::vector<Configuration> all;
  const bool surfaces = row.query == std::string("surfaces");
  for (const char* manager : {"dynamic_aabb_tree", "sweep_and_prune", "none"}) {
    for (const char* model : {"replace", "update"}) {
      for (const char* solver : {"libccd", "indep"}) {
        const bool indep = solver == std::string("indep");
        Given given = {{"query", std::string(row.query)}, {"bounding_volume", std::string(row.volume)},
                       {"update", std::string(update)},   {"model", std::string(surfaces ? model : "replace")},
                       {"manager", std::string(manager)}, {"solver", std::string(solver)}};
        if (row.query == std::string("node_collide")) {
          given["node_radius_m"] = radius_m;
        }
        if (surfaces || (model == std::string("replace") && manager == std::string("dynamic_aabb_tree"))) {
          all.push_back({given, indep ? 2 : 1});
        }
      }
    }
  }
  return all;
}

/// What brute force finds, at every step and for both bones.
struct Truth {
  struct Node {
    int node;
    double depth_m;
  };
  std::vector<std::array<PairSet, 2>> pairs;
  std::vector<std::array<std::vector<Node>, 2>> inside;
};

const Truth& truth() {
  static const Truth found = [] {
    const MovingScene scene;
    Truth all;
    for (int step = 0; step < steps; ++step) {
      const auto poses = scene.poses(step);
      const auto positions = scene.positions(step);
      all.pairs.emplace_back();
      all.inside.emplace_back();
      for (std::size_t bone = 0; bone < 2; ++bone) {
        const TriangleMesh& mesh = scene.bones[bone].surface.mesh;
        all.pairs.back()[bone] = intersecting_pairs(positions, scene.muscle.triangles, mesh, poses[bone]);
        for (std::size_t node = 0; node < positions.size(); ++node) {
          const SurfacePoint point = locate_by_brute_force(mesh, poses[bone].apply_inverse(positions[node]));
          if (point.inside) {
            all.inside.back()[bone].push_back({static_cast<int>(node), point.distance_m});
          }
        }
      }
    }
    return all;
  }();
  return found;
}

void check_surfaces(const Configuration& configuration, Verdict verdict) {
  const MovingScene scene;
  const auto collider = make_surface_collider(fcl_options(configuration.parameters()), pointers_to(scene.bones),
                                              {muscle_surface(scene.muscle, "muscle")}, configuration.threads);
  std::vector<std::vector<TrianglePair>> pairs;
  std::size_t lost = 0;
  for (int step = 0; step < steps; ++step) {
    collider->move_bones(scene.poses(step));
    collider->deform(0, scene.positions(step));
    collider->collide_bones(pairs);
    for (std::size_t bone = 0; bone < 2; ++bone) {
      const PairSet& expected = truth().pairs[static_cast<std::size_t>(step)][bone];
      PairSet found;
      for (const TrianglePair& pair : pairs[bone]) {
        found.emplace(pair.muscle_triangle, pair.other_triangle);
      }
      EXPECT_EQ(pairs[bone].size(), found.size()) << "a pair came twice, step " << step << " bone " << bone;
      EXPECT_TRUE(std::includes(expected.begin(), expected.end(), found.begin(), found.end()));
      lost += expected.size() - found.size();
    }
  }
  EXPECT_EQ(lost > 0, verdict == loses) << lost << " pairs lost";
}

void check_nodes(const Configuration& configuration, Verdict verdict) {
  const MovingScene scene;
  const auto backend = make_fcl_backend(configuration.parameters());
  backend->build(scene.bones, scene.muscle, configuration.threads);
  std::vector<int> nodes(scene.muscle.vertices.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  const double reach_m = verdict == blind ? radius_m : std::numeric_limits<double>::infinity();
  std::vector<Contact> contacts;
  for (int step = 0; step < steps; ++step) {
    const auto poses = scene.poses(step);
    const auto positions = scene.positions(step);
    backend->update(poses, positions);
    backend->detect(positions, nodes, contacts);
    auto contact = contacts.begin();
    for (std::size_t bone = 0; bone < 2; ++bone) {
      for (const Truth::Node& inside : truth().inside[static_cast<std::size_t>(step)][bone]) {
        if (inside.depth_m > reach_m) {
          continue;
        }
        ASSERT_NE(contact, contacts.end()) << "missed: step " << step << " bone " << bone << " node " << inside.node;
        ASSERT_EQ(contact->bone, static_cast<int>(bone)) << "step " << step;
        ASSERT_EQ(contact->node, inside.node) << "step " << step << " bone " << bone;
        EXPECT_NEAR(contact->depth_m, inside.depth_m, 1e-14);
        const Vec3 out = positions[static_cast<std::size_t>(inside.node)] + contact->depth_m * contact->normal;
        const SurfacePoint point =
            locate_by_brute_force(scene.bones[bone].surface.mesh, poses[bone].apply_inverse(out));
        EXPECT_LT(point.distance_m, 1e-14) << "step " << step << " bone " << bone << " node " << inside.node;
        ++contact;
      }
    }
    EXPECT_EQ(contact, contacts.end()) << "reported and not inside: step " << step;
  }
}

class Configurations : public testing::TestWithParam<Row> {};

TEST_P(Configurations, AnswerAsTheTableSays) {
  const Row& row = GetParam();
  const std::pair<const char*, Verdict> updates[] = {
      {"refit", row.refit}, {"refit_top_down", row.refit_top_down}, {"rebuild", row.rebuild}};
  for (const auto& [update, verdict] : updates) {
    for (const Configuration& configuration : configurations(row, update)) {
      SCOPED_TRACE(configuration.text());
      if (verdict == refused) {
        EXPECT_THROW(fcl_options(configuration.parameters()), InputError);
      } else if (row.query == std::string("surfaces")) {
        check_surfaces(configuration, verdict);
      } else {
        check_nodes(configuration, verdict);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Configurations, testing::ValuesIn(table),
                         [](const auto& test) { return std::string(test.param.query) + "_" + test.param.volume; });

TEST(Configurations, TheSceneTellsThemApart) {
  for (int step = 0; step < steps; ++step) {
    for (std::size_t bone = 0; bone < 2; ++bone) {
      const auto& inside = truth().inside[static_cast<std::size_t>(step)][bone];
      const auto deep = std::count_if(inside.begin(), inside.end(), [](const auto& n) { return n.depth_m > radius_m; });
      EXPECT_GT(truth().pairs[static_cast<std::size_t>(step)][bone].size(), 50U);
      EXPECT_GT(deep, 20);
      EXPECT_GT(static_cast<std::ptrdiff_t>(inside.size()) - deep, 5);
    }
  }
}

TEST(Configurations, TheTableHasEveryQueryWithEveryVolume) {
  EXPECT_EQ(std::size(table), 3 * bounding_volumes().size());
}

}  // namespace
}  // namespace musclebench

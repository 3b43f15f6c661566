#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "backends/registry.hpp"
#include "bench/cases/scene_source.hpp"
#include "bench/hard/hard_case.hpp"
#include "bench/hard/tests/broken_backend.hpp"
#include "bench/queries/check_queries.hpp"
#include "bench/queries/query_set_file.hpp"

// A case that can't fail tests nothing: each is seen red once.
namespace musclebench {
namespace {

/// Misses every seventh node.
BackendEntry forgets(BackendEntry base) {
  return broken(std::move(base), "forgets", [] {
    return [](std::vector<Contact>& contacts, int) {
      std::erase_if(contacts, [](const Contact& contact) { return contact.node % 7 == 3; });
    };
  });
}

/// Misses all nodes but the first forty.
BackendEntry misses_most(BackendEntry base) {
  return broken(std::move(base), "misses_most", [] {
    return [](std::vector<Contact>& contacts, int) {
      std::erase_if(contacts, [](const Contact& contact) { return contact.node > 40; });
    };
  });
}

/// Answers with the contacts of the detection before.
BackendEntry lags(BackendEntry base) {
  return broken(std::move(base), "lags", [] {
    return
        [before = std::vector<Contact>()](std::vector<Contact>& contacts, int) mutable { std::swap(contacts, before); };
  });
}

/// Its normals are tilted by some 20 degrees.
BackendEntry leans(BackendEntry base) {
  return broken(std::move(base), "leans", [] {
    return [](std::vector<Contact>& contacts, int) {
      for (Contact& contact : contacts) contact.normal = (contact.normal + 0.3 * Vec3(1, 1, 1)).normalized();
    };
  });
}

/// Its surface lies 1 mm inside the bone's.
BackendEntry leaks(BackendEntry base) {
  constexpr double inwards_m = 1e-3;
  if (base.signed_distance) {
    base.signed_distance = [sound = base.signed_distance](const Bone& bone, int threads) {
      return [distance = sound(bone, threads)](const Vec3& point) { return distance(point) + inwards_m; };
    };
  }
  return broken(std::move(base), "leaks", [] {
    return [](std::vector<Contact>& contacts, int) {
      std::erase_if(contacts, [](Contact& contact) { return (contact.depth_m -= inwards_m) < 0; });
    };
  });
}

/// Normals that are a little too long.
BackendEntry stretches(BackendEntry base) {
  return broken(std::move(base), "stretches", [] {
    return [](std::vector<Contact>& contacts, int) {
      for (Contact& contact : contacts) contact.normal *= 1 + 1e-9;
    };
  });
}

/// A tolerance in metres.
BackendEntry deepens(BackendEntry base) {
  return broken(std::move(base), "deepens", [] {
    return [](std::vector<Contact>& contacts, int) {
      for (Contact& contact : contacts) contact.depth_m += 1e-6;
    };
  });
}

/// Finds a node that is nowhere near.
BackendEntry invents(BackendEntry base) {
  return broken(std::move(base), "invents", [] {
    return [](std::vector<Contact>& contacts, int) {
      if (contacts.empty() || contacts.front().node != 0)
        contacts.insert(contacts.begin(), Contact{0, 0, 1e-4, Vec3::UnitZ()});
    };
  });
}

/// Depths depend on the number of threads.
BackendEntry counts_threads(BackendEntry base) {
  return broken(std::move(base), "counts_threads", [] {
    return [](std::vector<Contact>& contacts, int threads) {
      for (Contact& contact : contacts) contact.depth_m += 1e-9 * (threads - 1);
    };
  });
}

/// Depths depend on the SIMD instruction set.
BackendEntry counts_lanes(BackendEntry base) {
  return broken(std::move(base), "counts_lanes", [] {
    return [](std::vector<Contact>& contacts, int) {
      for (Contact& contact : contacts) contact.depth_m += 1e-9 * static_cast<double>(hwy::SupportedTargets() % 1009);
    };
  });
}

/// Makes 0.5 mm of the last bits of a depth.
BackendEntry amplifies(BackendEntry base) {
  return broken(std::move(base), "amplifies", [] {
    return [](std::vector<Contact>& contacts, int) {
      for (Contact& contact : contacts) contact.depth_m += 5e-4 * std::abs(std::sin(1e15 * contact.depth_m));
    };
  });
}

struct Breaks {
  std::string_view id;
  BackendEntry (*breaker)(BackendEntry base);
  std::string_view base = {};  ///< the backend that is broken; empty: the exact one
  bool is_slow = false;        ///< seconds: with the weekly tests
};

/// By what each case is seen red that asks a backend.
constexpr Breaks breakers[] = {
    {"oracle-brute-force", leaks},
    {"soundness", forgets},
    {"sdf-order-smooth", leaks, "sdf"},
    {"sdf-order-kink", leaks, "sdf"},
    {"open-nonmanifold", forgets},
    {"thin-plate", forgets},
    {"small-hole", forgets},
    {"far-from-origin", forgets},
    {"scale", deepens},
    {"rigid-motion", lags},
    {"on-features", stretches},
    {"domain-border", deepens},
    {"near-touching", forgets},
    {"internal-edge", leans},
    {"stale-structure", lags},
    {"threads", counts_threads},
    {"degenerate", forgets},
    {"inverted-normals", forgets},
    {"femur-winding", forgets},
    {"welded-bone", forgets},
    {"welded-input", misses_most, {}, true},
    {"step-size", leaks},
    {"initial-overlap", leaks},
    {"pinch", lags},
    {"rest", invents},
    {"resting-contact", leaks},
    {"face-over-edge", leaks},
    {"attached-inside", leaks},
    {"erleben-ten", leaks, {}, true},
    {"determinism", counts_threads, {}, true},
    {"groove", leans},
    {"long-run", leaks, {}, true},
    {"sensitivity", amplifies, {}, true},
    {"scaled-run", deepens, {}, true},
    {"judge-flush", blind},
    {"other-cpu", counts_lanes},
    {"empty-input", invents},
    {"huge-grid", blind, "sdf"},
    {"deep-tree", forgets, {}, true},
    {"many-nodes", leaks, {}, true},
    {"return-to-rest", leaks, {}, true},
    {"far-flexion", misses_most, {}, true},
    {"self-intersection", misses_most, {}, true},
};

const BackendEntry& base_of(const Breaks& row) { return row.base.empty() ? exact_backend() : find_backend(row.base); }

const HardCase& case_named(const std::vector<HardCase>& all, std::string_view id) {
  return *std::ranges::find(all, id, &HardCase::id);
}

/// Figures beyond their bars in a cell that hold in that of the sound backend, or are half as far off there: a case may
/// be red already.
std::set<std::string> newly_beyond(const HardCell& sound, const HardCell& cell) {
  std::set<std::string> names;
  for (const HardFigure& figure : cell.figures) {
    const auto before = std::ranges::find(sound.figures, figure.name, &HardFigure::name);
    if (figure.holds()) continue;
    if (before == sound.figures.end() || before->holds() || figure.value > 2 * before->value) names.insert(figure.name);
  }
  return names;
}

/// Whether the cell is red by more than that of the sound backend.
bool is_seen(const HardCell& sound, const HardCell& cell) {
  if (cell.verdict == Verdict::holds || cell.verdict == Verdict::not_applicable) return false;
  const bool has_diverged = cell.figures.empty() && !sound.figures.empty();
  return has_diverged || !newly_beyond(sound, cell).empty();
}

void expect_that_each_is_seen_broken(bool slow) {
  const std::vector<HardCase> all = hard_cases();
  for (const Breaks& row : breakers) {
    if (row.is_slow != slow) continue;
    SCOPED_TRACE(row.id);
    const HardCase& each = case_named(all, row.id);
    const BackendEntry& base = base_of(row);
    const HardCell sound = each.run({.backend = base});
    if (sound.verdict == Verdict::not_applicable) {
      // The real anatomy is not there, or takes too long on a busy machine.
      EXPECT_TRUE(slow || takes_too_long(sound)) << sound.detail;
      continue;
    }
    expect_sane_figures(each, sound);
    const BackendEntry broken_entry = row.breaker(base);
    const HardCell cell = each.run({.backend = broken_entry});
    if (takes_too_long(cell)) continue;
    EXPECT_TRUE(is_seen(sound, cell)) << broken_entry.name << ": " << name_of(cell.verdict) << " " << cell.detail;
    const BackendEntry blind_entry = blind(base);
    const HardCell unanswered = each.run({.backend = blind_entry});
    EXPECT_TRUE(is_seen(sound, unanswered)) << "blind: " << name_of(unanswered.verdict) << " " << unanswered.detail;
  }
}

/// Broken by an answer, and by none at all: where no bar can fail for a backend, its cell may not be green.
TEST(BrokenBackend, IsSeenByEachCaseThatAsksABackend) { expect_that_each_is_seen_broken(false); }

/// Takes minutes; asked for by .ci/weekly.
TEST(BrokenBackend, DISABLED_IsSeenByEachSlowCaseThatAsksABackend) { expect_that_each_is_seen_broken(true); }

void take_away(Scene& scene, std::string_view effect) {
  std::erase_if(scene.effects, [&](const SceneEffect& each) { return each.name == effect; });
}

void scale_muscle(Scene& scene, double factor) {
  for (Vec3& vertex : scene.muscle_mesh.vertices) vertex *= factor;
  for (Muscle& muscle : scene.muscles) {
    for (Vec3& vertex : muscle.file.mesh.vertices) vertex *= factor;
  }
}

void move_muscle_away(Scene& scene) {
  for (Vec3& vertex : scene.muscle_mesh.vertices) vertex.z() += 1;
}

struct Spoils {
  std::string_view id;
  void (*spoil)(Scene& scene);
  bool is_slow = false;
};

/// By what each case of the loop, or of the judge, is seen red: a scene that lacks what the bar is about.
constexpr Spoils spoils[] = {
    {"time-step", [](Scene& scene) { take_away(scene, "volume"); }, true},
    {"extremes", [](Scene& scene) { take_away(scene, "edge_length"); }, true},
    {"non-finite", [](Scene& scene) { take_away(scene, "gravity"); }},
    {"mass-ratio", [](Scene& scene) { scale_muscle(scene, 1e-3); }},
    {"wrong-unit", [](Scene& scene) { scale_muscle(scene, 1e-3); }},
    {"swallowed", move_muscle_away},
};

void expect_that_each_is_seen_spoilt(bool slow) {
  const std::vector<HardCase> all = hard_cases();
  const BackendEntry& loop = find_backend("null");
  for (const Spoils& row : spoils) {
    if (row.is_slow != slow) continue;
    const HardCase& each = case_named(all, row.id);
    const HardCell sound = each.run({.backend = loop});
    const HardCell cell = each.run({.backend = loop, .spoil = row.spoil});
    EXPECT_TRUE(is_seen(sound, cell)) << row.id << ": " << name_of(cell.verdict) << " " << cell.detail;
  }
}

TEST(SpoiltScene, IsSeenByEachCaseOfTheLoop) { expect_that_each_is_seen_spoilt(false); }

/// Takes half a minute; asked for by .ci/weekly.
TEST(SpoiltScene, DISABLED_IsSeenByEachSlowCaseOfTheLoop) { expect_that_each_is_seen_spoilt(true); }

/// Seen red by neither table; faults of tools/mutants turned them red.
constexpr std::string_view unbroken[] = {
    "step-size-unguarded",  // red for every backend, and all that it asks is that the judge says so
    "angle-rule",           // asks a stage of the loop: red with the fault guard-forgives-oblique-passages
    "announced-sizes",      // reads texts: red with the fault obj-index-wraps (tools/mutants)
};

TEST(HardCase, IsSeenRedOnce) {
  std::set<std::string_view> seen(std::begin(unbroken), std::end(unbroken));
  for (const Breaks& row : breakers) EXPECT_TRUE(seen.insert(row.id).second) << row.id;
  for (const Spoils& row : spoils) EXPECT_TRUE(seen.insert(row.id).second) << row.id;
  for (const HardCase& each : hard_cases()) {
    // What carries a load is seen red without each of its effects: load_cases_test.cpp.
    if (!each.effects.empty()) continue;
    EXPECT_EQ(seen.count(each.id), 1U) << each.id << ": break it once in a test";
  }
}

/// A file a bone, with no more points than one looks through, the worst first; what holds leaves none.
TEST(BrokenBackends, PointsThatAreAnsweredWronglyAreWrittenForTheirMakers) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "wrong_points";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::vector<HardCase> cases = hard_cases();
  const auto soundness = std::ranges::find(cases, std::string_view("soundness"), &HardCase::id);
  const auto written_by = [&](const BackendEntry& backend) {
    const HardRequest request{.backend = backend, .wrong_prefix = (folder / backend.name).string()};
    (void)soundness->run(request);
    std::vector<QuerySet> sets;
    for (int number = 1;; ++number) {
      const std::filesystem::path file = folder / fmt::format("{}-{}.queries", backend.name, number);
      if (!std::filesystem::exists(file)) return sets;
      sets.push_back(read_checked_query_set(file));
    }
  };
  EXPECT_TRUE(written_by(find_backend("bvh")).empty());
  const std::vector<QuerySet> sets = written_by(leaks(find_backend("bvh")));
  ASSERT_EQ(sets.size(), 4U);  // the shapes of the case
  for (const QuerySet& set : sets) {
    ASSERT_FALSE(set.distances_m.empty());
    EXPECT_LE(set.distances_m.size(), 20U);
    EXPECT_TRUE(std::ranges::is_sorted(set.distances_m));  // the deepest that was missed comes first
    for (const double distance_m : set.distances_m) {
      EXPECT_LT(distance_m, 0);
      EXPECT_GT(distance_m, -1e-3);
    }
    for (const QuerySetCheck& check : check_query_set(set)) EXPECT_TRUE(check.held()) << check.by;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace musclebench

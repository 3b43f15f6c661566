#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/measure/contact_sites.hpp"
#include "core/recording/frame_source.hpp"
#include "core/scene/scene.hpp"
#include "datasets/queries/query_set.hpp"

namespace musclebench {

/// Which queries of a recording a query set gets.
struct QueryChoice {
  int moments = 8;            ///< evenly over the motion
  int steps = 3;              ///< successive ones at each moment, no more than a frame has
  double band_m = 0.01;       ///< queries no farther than this from the surface
  int around = 2000;          ///< hard points about each bone beside those of the motion, see points_about
  std::size_t most = 50'000;  ///< of more, every so many-th node is kept, so that each node's queries stay together
};

/// `QuerySet::difficulty` of a point that no node was at; else a ContactDifficulty.
constexpr std::int32_t around_the_bone = static_cast<std::int32_t>(contact_difficulties.size());

/// The name of a difficulty in a query set.
std::string_view difficulty_name(std::int32_t difficulty);

/// The queries with the Referee's answers. `report` gets the number of moments done. Throws InputError where the motion
/// brings no node that near to a bone.
QuerySet queries_of(const Scene& scene, FrameSource& recording, const QueryChoice& choice,
                    const std::function<void(int)>& report);

/// The Referee's answers about points (rest frame, m) and one bone.
QuerySet queries_about(const Bone& bone, std::span<const Vec3> points);

/// As datasets/queries/README.md describes it, as a whole or not at all. Returns the hash that it ends in.
std::string write_query_set(const std::filesystem::path& path, const QuerySet& set);

/// Throws InputError where the file is none, is cut off or was changed, or where an index in it is out of range.
QuerySet read_checked_query_set(const std::filesystem::path& path);

/// Signed distances to the queries' bones: little-endian doubles without a head, in the order of the set, NaN where
/// there is no answer. Throws InputError where the file has another number of them.
std::vector<double> read_answers(const std::filesystem::path& path, const QuerySet& set);

/// How answers depart from the truth.
struct QueryErrors {
  std::size_t queries = 0;
  std::size_t unanswered = 0;
  std::size_t wrong_sides = 0;  ///< farther from the surface than touching distance and rounding
  double p99_m = 0;             ///< of the differences of signed distances
  double largest_m = 0;
};

/// Of the queries for which `counts` holds.
QueryErrors compare_answers(const QuerySet& set, const std::vector<double>& answers,
                            const std::function<bool(std::size_t)>& counts);

/// What an independent look at the set found.
struct QuerySetCheck {
  std::string by;  ///< name of an exact backend
  QueryErrors errors;
  double agreed_m = 0;  ///< largest difference that rounding explains
  [[nodiscard]] bool held() const {
    return errors.unanswered == 0 && errors.wrong_sides == 0 && errors.largest_m <= agreed_m;
  }
};

/// Asks every exact backend of this build about the set: the first about all queries, the slower ones about some 2,000.
std::vector<QuerySetCheck> check_query_set(const QuerySet& set);

/// How far the stored closest points are from where they say, at most: |point - closest| less |distance|, in metres.
double largest_gap_m(const QuerySet& set);

}  // namespace musclebench

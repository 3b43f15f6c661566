#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "datasets/queries/query_set.hpp"

namespace musclebench {

/// How answers depart from the truth.
struct QueryErrors {
  std::size_t queries = 0;
  std::size_t unanswered = 0;
  std::size_t wrong_sides = 0;  ///< farther from the surface than touching distance and rounding
  double p99_m = 0;             ///< of the differences of signed distances
  double largest_m = 0;
};

/// Of the queries for which `counts` holds. `answers`: signed distances, m, one a query.
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

/// Asks every exact backend of this build about the set, and where all bones are clean those that are exact there. The
/// first is asked about all queries, the others about some 2,000.
std::vector<QuerySetCheck> check_query_set(const QuerySet& set);

/// How far the stored closest points are from where they say, at most: |point - closest| less |distance|, in metres.
double largest_gap_m(const QuerySet& set);

}  // namespace musclebench

#include "core/scene/check/coarse_cells.hpp"

#include <algorithm>

namespace musclebench {

std::vector<CoarseCells> coarse_cells(CheckContext& context) {
  constexpr double least_share = 0.01;  // of the free nodes; below it what they do moves no figure of a run
  std::vector<CoarseCells> coarse;
  for (std::size_t bone = 0; bone < context.options.cells.size(); ++bone) {
    const double error_m = context.options.cells[bone].error_m;
    if (!(error_m > 0)) continue;
    const BoneNearness& nearness = context.nearness()[bone];
    const auto inside_error = std::ranges::count_if(
        nearness.rest_distances_m, [&](double distance_m) { return distance_m > 0 && distance_m < error_m; });
    const double share = static_cast<double>(inside_error) / static_cast<double>(context.free_node_count());
    if (share > least_share) coarse.push_back({bone, share, nearness.rest_gap_m});
  }
  return coarse;
}

}  // namespace musclebench

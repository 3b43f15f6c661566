#pragma once

#include <span>

namespace musclebench {

/// A median with its 95 % interval.
struct MedianEstimate {
  double median = 0;
  double low = 0;
  double high = 0;
};

/// Fewer frames do not tell how well they determine their median: their interval is NaN.
constexpr int fewest_bootstrap_frames = 6;

/// The median of `values`, one a frame and at least one, with an interval by circular block bootstrap (Politis and
/// Romano 1992): drawn are blocks of ten neighbouring frames, which are alike, so that single frames drawn at random
/// would give too narrow an interval. `frames` ascend; where they are some of the motion's only, a block is as many of
/// them as fit into ten frames, and at most a third.
///
/// The values seed the draws, so that the same values always give the same interval: to the last bit that of
/// tools/musclebench/results/statistics.py.
MedianEstimate block_bootstrap_median(std::span<const int> frames, std::span<const double> values);

}  // namespace musclebench

#pragma once

#include <limits>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// How far the edges of a deformed muscle are stretched: length over length at rest, 1 where nothing has changed.
struct EdgeStretch {
  double max = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not measured
  double p99 = std::numeric_limits<double>::quiet_NaN();  ///< over the edges, see percentile_index
};

/// Edges that have no length at rest are left out.
class EdgeStretchMeter {
 public:
  explicit EdgeStretchMeter(const TriangleMesh& rest);

  [[nodiscard]] EdgeStretch measure(std::span<const Vec3> positions);

  /// Of the edges at rest; 0 without any.
  [[nodiscard]] double mean_length_m() const { return m_mean_length_m; }

 private:
  struct Edge {
    int from, to;
    double rest_length_m;
  };
  std::vector<Edge> m_edges;
  std::vector<double> m_stretches;  // scratch memory
  double m_mean_length_m = 0;
};

}  // namespace musclebench

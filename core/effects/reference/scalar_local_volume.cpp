#include "core/effects/reference/scalar_local_volume.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/effects/local_volume/local_volume.hpp"
#include "core/mesh/mesh_edges.hpp"
#include "core/mesh/surface_volume.hpp"

namespace musclebench {

namespace {

/// Of one body without boundary, whose edges have two triangles each.
class ScalarLocalVolume final : public ScalarEffect {
 public:
  ScalarLocalVolume(const EffectInput& input, const Parameters& parameters)
      : m_nodes(input.mesh.vertices.size()), m_projection_scale(parameters.number("projection_scale")) {
    const auto count = static_cast<int>(parameters.integer("regions"));
    const std::vector<int> bands = bands_along_bodies(input.mesh, input.bodies, count);
    m_regions.resize(static_cast<std::size_t>(*std::ranges::max_element(bands)) + 1);
    m_rims.resize(m_regions.size() - 1);
    std::map<std::pair<int, int>, int> band_of_side;
    for (std::size_t t = 0; t < bands.size(); ++t) {
      const Triangle& triangle = input.mesh.triangles[t];
      m_regions[static_cast<std::size_t>(bands[t])].push_back(triangle);
      for (std::size_t k = 0; k < 3; ++k) band_of_side[{triangle[k], triangle[(k + 1) % 3]}] = bands[t];
    }
    for (const auto& [side, band] : band_of_side) {
      const auto& [from, to] = side;
      for (int cut = band; cut < band_of_side.at({to, from}); ++cut) {
        const auto below = static_cast<std::size_t>(cut);
        const int mean = static_cast<int>(m_nodes + below);
        m_rims[below].insert({from, to});
        m_regions[below].push_back({to, from, mean});
        m_regions[below + 1].push_back({from, to, mean});
      }
    }
    m_share.resize(m_nodes, 0);
    for (const auto& region : m_regions) {
      std::set<int> members;
      for (const Triangle& triangle : region) members.insert(triangle.begin(), triangle.end());
      members.erase(members.lower_bound(static_cast<int>(m_nodes)), members.end());
      for (const int node : members) m_share[static_cast<std::size_t>(node)] += 1;
    }
    const std::vector<Vec3> rest = with_means(input.mesh.vertices);
    for (const auto& region : m_regions) {
      m_targets_m3.push_back(parameters.number("pressure") * surface_volume_m3(rest, region));
    }
  }

  void project(std::vector<Vec3>& predicted, const std::vector<double>& inverse_masses,
               const SubstepInput& /*input*/) override {
    const std::vector<Vec3> positions = with_means(predicted);
    for (std::size_t r = 0; r < m_regions.size(); ++r) {
      const std::vector<Vec3> gradients = gradients_of(m_regions[r], positions);
      double weighted = 0;
      for (std::size_t i = 0; i < m_nodes; ++i) {
        weighted += m_share[i] * inverse_masses[i] * gradients[i].squaredNorm();
      }
      if (!(weighted > 0)) continue;
      const double error_m3 = surface_volume_m3(positions, m_regions[r]) - m_targets_m3[r];
      for (std::size_t i = 0; i < m_nodes; ++i) {
        predicted[i] -= (m_projection_scale * error_m3 / weighted * inverse_masses[i]) * gradients[i];
      }
    }
  }

 private:
  [[nodiscard]] std::vector<Vec3> with_means(std::vector<Vec3> positions) const {
    for (const std::set<int>& rim : m_rims) {
      Vec3 sum = Vec3::Zero();
      for (const int node : rim) sum += positions[static_cast<std::size_t>(node)];
      positions.emplace_back(sum / static_cast<double>(rim.size()));
    }
    return positions;
  }

  [[nodiscard]] std::vector<Vec3> gradients_of(const std::vector<Triangle>& region,
                                               const std::vector<Vec3>& positions) const {
    std::vector<Vec3> gradients(positions.size(), Vec3::Zero());
    const Vec3& origin = positions.front();
    for (const Triangle& triangle : region) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 next = positions[static_cast<std::size_t>(triangle[(k + 1) % 3])] - origin;
        const Vec3 last = positions[static_cast<std::size_t>(triangle[(k + 2) % 3])] - origin;
        gradients[static_cast<std::size_t>(triangle[k])] += next.cross(last) / 6;
      }
    }
    for (std::size_t cut = 0; cut < m_rims.size(); ++cut) {
      for (const int node : m_rims[cut]) {
        gradients[static_cast<std::size_t>(node)] += gradients[m_nodes + cut] / static_cast<double>(m_rims[cut].size());
      }
    }
    return gradients;
  }

  std::size_t m_nodes;
  std::vector<std::vector<Triangle>> m_regions;  ///< nodes, then the means of the cuts
  std::vector<std::set<int>> m_rims;             ///< nodes of each cut
  std::vector<double> m_share;                   ///< by node: of how many regions it is
  std::vector<double> m_targets_m3;
  double m_projection_scale;
};

}  // namespace

std::unique_ptr<ScalarEffect> make_scalar_local_volume(const EffectInput& input, const Parameters& parameters) {
  const MeshEdges edges(input.mesh);
  for (int edge = 0; edge < edges.count(); ++edge) {
    if (edges.uses(edge).size() != 2) return make_scalar_effect("volume", input, parameters);
  }
  return std::make_unique<ScalarLocalVolume>(input, parameters);
}

}  // namespace musclebench

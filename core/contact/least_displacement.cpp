#include "core/contact/least_displacement.hpp"

#include <algorithm>
#include <tuple>

#include <Eigen/Cholesky>

namespace musclebench {

namespace {

constexpr double softness = 1e-9;

using Lengths = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, HalfSpaces::most, 1>;
using Gram = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, HalfSpaces::most, HalfSpaces::most>;

/// The lengths along the normals of a set of half spaces that all hold with equality.
class ActiveSet {
 public:
  explicit ActiveSet(const HalfSpaces& half_spaces) : m_half_spaces(half_spaces) {
    m_length.setZero(static_cast<Eigen::Index>(half_spaces.size()));
  }

  /// What is left of the depth of half space `i`.
  [[nodiscard]] double remaining_m(std::size_t i) const {
    return m_half_spaces[i].depth_m - m_half_spaces[i].normal.dot(displacement()) - softness * m_length[index(i)];
  }

  [[nodiscard]] Vec3 displacement() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < m_half_spaces.size(); ++i) sum += m_length[index(i)] * m_half_spaces[i].normal;
    return sum;
  }

  [[nodiscard]] bool has(std::size_t i) const { return m_active[i]; }

  /// Adds half space `i`, and drops those that it makes needless.
  void add(std::size_t i) {
    m_active[i] = true;
    while (true) {
      const Lengths wanted = solved();
      double step = 1;
      for (std::size_t k = 0; k < m_half_spaces.size(); ++k) {
        if (m_active[k] && wanted[index(k)] <= 0) {
          step = std::min(step, m_length[index(k)] / (m_length[index(k)] - wanted[index(k)]));
        }
      }
      m_length += step * (wanted - m_length);
      if (step >= 1) return;
      for (std::size_t k = 0; k < m_half_spaces.size(); ++k) {
        if (m_active[k] && (wanted[index(k)] <= 0) && m_length[index(k)] <= 1e-15 * m_half_spaces[0].depth_m) {
          m_active[k] = false;
          m_length[index(k)] = 0;
        }
      }
    }
  }

 private:
  static Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

  /// Of all half spaces; 0 for those that are not active.
  [[nodiscard]] Lengths solved() const {
    const auto count = index(m_half_spaces.size());
    Gram gram = Gram::Identity(count, count);
    Lengths depths = Lengths::Zero(count);
    for (std::size_t i = 0; i < m_half_spaces.size(); ++i) {
      if (!m_active[i]) continue;
      depths[index(i)] = m_half_spaces[i].depth_m;
      for (std::size_t k = 0; k < m_half_spaces.size(); ++k) {
        if (m_active[k]) gram(index(i), index(k)) = m_half_spaces[i].normal.dot(m_half_spaces[k].normal);
      }
      gram(index(i), index(i)) += softness;
    }
    return gram.ldlt().solve(depths);
  }

  const HalfSpaces& m_half_spaces;
  std::array<bool, HalfSpaces::most> m_active{};
  Lengths m_length;
};

}  // namespace

void HalfSpaces::add(const HalfSpace& half_space) {
  if (m_count < most) {
    m_half_spaces[m_count++] = half_space;
    return;
  }
  HalfSpace& shallowest = *std::ranges::min_element(m_half_spaces, {}, &HalfSpace::depth_m);
  if (shallowest.depth_m < half_space.depth_m) shallowest = half_space;
}

Vec3 least_displacement(HalfSpaces half_spaces) {
  std::ranges::sort(half_spaces, [](const HalfSpace& a, const HalfSpace& b) {
    const auto key = [](const HalfSpace& h) {
      return std::tuple(-h.depth_m, h.normal.x(), h.normal.y(), h.normal.z());
    };
    return key(a) < key(b);
  });
  if (half_spaces.size() == 0 || !(half_spaces[0].depth_m > 0)) {
    return Vec3::Zero();
  }
  const double negligible_m = 1e-14 * half_spaces[0].depth_m;
  ActiveSet active(half_spaces);
  constexpr int most_changes = 64;  // far more than subsets are met; rounding could go round in a circle
  for (int change = 0; change < most_changes; ++change) {
    std::size_t worst = HalfSpaces::most;
    double worst_m = negligible_m;
    for (std::size_t i = 0; i < half_spaces.size(); ++i) {
      if (!active.has(i) && active.remaining_m(i) > worst_m) {
        worst = i;
        worst_m = active.remaining_m(i);
      }
    }
    if (worst == HalfSpaces::most) break;
    active.add(worst);
  }
  return active.displacement();
}

}  // namespace musclebench

#include "core/measure/surface_offset.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/percentile.hpp"
#include "core/contact/collision_backend.hpp"

namespace musclebench {

namespace {

/// Of the bone's diagonal: above the distance at which a point counts as on the surface.
constexpr double smallest_step = 1e-9;
constexpr int steps_to_bound = 64;
constexpr double relative_width = 0.01;

/// A step has to change the distance from the surface by so much of its length, or the medial axis is in its way.
constexpr double straight_growth = 0.5;
/// The same along the medial axis: a wedge of some 11 degrees grows by a tenth, a plate not at all.
constexpr double least_growth = 0.1;
constexpr std::size_t most_faces = 4;
constexpr int most_steps = 1000;

/// A point of a search, with the truth about it.
struct Place {
  Vec3 point_m = Vec3::Zero();
  double away_m = 0;            ///< from the surface, in the direction of the search
  Vec3 farther = Vec3::Zero();  ///< unit: where that grows
};

/// One site's search: between `near`, where the answer is as at the surface, and `far`.
struct Search {
  double direction = 0;  ///< 1 outwards, -1 inwards; 0: ended
  Place near;
  Place far;                  ///< what is asked about next
  Vec3 ahead = Vec3::Zero();  ///< unit
  bool is_turned = false;     ///< along the medial axis
  int steps = 0;
  bool is_bracketed = false;  ///< the answer changes between `near` and `bracket_end`
  Place bracket_end;
};

/// Where the smallest of several distances grows most, and by how much: the shortest vector in the convex hull of their
/// gradients, to about 1 %, by Gilbert's algorithm.
Vec3 steepest_ascent(std::span<const Vec3> gradients) {
  constexpr int rounds = 100;
  Vec3 shortest = gradients.front();
  for (int round = 0; round < rounds; ++round) {
    const Vec3& least = *std::ranges::min_element(gradients, {}, [&](const Vec3& g) { return g.dot(shortest); });
    const Vec3 along = least - shortest;
    const double length2 = along.squaredNorm();
    if (!(length2 > 0)) break;
    shortest += std::clamp(-shortest.dot(along) / length2, 0.0, 1.0) * along;
  }
  return shortest;
}

class OffsetSearch {
 public:
  OffsetSearch(const AskInside& ask, const Referee& referee, std::span<const double> bone_diagonals_m,
               std::span<const ContactSite> sites, double bound_m)
      : m_ask(ask),
        m_referee(referee),
        m_diagonals_m(bone_diagonals_m),
        m_sites(sites),
        m_bound_m(bound_m),
        m_searches(sites.size()),
        m_points(sites.size()),
        m_inside(sites.size()),
        m_offsets(sites.size()) {
    for (std::size_t i = 0; i < sites.size(); ++i) m_points[i] = sites[i].surface_point_m;
  }

  std::vector<SiteOffset> run() {
    start();
    for (;;) {
      for (const int i : m_active) propose(static_cast<std::size_t>(i));
      std::erase_if(m_active, [&](int i) { return search(i).direction == 0; });
      if (m_active.empty()) return std::move(m_offsets);
      m_ask(m_points, m_active, m_inside);
      for (const int i : m_active) take_answer(static_cast<std::size_t>(i));
      std::erase_if(m_active, [&](int i) { return search(i).direction == 0; });
    }
  }

 private:
  [[nodiscard]] Search& search(int i) { return m_searches[static_cast<std::size_t>(i)]; }

  [[nodiscard]] double first_step_m(std::size_t i) const {
    return smallest_step * m_diagonals_m[static_cast<std::size_t>(m_sites[i].bone)];
  }

  [[nodiscard]] Place place(std::size_t i, const Vec3& point_m) const {
    const SurfaceDistance truth = m_referee.closest(m_sites[i].bone, point_m);
    const double direction = m_searches[i].direction;
    return {point_m, direction * truth.signed_distance_m, direction * truth.normal};
  }

  /// Just outside a point should be free, just inside it should not.
  void start() {
    std::vector<int> asked(m_sites.size());
    for (std::size_t i = 0; i < asked.size(); ++i) asked[i] = static_cast<int>(i);
    for (const double direction : {1.0, -1.0}) {
      for (const int i : asked) {
        const auto at = static_cast<std::size_t>(i);
        Search& begun = m_searches[at];
        begun.direction = direction;
        begun.ahead = direction * m_sites[at].outward;
        m_points[at] = m_sites[at].surface_point_m + first_step_m(at) * begun.ahead;
        begun.near = {m_points[at], first_step_m(at), begun.ahead};
      }
      m_ask(m_points, asked, m_inside);
      std::vector<int> right;
      for (const int i : asked) {
        const bool is_wrong = (m_inside[static_cast<std::size_t>(i)] != 0) == (direction > 0);
        (is_wrong ? m_active : right).push_back(i);
      }
      asked = std::move(right);
    }
    std::ranges::sort(m_active);
  }

  void propose(std::size_t i) {
    Search& at = m_searches[i];
    if (at.is_bracketed) {
      at.far = place(i, 0.5 * (at.near.point_m + at.bracket_end.point_m));
    } else if (++at.steps > most_steps || at.near.away_m >= m_bound_m || !step_ahead(i)) {
      m_offsets[i] = {at.direction > 0 ? at.near.away_m : -m_bound_m, true};
      at.direction = 0;
    }
    m_points[i] = at.far.point_m;
  }

  /// Puts `far` ahead of `near`, around the medial axis where that is in the way; false where the distance from the
  /// surface does not grow any more.
  [[nodiscard]] bool step_ahead(std::size_t i) {
    Search& at = m_searches[i];
    const double step_m = std::min(at.near.away_m, m_bound_m / steps_to_bound);
    const auto grows = [&](double least) {
      at.far = place(i, at.near.point_m + step_m * at.ahead);
      return at.far.away_m >= at.near.away_m + least * step_m;
    };
    if (grows(at.is_turned ? least_growth : straight_growth)) return true;
    at.ahead = at.near.farther;
    at.is_turned = false;
    if (grows(straight_growth)) return true;
    at.is_turned = true;
    std::array<Vec3, most_faces> faces{at.near.farther};
    for (std::size_t count = 2; count <= most_faces; ++count) {
      faces[count - 1] = at.far.farther;
      const Vec3 ascent = steepest_ascent(std::span(faces).first(count));
      const double length = ascent.norm();
      if (!(length > least_growth)) return false;
      at.ahead = ascent / length;
      if (grows(least_growth)) return true;
    }
    return false;
  }

  void take_answer(std::size_t i) {
    Search& at = m_searches[i];
    const bool has_changed = (m_inside[i] != 0) == (at.direction < 0);
    if (has_changed) {
      at.bracket_end = at.far;
      at.is_bracketed = true;
    } else {
      at.near = at.far;
    }
    if (!at.is_bracketed) return;
    const double width_m = (at.bracket_end.point_m - at.near.point_m).norm();
    if (width_m > relative_width * std::max(at.near.away_m, at.bracket_end.away_m)) return;
    m_offsets[i] = {at.direction * 0.5 * (at.near.away_m + at.bracket_end.away_m), false};
    at.direction = 0;
  }

  const AskInside& m_ask;
  const Referee& m_referee;
  std::span<const double> m_diagonals_m;
  std::span<const ContactSite> m_sites;
  double m_bound_m;
  std::vector<Search> m_searches;
  std::vector<Vec3> m_points;
  std::vector<char> m_inside;
  std::vector<SiteOffset> m_offsets;
  std::vector<int> m_active;
};

/// A length >= 0 and the number of contacts that have it.
struct WeightedLength {
  double length_m;
  long contacts;
};

/// By nearest rank, as `percentile`.
double weighted_p99(std::vector<WeightedLength> values) {
  std::ranges::sort(values, {}, &WeightedLength::length_m);
  long total = 0;
  for (const WeightedLength& value : values) total += value.contacts;
  auto below = static_cast<long>(percentile_index(static_cast<std::size_t>(total), 0.99));
  for (const WeightedLength& value : values) {
    below -= value.contacts;
    if (below < 0) return value.length_m;
  }
  return values.back().length_m;
}

/// Over the sites that `is_counted` picks.
template <typename IsCounted>
std::optional<OffsetStatistics> statistics_of(std::span<const ContactSite> sites, std::span<const SiteOffset> offsets,
                                              const IsCounted& is_counted) {
  OffsetStatistics result;
  std::vector<WeightedLength> lengths;
  std::vector<WeightedLength> inward;
  std::vector<WeightedLength> outward;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    if (!is_counted(sites[i])) continue;
    ++result.sites;
    result.open_sites += offsets[i].is_open ? 1 : 0;
    const double offset_m = offsets[i].offset_m;
    lengths.push_back({std::abs(offset_m), sites[i].contacts});
    inward.push_back({std::max(0.0, -offset_m), sites[i].contacts});
    outward.push_back({std::max(0.0, offset_m), sites[i].contacts});
    result.max_inward_m = std::max(result.max_inward_m, inward.back().length_m);
    result.max_outward_m = std::max(result.max_outward_m, outward.back().length_m);
  }
  if (result.sites == 0) return std::nullopt;
  result.max_offset_m = std::max(result.max_inward_m, result.max_outward_m);
  result.p99_offset_m = weighted_p99(std::move(lengths));
  result.p99_inward_m = weighted_p99(std::move(inward));
  result.p99_outward_m = weighted_p99(std::move(outward));
  return result;
}

}  // namespace

AskInside ask_backend(CollisionBackend& backend, std::size_t bones, double away_m, std::span<const ContactSite> sites) {
  return [&backend, bones, away_m, sites](std::span<const Vec3> points_m, std::span<const int> asked,
                                          std::vector<char>& inside) {
    for (const int i : asked) inside[static_cast<std::size_t>(i)] = 0;
    std::vector<Contact> found;
    for (std::size_t bone = 0; bone < bones; ++bone) {
      std::vector<int> of_bone;
      std::ranges::copy_if(asked, std::back_inserter(of_bone),
                           [&](int i) { return sites[static_cast<std::size_t>(i)].bone == static_cast<int>(bone); });
      if (of_bone.empty()) continue;
      std::vector<RigidMotion> poses(bones, {Mat3::Identity(), Vec3::Constant(away_m)});
      poses[bone] = {};
      backend.update(poses, points_m);
      backend.detect(points_m, of_bone, found);
      for (const Contact& contact : found) {
        if (contact.bone == static_cast<int>(bone)) inside[static_cast<std::size_t>(contact.node)] = 1;
      }
    }
  };
}

std::vector<SiteOffset> measure_offsets(const AskInside& ask, const Referee& referee,
                                        std::span<const double> bone_diagonals_m, std::span<const ContactSite> sites,
                                        double bound_m) {
  return OffsetSearch(ask, referee, bone_diagonals_m, sites, bound_m).run();
}

SurfaceOffsets offset_statistics(std::span<const ContactSite> sites, std::span<const SiteOffset> offsets,
                                 std::size_t bones, std::size_t muscles) {
  SurfaceOffsets result;
  result.all = statistics_of(sites, offsets, [](const ContactSite&) { return true; });
  for (std::size_t muscle = 0; muscle < muscles; ++muscle) {
    result.of_muscles.push_back(statistics_of(
        sites, offsets, [&](const ContactSite& site) { return site.muscle == static_cast<int>(muscle); }));
  }
  for (std::size_t pair = 0; pair < bones * muscles; ++pair) {
    result.of_pairs.push_back(statistics_of(sites, offsets, [&](const ContactSite& site) {
      return static_cast<std::size_t>(site.bone) * muscles + static_cast<std::size_t>(site.muscle) == pair;
    }));
  }
  for (std::size_t kind = 0; kind < contact_difficulties.size(); ++kind) {
    result.of_difficulties[kind] = statistics_of(
        sites, offsets, [&](const ContactSite& site) { return static_cast<std::size_t>(site.difficulty) == kind; });
  }
  return result;
}

}  // namespace musclebench

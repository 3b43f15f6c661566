#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/measure/contact_sites.hpp"

namespace musclebench {

class CollisionBackend;

/// Where a backend's surface is at one site, seen from the true one.
struct SiteOffset {
  /// True signed distance of the point near the site where the answer changes between contact and none: > 0 too far
  /// out, < 0 lets nodes in. To 1 %, and to 1e-9 of the bone's diagonal.
  double offset_m = 0;
  /// The answer did not change: nodes are let in without limit (offset_m is minus the bound), or are held off at least
  /// so far.
  bool is_open = false;
};

/// Figures over sites, each of which counts as often as it stands for contacts. Inward offsets are lengths >= 0, and so
/// are outward ones: 0 where the offset has the other sign.
struct OffsetStatistics {
  long sites = 0;
  long open_sites = 0;      ///< SiteOffset::is_open
  double p99_offset_m = 0;  ///< of the lengths of the offsets, in either direction
  double max_offset_m = 0;
  double p99_inward_m = 0;
  double max_inward_m = 0;
  double p99_outward_m = 0;
  double max_outward_m = 0;
};

/// Of all sites, of each pair of a bone and a muscle, and of each difficulty. Nothing where there is no site.
struct SurfaceOffsets {
  std::optional<OffsetStatistics> all;
  std::vector<std::optional<OffsetStatistics>> of_muscles;
  std::vector<std::optional<OffsetStatistics>> of_pairs;  ///< by bone, then muscle
  std::array<std::optional<OffsetStatistics>, contact_difficulties.size()> of_difficulties;
};

/// Whether points are inside, by a method under test: writes one answer a point. A point is in the rest frame of the
/// bone of its site; `asked` are the sites (indices, ascending) whose points count.
using AskInside =
    std::function<void(std::span<const Vec3> points_m, std::span<const int> asked, std::vector<char>& inside)>;

/// Asks a backend that has `point_queries`, and is built, about single nodes: as a black box, with the bone in rest
/// pose and the others `away_m` from there, so that nothing is asked about them. `sites` outlive the function.
AskInside ask_backend(CollisionBackend& backend, std::size_t bones, double away_m, std::span<const ContactSite> sites);

/// Searches from each site, outwards where the method takes a point just outside the surface for inside, else inwards,
/// until its answer changes: by steps that double up to 1/64 of `bound_m`, then by bisection. The path is the site's
/// normal; at the medial axis of the bone, as near its ridges, it turns to where the distance from the surface still
/// grows. It ends without a change at `bound_m` > 0 from the surface, and where the distance grows no more: in the
/// middle of a plate. `bone_diagonals_m` are those of the bones' bounding boxes.
std::vector<SiteOffset> measure_offsets(const AskInside& ask, const Referee& referee,
                                        std::span<const double> bone_diagonals_m, std::span<const ContactSite> sites,
                                        double bound_m);

SurfaceOffsets offset_statistics(std::span<const ContactSite> sites, std::span<const SiteOffset> offsets,
                                 std::size_t bones, std::size_t muscles);

}  // namespace musclebench

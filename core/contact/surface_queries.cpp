#include "core/contact/surface_queries.hpp"

#include <algorithm>
#include <utility>

namespace musclebench {

namespace {

class ExactQueries final : public SurfaceQueries {
 public:
  explicit ExactQueries(std::shared_ptr<const SignedSurface> surface) : m_surface(std::move(surface)) {}

  [[nodiscard]] SurfaceAnswer locate(const Vec3& point, int near) const override {
    const SignedPoint located = m_surface->locate_from(point, std::max(near, 0));
    return {located.signed_distance_m(), m_surface->outward(point, located), located.closest.point,
            located.closest.triangle};
  }

  [[nodiscard]] Clearance clearance(const Vec3& point, int near) const override {
    return m_surface->tree().clearance_from(point, std::max(near, 0));
  }

  [[nodiscard]] std::optional<double> way_out_m(const Vec3& from, const Vec3& direction, double length_m, int /*near*/,
                                                std::vector<PathCrossing>& scratch) const override {
    m_surface->tree().find_crossings(from, from + length_m * direction, scratch);
    if (scratch.empty() || scratch.front().entering) return std::nullopt;
    return scratch.front().share * length_m;
  }

  [[nodiscard]] std::size_t bytes() const override { return sizeof(*this); }

 private:
  std::shared_ptr<const SignedSurface> m_surface;
};

}  // namespace

std::optional<double> SurfaceQueries::way_out_m(const Vec3& from, const Vec3& direction, double length_m, int near,
                                                std::vector<PathCrossing>& /*scratch*/) const {
  constexpr int most_steps = 100;
  const double close_m = 1e-6 * length_m;
  double gone_m = 0;
  for (int step = 0; step < most_steps && gone_m <= length_m; ++step) {
    const SurfaceAnswer here = locate(from + gone_m * direction, near);
    if (here.signed_distance_m > -close_m) {
      // Under the surface of another part the distance is 0, too.
      const SurfaceAnswer behind = locate(from + (gone_m + 20 * close_m) * direction, here.near);
      return behind.signed_distance_m < 0 ? std::nullopt : std::optional(gone_m);
    }
    gone_m -= here.signed_distance_m;
    near = here.near;
  }
  return std::nullopt;
}

std::shared_ptr<const SurfaceQueries> exact_surface_queries(const Bone& bone) {
  return std::make_shared<const ExactQueries>(bone.kept_signed_distance());
}

}  // namespace musclebench

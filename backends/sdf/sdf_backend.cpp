#include "backends/sdf/sdf_backend.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "backends/sdf/cubic_field.hpp"
#include "backends/sdf/discregrid_file.hpp"
#include "backends/sdf/field_builder.hpp"
#include "backends/sdf/field_contact.hpp"
#include "backends/sdf/field_detection.hpp"
#include "backends/sdf/field_file.hpp"
#include "backends/sdf/field_memory.hpp"
#include "backends/sdf/foreign_field.hpp"
#include "backends/sdf/octree_backend.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/clearance/clearance_cache.hpp"

namespace musclebench {

namespace {

/// To estimate the error of a field that someone else has built.
constexpr int samples_of_foreign = 2000;

class SdfBackend final : public CollisionBackend {
 public:
  explicit SdfBackend(const Parameters& parameters)
      : m_grid(grid_settings(parameters)),
        m_settings(field_settings(parameters)),
        m_precision_name(parameters.word("precision")),
        m_folder(parameters.word("structures")),
        m_discregrid(parameters.word("discregrid")),
        m_wants_budgets(uses_clearance_cache(parameters)) {}

  [[nodiscard]] Capabilities capabilities() const override { return {.remembers = m_detection.has_budgets()}; }

  [[nodiscard]] bool built_from_file() const override {
    return m_loaded_fields > 0 && m_loaded_fields == m_fields.size();
  }

  [[nodiscard]] std::vector<StructureError> structure_errors() const override {
    std::vector<StructureError> errors;
    for (std::size_t b = 0; b < m_fields.size(); ++b) {
      const FieldError& error = m_fields[b].facts().error;
      errors.push_back({bones()[b].name, m_fields[b].bytes(), error.samples, error.largest_m, error.p99_m});
    }
    return errors;
  }

  /// Half a cell: what a cubic field errs by at kinks, where it is of first order. Sheets thinner than a cell lie
  /// outside it.
  [[nodiscard]] AnswerBound answer_bound(int bone) const override {
    const double half_cell_m = 0.5 * m_fields[static_cast<std::size_t>(bone)].shape().cell_size_m.norm();
    return {half_cell_m, half_cell_m};
  }

  [[nodiscard]] double step_m(int bone) const override {
    return m_fields[static_cast<std::size_t>(bone)].shape().cell_size_m.minCoeff();
  }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = m_detection.bytes();
    for (const CubicField& field : m_fields) {
      bytes += field.bytes();
    }
    return bytes;
  }

 private:
  void do_build() override {
    m_fields.clear();
    m_loaded_fields = 0;
    // What lies outside the band is known by the distance alone.
    m_detection.reset(bones(), muscle().vertices.size(),
                      m_wants_budgets && (!m_settings.band_m || are_closed(bones())));
    if (!m_discregrid.empty()) {
      read_fields();
      return;
    }
    std::vector<GridShape> shapes;
    for (const Bone& bone : bones()) {
      shapes.push_back(grid_over(bone.surface.mesh, m_grid, bone.name));
      if (m_settings.band_m) {
        require_sensible_band(*m_settings.band_m, shapes.back(), bone.surface.mesh, bone.name);
      }
    }
    require_room(bones(), shapes, m_grid, m_settings);
    for (std::size_t b = 0; b < bones().size(); ++b) {
      m_fields.push_back(load_or_build(bones()[b], shapes[b]));
    }
  }

  void read_fields() {
    for (const Bone& bone : bones()) {
      const std::filesystem::path path = m_discregrid / (bone_file_name(bone.name) + ".cdf");
      m_fields.push_back(read_discregrid(path, threads()));
      const SignedSurface& surface = bone.signed_distance();
      require_field_of(m_fields.back(), bone.surface.mesh, surface, bone.name, path);
      m_fields.back().facts().error = estimate_error(m_fields.back(), surface, samples_of_foreign);
      ++m_loaded_fields;
    }
  }

  [[nodiscard]] CubicField build_over(const Bone& bone, const GridShape& shape) const {
    const double before = static_cast<double>(m_fields.size());
    const auto report = [&](double share) { build_report()((before + share) / static_cast<double>(bones().size())); };
    return build_field(bone.signed_distance(), shape, m_settings, threads(),
                       build_report() ? std::function<void(double)>(report) : nullptr);
  }

  [[nodiscard]] CubicField load_or_build(const Bone& bone, const GridShape& shape) {
    if (m_folder.empty()) {
      return build_over(bone, shape);
    }
    const std::string digest = surface_digest(bone.surface);
    const std::filesystem::path path = m_folder / file_name(bone);
    if (std::optional<CubicField> loaded = load_field(path, digest, shape, m_settings)) {
      ++m_loaded_fields;
      return *std::move(loaded);
    }
    CubicField built = build_over(bone, shape);
    save_field(built, digest, path);
    return built;
  }

  [[nodiscard]] std::string file_name(const Bone& bone) const {
    const std::string grid =
        m_grid.cell_size_m > 0 ? fmt::format("{}m", m_grid.cell_size_m) : fmt::format("{}cells", m_grid.cells);
    const std::string band = m_settings.band_m ? fmt::format("-band{}m", *m_settings.band_m) : "";
    return fmt::format("{}-{}{}{}-{}.field", bone_file_name(bone.name), grid, band, margin_file_name(m_grid.margin),
                       m_precision_name);
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_detection.detect(
        poses(), positions, nodes, threads(),
        [&](const FieldDetection::Share& share, std::vector<Contact>& found) { detect_share(share, positions, found); },
        contacts);
  }

  void detect_share(const FieldDetection::Share& share, std::span<const Vec3> positions,
                    std::vector<Contact>& contacts) {
    if (m_detection.has_budgets()) {
      detect_spent(share.bone, positions, share.nodes, contacts);
    } else {
      detect_all(share.bone, positions, share.nodes, contacts);
    }
  }

  [[nodiscard]] const RigidMotion& pose(int bone) const { return poses()[static_cast<std::size_t>(bone)]; }
  [[nodiscard]] const CubicField& field(int bone) const { return m_fields[static_cast<std::size_t>(bone)]; }

  void detect_all(int bone, std::span<const Vec3> positions, std::span<const int> nodes,
                  std::vector<Contact>& contacts) const {
    const CellMap map(field(bone).shape(), pose(bone));
    FieldBlock block;
    for (std::size_t next = 0; next < nodes.size();) {
      block.count = 0;
      next = field(bone).sample(map, positions, nodes, next, CubicField::Wanted::may_be_inside, block);
      for (std::size_t n = 0; n < block.count; ++n) {
        if (block.value_m[n] < 0) {
          contacts.push_back(field_contact(field(bone).shape(), pose(bone), bone, nodes[block.asker[n]], block, n));
        }
      }
    }
  }

  /// The same contacts. All `nodes` are new ones or have used up what they may move, and are granted anew.
  void detect_spent(int bone, std::span<const Vec3> positions, std::span<const int> nodes,
                    std::vector<Contact>& contacts) {
    const CellMap map(field(bone).shape(), pose(bone));
    FieldBlock block;
    for (std::size_t next = 0; next < nodes.size();) {
      std::size_t unknown = next;
      block.count = 0;
      next = field(bone).sample(map, positions, nodes, next, CubicField::Wanted::known, block);
      for (std::size_t n = 0; n < block.count; ++n) {
        for (; unknown < block.asker[n]; ++unknown) {
          grant_far(bone, nodes[unknown], map, positions);
        }
        ++unknown;
        const int node = nodes[block.asker[n]];
        if (block.value_m[n] < 0 && may_be_inside(bone, block, n)) {
          contacts.push_back(field_contact(field(bone).shape(), pose(bone), bone, node, block, n));
        } else {
          m_detection.budgets().grant(bone, node, field(bone).shape().point(block.cells(n)),
                                      free_distance_m(field(bone), block.value_m[n]));
        }
      }
      for (; unknown < next; ++unknown) {
        grant_far(bone, nodes[unknown], map, positions);
      }
    }
  }

  /// A node outside the field, or in a cell that it does not know. At the border of a cell the place may be rounded
  /// into the next one, by less than a budget's own slack.
  void grant_far(int bone, int node, const CellMap& map, std::span<const Vec3> positions) {
    const CubicField& field = this->field(bone);
    const Vec3 cells = map.apply(positions[static_cast<std::size_t>(node)]);
    if (!field.band() || !field.shape().contains(cells)) {
      m_detection.budgets().grant(bone, node, field.shape().point(cells), field.shape().distance_m(cells));
      return;
    }
    const CellPlace place = field.shape().place(cells);
    const double far_m = static_cast<double>(field.band()->far_m(place.i, place.j, place.k));
    m_detection.budgets().grant(bone, node, field.shape().point(cells), far_m - field.facts().negative_reach_m);
  }

  [[nodiscard]] bool may_be_inside(int bone, const FieldBlock& block, std::size_t n) const {
    const GridShape& shape = field(bone).shape();
    const CellPlace place = shape.place(block.cells(n));
    return field(bone).may_be_negative(shape.cell(place.i, place.j, place.k));
  }

  /// How far a place of this value is at least from all places where the field is negative. A way that leaves the
  /// cells of a band comes back to them at a distance of the bone that is the band's width.
  [[nodiscard]] static double free_distance_m(const CubicField& field, double value_m) {
    const double by_slope_m = value_m / field.facts().steepest;
    return field.band() ? std::min(by_slope_m, field.band()->width_m() - field.facts().negative_reach_m) : by_slope_m;
  }

  GridSettings m_grid;
  FieldSettings m_settings;
  std::string m_precision_name;
  std::filesystem::path m_folder;
  std::filesystem::path m_discregrid;
  bool m_wants_budgets;
  std::size_t m_loaded_fields = 0;
  std::vector<CubicField> m_fields;
  FieldDetection m_detection;
};

}  // namespace

std::vector<ParameterSpec> sdf_parameters() {
  return {
      {"cells", std::int64_t{64}, "cells along each axis of the bone's box (unless cell_size_m is given)", 1, 4096, {}},
      {"cell_size_m", 0.0, "edge of cubic cells; 0: use `cells`", 0, 10, {}},
      {"precision",
       std::string("float"),
       "stored values; compact: corners in float, the others in 16 bits of a cell",
       -1e300,
       1e300,
       {"float", "double", "compact"}},
      {"band_m", 0.0, "narrow band: keep the cells in the bone and this far about it; not given: keep all", 0, 10, {}},
      {"max_error_mm",
       0.0,
       "adaptive cells: 99 of 100 depths up to 1/200 of the bone's diagonal are off by no more, deeper ones by a tenth "
       "of what lies beyond that; 0: cells of one size",
       0,
       1000,
       {}},
      {"margin", 1e-3, "how far the field reaches beyond the bone's box, as a share of its diagonal", 1e-6, 1, {}},
      {"structures",
       std::string(),
       "folder where built fields are kept and found again; empty: none",
       -1e300,
       1e300,
       {}},
      {"discregrid",
       std::string(),
       "folder with a field BONE.cdf (Discregrid's format) for each bone, used in place of building; empty: none",
       -1e300,
       1e300,
       {}},
      clearance_cache_parameter(true),
  };
}

std::unique_ptr<CollisionBackend> make_sdf_backend(const Parameters& parameters) {
  if (wants_octree(parameters)) {
    return make_octree_backend(parameters);
  }
  return std::make_unique<SdfBackend>(parameters);
}

}  // namespace musclebench

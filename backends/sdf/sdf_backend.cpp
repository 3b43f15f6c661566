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
#include "backends/sdf/field_file.hpp"
#include "backends/sdf/octree_backend.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/base/system_memory.hpp"
#include "core/contact/motion_budgets.hpp"

namespace musclebench {

namespace {

/// Where a field sits in the world: `to_cells * x + offset` counts its cells along its axes.
struct CellMap {
  Mat3 to_cells;
  Vec3 offset;
  Vec3 upper;  ///< number of cells

  CellMap(const GridShape& shape, const RigidMotion& pose)
      : to_cells(shape.cell_size_m.cwiseInverse().asDiagonal() * pose.rotation.transpose()),
        offset(-(to_cells * pose.translation_m) - shape.lower_m.cwiseQuotient(shape.cell_size_m)),
        upper(shape.cells[0], shape.cells[1], shape.cells[2]) {}

  /// How far a place is from the field's box.
  [[nodiscard]] double distance_m(const Vec3& cells, const GridShape& shape) const {
    return (-cells).cwiseMax(cells - upper).cwiseMax(0.0).cwiseProduct(shape.cell_size_m).norm();
  }

  /// False outside the field, and for a position that is not a number.
  [[nodiscard]] bool place(const Vec3& position, Vec3& cells) const {
    cells = to_cells * position + offset;
    return cells.x() >= 0 && cells.y() >= 0 && cells.z() >= 0 && cells.x() < upper.x() && cells.y() < upper.y() &&
           cells.z() < upper.z();
  }
};

/// Nodes whose cells are looked up before their values are computed.
constexpr std::size_t batch_size = 64;

/// To estimate the error of a field that someone else has built.
constexpr int samples_of_foreign = 2000;

/// Questions to one field that are answered together.
struct Batch {
  struct Asker {
    int node;
    bool may_be_inside;
    Vec3 cells;  ///< place in the field
  };
  std::size_t count = 0;
  std::array<CellQuery, batch_size> queries;
  std::array<CellAnswer, batch_size> answers;
  std::array<Asker, batch_size> askers;

  void ask(const CubicField& field, const CellPlace& place, const Asker& asker) {
    queries[count] = field.query(place);
    askers[count++] = asker;
  }
  [[nodiscard]] bool full() const { return count == batch_size; }
};

/// Out of the bone; away from the middle of the field where the field is flat, and along x in that very middle.
Vec3 outward(const Vec3& gradient, const Vec3& from_middle) {
  for (const Vec3& direction : {gradient, from_middle}) {
    const double length = direction.norm();
    if (length > 1e-9 && std::isfinite(length)) {
      return direction / length;
    }
  }
  return Vec3::UnitX();
}

class SdfBackend final : public CollisionBackend {
 public:
  explicit SdfBackend(const Parameters& parameters)
      : m_grid(grid_settings(parameters)),
        m_settings(field_settings(parameters)),
        m_precision_name(parameters.word("precision")),
        m_folder(parameters.word("structures")),
        m_discregrid(parameters.word("discregrid")),
        m_wants_budgets(has_motion_budgets(parameters)) {}

  [[nodiscard]] Capabilities capabilities() const override { return {.remembers = m_has_budgets}; }

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
    std::size_t bytes = m_has_budgets ? m_budgets.bytes() : 0;
    for (const CubicField& field : m_fields) {
      bytes += field.bytes();
    }
    return bytes;
  }

 private:
  void do_build() override {
    m_fields.clear();
    // What lies outside the band is known by the distance alone, and across a hole the side changes without a surface.
    m_has_budgets = m_wants_budgets && (!(m_settings.band_m > 0) ||
                                        std::all_of(bones().begin(), bones().end(),
                                                    [](const Bone& bone) { return is_closed(bone.surface.mesh); }));
    m_loaded_fields = 0;
    if (m_has_budgets) {
      m_budgets.reset(bones(), muscle().vertices.size());
    }
    if (!m_discregrid.empty()) {
      read_fields();
      return;
    }
    std::vector<GridShape> shapes;
    for (const Bone& bone : bones()) {
      shapes.push_back(grid_over(bone.surface.mesh, m_grid, bone.name));
      if (m_settings.band_m > 0) {
        require_sensible_band(m_settings.band_m, shapes.back(), bone.surface.mesh, bone.name);
      }
    }
    require_room(shapes);
    for (std::size_t b = 0; b < bones().size(); ++b) {
      m_fields.push_back(load_or_build(bones()[b], shapes[b]));
    }
  }

  void read_fields() {
    for (const Bone& bone : bones()) {
      const std::filesystem::path path = m_discregrid / (bone_file_name(bone.name) + ".cdf");
      m_fields.push_back(read_discregrid(path, threads()));
      require_field_of(m_fields.back(), bone.surface.mesh, bone.name, path);
      m_fields.back().facts().error = estimate_error(m_fields.back(), SignedSurface(bone.surface), samples_of_foreign);
      ++m_loaded_fields;
    }
  }

  /// A band takes less; how much, its surface tells.
  void require_room(const std::vector<GridShape>& shapes) const {
    double bytes = 0;
    for (const GridShape& shape : shapes) {
      bytes += CubicField::bytes_needed(shape, m_settings.precision);
    }
    // Bytes grow with the third power of the cells along an axis.
    const double share = std::cbrt(static_cast<double>(available_memory_bytes()) / bytes);
    if (m_grid.cell_size_m > 0) {
      require_memory(static_cast<std::size_t>(bytes), "sdf: cell_size_m",
                     fmt::format("cells of {:.2g} m fit", 1.05 * m_grid.cell_size_m / share));
    } else {
      require_memory(static_cast<std::size_t>(bytes), "sdf: cells",
                     fmt::format("{:.0f} cells fit", std::max(1.0, std::floor(0.95 * m_grid.cells * share))));
    }
  }

  [[nodiscard]] CubicField build_over(const Bone& bone, const GridShape& shape) const {
    const double before = static_cast<double>(m_fields.size());
    const auto report = [&](double share) { build_report()((before + share) / static_cast<double>(bones().size())); };
    return build_field(SignedSurface(bone.surface), shape, m_settings, threads(),
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
    const std::string band = m_settings.band_m > 0 ? fmt::format("-band{}m", m_settings.band_m) : "";
    return fmt::format("{}-{}{}-{}.field", bone_file_name(bone.name), grid, band, m_precision_name);
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    if (m_has_budgets && positions.size() != m_budgets.nodes()) {
      m_budgets.reset(bones(), positions.size());
    }
    for (std::size_t b = 0; b < m_fields.size(); ++b) {
      if (m_has_budgets) {
        detect_spent(static_cast<int>(b), positions, nodes, contacts);
      } else {
        detect_all(static_cast<int>(b), positions, nodes, contacts);
      }
    }
  }

  void detect_all(int bone, std::span<const Vec3> positions, std::span<const int> nodes,
                  std::vector<Contact>& contacts) {
    const CubicField& field = m_fields[static_cast<std::size_t>(bone)];
    const CellMap map(field.shape(), poses()[static_cast<std::size_t>(bone)]);
    Batch batch;
    for (const int node : nodes) {
      Vec3 cells;
      if (!map.place(positions[static_cast<std::size_t>(node)], cells)) {
        continue;
      }
      const CellPlace place = place_in(cells);
      if (!field.may_be_negative(field.shape().cell(place.i, place.j, place.k))) {
        continue;
      }
      batch.ask(field, place, {node, true, cells});
      if (batch.full()) {
        answer(bone, map, batch, contacts);
      }
    }
    answer(bone, map, batch, contacts);
  }

  /// The same contacts: only nodes that have used up what they may move are asked about.
  void detect_spent(int bone, std::span<const Vec3> positions, std::span<const int> nodes,
                    std::vector<Contact>& contacts) {
    const CubicField& field = m_fields[static_cast<std::size_t>(bone)];
    const GridShape& shape = field.shape();
    const RigidMotion& pose = poses()[static_cast<std::size_t>(bone)];
    const CellMap map(shape, pose);
    m_budgets.collect_spent(bone, pose, positions, nodes, m_spent);
    Batch batch;
    for (const int spent : m_spent) {
      const int node = nodes[static_cast<std::size_t>(spent)];
      const Vec3& position = positions[static_cast<std::size_t>(node)];
      Vec3 cells;
      if (!map.place(position, cells)) {
        m_budgets.grant(bone, node, pose.apply_inverse(position), map.distance_m(cells, shape));
        continue;
      }
      const CellPlace place = place_in(cells);
      const std::size_t cell = shape.cell(place.i, place.j, place.k);
      if (!field.knows(cell)) {
        const double far_m = static_cast<double>(field.band()->far_m(place.i, place.j, place.k));
        m_budgets.grant(bone, node, pose.apply_inverse(position), far_m - field.facts().negative_reach_m);
        continue;
      }
      batch.ask(field, place, {node, field.may_be_negative(cell), cells});
      if (batch.full()) {
        answer(bone, map, batch, contacts);
      }
    }
    answer(bone, map, batch, contacts);
  }

  [[nodiscard]] static CellPlace place_in(const Vec3& cells) {
    const auto i = static_cast<std::size_t>(cells.x());
    const auto j = static_cast<std::size_t>(cells.y());
    const auto k = static_cast<std::size_t>(cells.z());
    return {i, j, k, cells - Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k))};
  }

  void answer(int bone, const CellMap& map, Batch& batch, std::vector<Contact>& contacts) {
    const CubicField& field = m_fields[static_cast<std::size_t>(bone)];
    const GridShape& shape = field.shape();
    field.evaluate({batch.queries.data(), batch.count}, batch.answers);
    for (std::size_t n = 0; n < batch.count; ++n) {
      const auto& [value_m, slope] = batch.answers[n];
      const auto& [node, may_be_inside, cells] = batch.askers[n];
      if (may_be_inside && value_m < 0) {
        const Vec3 gradient(slope[0], slope[1], slope[2]);
        const Vec3 from_middle = (cells - 0.5 * map.upper).cwiseProduct(shape.cell_size_m);
        const Vec3 normal = outward(gradient.cwiseQuotient(shape.cell_size_m), from_middle);
        contacts.push_back({node, bone, -value_m, poses()[static_cast<std::size_t>(bone)].apply_to_direction(normal)});
      } else if (m_has_budgets) {
        m_budgets.grant(bone, node, shape.lower_m + cells.cwiseProduct(shape.cell_size_m),
                        free_distance_m(field, value_m));
      }
    }
    batch.count = 0;
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
  bool m_has_budgets = false;
  std::size_t m_loaded_fields = 0;
  std::vector<CubicField> m_fields;
  MotionBudgets m_budgets;
  std::vector<int> m_spent;
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
      {"band_m", 0.0, "narrow band: keep the cells in the bone and this far about it; 0: keep all", 0, 10, {}},
      {"max_error_mm",
       0.0,
       "adaptive cells: 99 of 100 depths near the surface are off by no more; 0: cells of one size",
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
      motion_budgets_parameter(true),
  };
}

std::unique_ptr<CollisionBackend> make_sdf_backend(const Parameters& parameters) {
  if (wants_octree(parameters)) {
    return make_octree_backend(parameters);
  }
  return std::make_unique<SdfBackend>(parameters);
}

}  // namespace musclebench

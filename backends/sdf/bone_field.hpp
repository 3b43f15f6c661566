#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "backends/sdf/files/field_file.hpp"
#include "backends/sdf/grid/cell_map.hpp"
#include "backends/sdf/grid/field_block.hpp"
#include "backends/sdf/octree/octree_kernel.hpp"
#include "core/clearance/bone_structure.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// Points of one bone's field that are evaluated together; with their leaves for an octree.
struct FieldAnswers {
  FieldBlock block;
  LeafBlock leaves;
};

/// The distance field of one bone as the `sdf` backend queries it, in batches. Queries are const and safe from several
/// threads.
class BoneField : public BoneStructure {
 public:
  /// Which points are evaluated: those that may be inside the bone, or all that the grid answers.
  enum class Wanted : std::uint8_t { contacts, clearances };

  explicit BoneField(const StructureOrigin& origin) : m_origin(origin) {}

  [[nodiscard]] StructureOrigin origin() const final { return m_origin; }
  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) final;
  [[nodiscard]] double kept_share() const final {
    return static_cast<double>(grid().cell_count()) / static_cast<double>(grid().whole().cell_count());
  }
  [[nodiscard]] bool found_left_out() const final { return m_found_left_out; }

  /// The frame that a CellMap of this field maps into.
  [[nodiscard]] virtual const GridShape& grid() const = 0;

  /// Appends the wanted ones of `nodes` (ascending indices into `positions`) from `first` on to an empty block and
  /// evaluates them; negative values are contacts. Returns the index in `nodes` to go on at; `query` is the index in
  /// `nodes`.
  virtual std::size_t sample(const CellMap& map, std::span<const Vec3> positions, std::span<const int> nodes,
                             std::size_t first, Wanted wanted, FieldAnswers& answers) const = 0;
  /// Radii of spheres around the points of such a block (`Wanted::clearances`) in which the field is nowhere negative;
  /// undefined for contacts.
  virtual void find_clearances(const FieldAnswers& answers, FieldBlock::Lanes<double>& clearance_m) const = 0;

 private:
  void store_sampled(const NodeBatch& batch, const FieldAnswers& answers) const;
  void store_left_out(const NodeBatch& batch, std::size_t first, std::size_t end, const CellMap& map,
                      const FieldBlock& block) const;

  StructureOrigin m_origin;
  std::atomic<bool> m_found_left_out = false;
};

/// Builds or loads the fields of a configured `sdf` backend.
class FieldSource {
 public:
  FieldSource() = default;
  FieldSource(const FieldSource&) = delete;
  FieldSource& operator=(const FieldSource&) = delete;
  virtual ~FieldSource() = default;

  /// Whether clearances hold for closed surfaces only, because in parts of space only the unsigned distance is stored.
  [[nodiscard]] virtual bool needs_closed_surfaces() const = 0;
  /// Throws InputError where the parameters do not fit the bones, before anything is built.
  virtual void require_fit(std::span<const Bone> /*bones*/) const {}
  /// How far from the box of the bone's vertices the domain of its field reaches; infinite where only the file tells.
  [[nodiscard]] virtual double contact_reach_m(const Bone& /*bone*/) const {
    return std::numeric_limits<double>::infinity();
  }
  /// `progress`, where not empty, is called with the share that is done. What is outside of `expected` may be left out
  /// (PointMethod::build_part).
  [[nodiscard]] virtual std::unique_ptr<BoneField> make(const Bone& bone, int threads, const ShareReport& progress,
                                                        const Eigen::AlignedBox3d& expected) const = 0;
};

}  // namespace musclebench

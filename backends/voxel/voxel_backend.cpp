#include "backends/voxel/voxel_backend.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "backends/voxel/voxel_grid.hpp"
#include "backends/voxel/voxel_kernel.hpp"
#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

class VoxelStructure final : public BoneStructure {
 public:
  explicit VoxelStructure(VoxelGrid grid) : m_grid(std::move(grid)) {}

  [[nodiscard]] AnswerBound answer_bound() const override { return {0, m_grid.cell_size_m().norm()}; }
  [[nodiscard]] std::size_t bytes() const override { return m_grid.bytes(); }
  [[nodiscard]] double step_m() const override { return m_grid.cell_size_m().minCoeff(); }

  void detect(const NodeBatch& batch, std::vector<Contact>& contacts) override {
    const VoxelMap map(m_grid, batch.pose);
    VoxelBlock block;
    std::uint64_t left_out = 0;
    for (std::size_t first = 0; first < batch.nodes.size(); first += VoxelBlock::capacity) {
      const std::span<const int> rest = batch.nodes.subspan(first);
      const std::span<const int> nodes = rest.first(std::min(rest.size(), VoxelBlock::capacity));
      look_up(m_grid, map, batch.positions, nodes, block);
      for (std::uint64_t in_set = block.in_set; in_set != 0; in_set &= in_set - 1) {
        contacts.push_back({nodes[static_cast<std::size_t>(std::countr_zero(in_set))], batch.bone, 0, Vec3::Zero()});
      }
      left_out |= block.left_out;
      if (batch.clearances != nullptr) {
        find_clearances(m_grid, nodes.size(), block);
        store_clearances(batch, nodes, block);
      }
    }
    if (left_out != 0) m_found_left_out.store(true, std::memory_order_relaxed);
  }

  [[nodiscard]] double kept_share() const override { return m_grid.kept_share(); }
  [[nodiscard]] bool found_left_out() const override { return m_found_left_out; }

 private:
  void store_clearances(const NodeBatch& batch, std::span<const int> nodes, const VoxelBlock& block) const {
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if ((((block.in_set | block.left_out) >> n) & 1U) != 0) continue;
      batch.clearances->store(batch.bone, nodes[n], m_grid.point(block.cells(n)), block.clearance_m[n]);
    }
  }

  VoxelGrid m_grid;
  std::atomic<bool> m_found_left_out = false;
};

std::vector<ParameterSpec> voxel_parameters() {
  return {parameter::integer({.name = "cells",
                              .default_value = 64,
                              .minimum = 1,
                              .maximum = 100'000,
                              .role = ParameterRole::resolution,
                              .help = "voxels along each axis of each bone's bounding box"}),
          parameter::number({.name = "voxel_size_m",
                             .unit = "m",
                             .default_value = 0,
                             .minimum = 0,
                             .maximum = 10,
                             .role = ParameterRole::resolution,
                             .help = "edge length of cubic voxels; 0: use `cells`"}),
          clearance_cache_parameter()};
}

}  // namespace

std::unique_ptr<CollisionBackend> make_voxel_backend(const Parameters& parameters) {
  return make_point_backend(
      {.capabilities =
           {.depth = false, .has_cache = uses_clearance_cache(parameters), .has_step = true, .steady_memory = true},
       .asks_few_without_cache = true,
       // Within the box's padding, or the cell that is more than fits.
       .contact_reach_m =
           [size_m = parameters.number("voxel_size_m")](const Bone& bone) {
             return touching_distance_m(bone.surface.mesh) + std::numbers::sqrt3 * size_m;
           },
       .build_part =
           [cells = static_cast<int>(parameters.integer("cells")), size_m = parameters.number("voxel_size_m"),
            has_cache = uses_clearance_cache(parameters)](
               const Bone& bone, int /*threads*/, const ShareReport& /*report*/, const Eigen::AlignedBox3d& expected) {
             const std::string name =
                 fmt::format("voxel: {} (bone '{}')", size_m > 0 ? "voxel_size_m" : "cells", bone.name);
             const bool closed = bone.surface.known_closed || is_closed(bone.surface.mesh);
             VoxelGrid grid(bone.surface.mesh, bone.tree(), closed, cells, size_m, name, expected);
             if (has_cache) grid.find_clearances();
             return std::make_unique<VoxelStructure>(std::move(grid));
           }});
}

BackendEntry voxel_entry() {
  return {.name = "voxel",
          .help = "uniform bit grid over each bone (the paper's voxelisation)",
          .implementation = "this project, after the paper's method",
          .default_response = ResponseKind::backtrack,
          .parameters = voxel_parameters(),
          .make = make_voxel_backend};
}

}  // namespace musclebench

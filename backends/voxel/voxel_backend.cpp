#include "backends/voxel/voxel_backend.hpp"

#include <atomic>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "backends/voxel/voxel_grid.hpp"
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
    // World to cells in one affine map: a node then costs one matrix product and one bit.
    const Vec3 per_cell = m_grid.cell_size_m().cwiseInverse();
    const Mat3 linear = per_cell.asDiagonal() * batch.pose.rotation.transpose();
    const Vec3 offset = -(linear * batch.pose.translation_m) - per_cell.cwiseProduct(m_grid.lower());
    const bool is_part = m_grid.kept_share() < 1;
    for (const int node : batch.nodes) {
      const Vec3 scaled = linear * batch.positions[static_cast<std::size_t>(node)] + offset;
      if (m_grid.contains_scaled(scaled)) {
        contacts.push_back({node, batch.bone, 0, Vec3::Zero()});
      } else if (is_part && m_grid.leaves_out_scaled(scaled)) {
        m_found_left_out.store(true, std::memory_order_relaxed);
      }
    }
  }

  [[nodiscard]] double kept_share() const override { return m_grid.kept_share(); }
  [[nodiscard]] bool found_left_out() const override { return m_found_left_out; }

 private:
  VoxelGrid m_grid;
  std::atomic<bool> m_found_left_out = false;
};

std::vector<ParameterSpec> voxel_parameters() {
  return {parameter::integer({.name = "cells",
                              .default_value = 64,
                              .minimum = 1,
                              .maximum = 100'000,
                              .role = ParameterRole::resolution,
                              .help = "voxels along each axis of a bone's own bounding box"}),
          parameter::number({.name = "voxel_size_m",
                             .unit = "m",
                             .default_value = 0,
                             .minimum = 0,
                             .maximum = 10,
                             .role = ParameterRole::resolution,
                             .help = "edge of cubic voxels; 0: use cells"})};
}

}  // namespace

std::unique_ptr<CollisionBackend> make_voxel_backend(const Parameters& parameters) {
  return make_point_backend(
      {.capabilities = {.depth = false, .has_step = true, .steady_memory = true},
       // Within the box's padding, or the cell that is more than fits.
       .contact_reach_m =
           [size_m = parameters.number("voxel_size_m")](const Bone& bone) {
             return touching_distance_m(bone.surface.mesh) + std::numbers::sqrt3 * size_m;
           },
       .build_part =
           [cells = static_cast<int>(parameters.integer("cells")), size_m = parameters.number("voxel_size_m")](
               const Bone& bone, int /*threads*/, const ShareReport& /*report*/, const Eigen::AlignedBox3d& expected) {
             const std::string name =
                 fmt::format("voxel: {} (bone '{}')", size_m > 0 ? "voxel_size_m" : "cells", bone.name);
             const bool closed = bone.surface.known_closed || is_closed(bone.surface.mesh);
             return std::make_unique<VoxelStructure>(
                 VoxelGrid(bone.surface.mesh, bone.tree(), closed, cells, size_m, name, expected));
           }});
}

BackendEntry voxel_entry() {
  return {.name = "voxel",
          .help = "uniform bit grid over each bone (the paper's voxelisation)",
          .default_response = ResponseKind::backtrack,
          .parameters = voxel_parameters(),
          .make = make_voxel_backend};
}

}  // namespace musclebench

#include "backends/voxel/voxel_backend.hpp"

#include <fmt/format.h>

#include "backends/voxel/voxel_grid.hpp"

namespace musclebench {

namespace {

class VoxelBackend final : public CollisionBackend {
 public:
  explicit VoxelBackend(const Parameters& parameters)
      : m_cells(static_cast<int>(parameters.integer("cells"))), m_voxel_size_m(parameters.number("voxel_size_m")) {}

  [[nodiscard]] Capabilities capabilities() const override {
    return {.depth = false, .has_step = true, .steady_memory = true};
  }

  [[nodiscard]] AnswerBound answer_bound(int bone) const override { return {0, m_grids[bone].cell_size_m().norm()}; }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = 0;
    for (const VoxelGrid& grid : m_grids) {
      bytes += grid.bytes();
    }
    return bytes;
  }

  [[nodiscard]] double step_m(int bone) const override { return m_grids[bone].cell_size_m().minCoeff(); }

 private:
  void do_build() override {
    m_grids.clear();
    for (const Bone& bone : bones()) {
      m_grids.emplace_back(
          bone.surface.mesh, bone.tree(), m_cells, m_voxel_size_m,
          fmt::format("voxel: {} (bone '{}')", m_voxel_size_m > 0 ? "voxel_size_m" : "cells", bone.name));
    }
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    for (std::size_t bone = 0; bone < m_grids.size(); ++bone) {
      const VoxelGrid& grid = m_grids[bone];
      const RigidMotion& pose = poses()[bone];
      // World to cells in one affine map: a node then costs one matrix product and one bit.
      const Vec3 per_cell = grid.cell_size_m().cwiseInverse();
      const Mat3 linear = per_cell.asDiagonal() * pose.rotation.transpose();
      const Vec3 offset = -(linear * pose.translation_m) - per_cell.cwiseProduct(grid.lower());
      for (const int node : nodes) {
        if (grid.contains_scaled(linear * positions[node] + offset)) {
          contacts.push_back({node, static_cast<int>(bone), 0, Vec3::Zero()});
        }
      }
    }
  }

  int m_cells;
  double m_voxel_size_m;
  std::vector<VoxelGrid> m_grids;
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
  return std::make_unique<VoxelBackend>(parameters);
}

BackendEntry voxel_entry() {
  return {.name = "voxel",
          .help = "uniform bit grid over each bone (the paper's voxelisation)",
          .default_response = ResponseKind::backtrack,
          .parameters = voxel_parameters(),
          .make = make_voxel_backend};
}

}  // namespace musclebench

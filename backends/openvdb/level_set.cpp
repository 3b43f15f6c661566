// The module: all that includes OpenVDB.
#include "backends/openvdb/level_set.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/global_control.h>

namespace musclebench {

namespace {

/// A surface as OpenVDB's builder reads it, in units of voxels about a middle.
class MeshInVoxels {
 public:
  explicit MeshInVoxels(const LevelSetRequest& request) : m_request(request), m_per_m(1 / request.voxel_size_m) {}

  [[nodiscard]] std::size_t polygonCount() const { return m_request.mesh.triangles.size(); }
  [[nodiscard]] std::size_t pointCount() const { return m_request.mesh.vertices.size(); }
  [[nodiscard]] static std::size_t vertexCount(std::size_t /*triangle*/) { return 3; }
  void getIndexSpacePoint(std::size_t triangle, std::size_t corner, openvdb::Vec3d& position) const {
    const int vertex = m_request.mesh.triangles[triangle][corner];
    const Vec3 at = m_per_m * (m_request.mesh.vertices[static_cast<std::size_t>(vertex)] - m_request.middle);
    position = {at.x(), at.y(), at.z()};
  }

 private:
  const LevelSetRequest& m_request;
  double m_per_m;
};

/// An accessor remembers the nodes of the tree that were read last: one a thread.
class GridReader final : public LevelSetReader {
 public:
  explicit GridReader(const openvdb::FloatGrid& grid) : m_accessor(grid.getConstUnsafeAccessor()) {}

  [[nodiscard]] double value_m(const Vec3& at) const override {
    return openvdb::tools::BoxSampler::sample(m_accessor, openvdb::Vec3R(at.x(), at.y(), at.z()));
  }

 private:
  openvdb::FloatGrid::ConstUnsafeAccessor m_accessor;
};

class GridLevelSet final : public LevelSet {
 public:
  explicit GridLevelSet(const LevelSetRequest& request) {
    openvdb::initialize();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(request.threads));
    m_grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        MeshInVoxels(request), *openvdb::math::Transform::createLinearTransform(request.voxel_size_m),
        static_cast<float>(request.outside_voxels), static_cast<float>(request.inside_voxels));
  }

  [[nodiscard]] std::unique_ptr<LevelSetReader> reader() const override {
    return std::make_unique<GridReader>(*m_grid);
  }
  [[nodiscard]] std::size_t bytes() const override { return m_grid->memUsage(); }

 private:
  openvdb::FloatGrid::Ptr m_grid;
};

}  // namespace

extern "C" LevelSet* musclebench_make_level_set(const LevelSetRequest& request);
extern "C" LevelSet* musclebench_make_level_set(const LevelSetRequest& request) { return new GridLevelSet(request); }

}  // namespace musclebench

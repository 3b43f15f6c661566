#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkImplicitPolyDataDistance.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkVersionMacros.h>

#include "core/clearance/located_nodes.hpp"
#include "core/clearance/point_backend.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

namespace {

vtkSmartPointer<vtkPolyData> to_vtk(const TriangleMesh& mesh, const Vec3& origin) {
  const vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& vertex : mesh.vertices) points->InsertNextPoint(Vec3(vertex - origin).data());
  const vtkNew<vtkCellArray> cells;
  for (const Triangle& triangle : mesh.triangles) {
    const std::array<vtkIdType, 3> corners = {triangle[0], triangle[1], triangle[2]};
    cells->InsertNextCell(3, corners.data());
  }
  auto made = vtkSmartPointer<vtkPolyData>::New();
  made->SetPoints(points);
  made->SetPolys(cells);
  made->BuildCells();
  return made;
}

/// The objects that threads query through: VTK's answers from one thread at a time. Each has a surface of its own, as
/// those that share one read corners of cells through the same scratch memory, and then err now and then.
class VtkBone {
 public:
  VtkBone(const Bone& bone, int threads)
      : m_origin(bounding_box(bone.surface.mesh.vertices).center()),
        m_surface(to_vtk(bone.surface.mesh, m_origin)),
        m_touching_m(touching_distance_m(bone.surface.mesh)),
        m_is_closed(is_closed(bone.surface.mesh)),
        m_is_clean(bone.surface.clean) {
    for (int thread = 0; thread < threads; ++thread) m_free.push_back(make_distance());
  }

  /// One that is not in use, until it goes.
  class Session {
   public:
    explicit Session(const VtkBone& bone) : m_bone(bone), m_distance(bone.take()) {}
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    ~Session() { m_bone.give_back(std::move(m_distance)); }

    [[nodiscard]] LocatedPoint locate(const Vec3& point, int& /*near*/) {
      Vec3 local = point - m_bone.m_origin;
      Vec3 closest;
      const double signed_m = m_distance->EvaluateFunctionAndGetClosestPoint(local.data(), closest.data());
      const double distance_m = (closest - local).norm();
      if (signed_m < 0 && distance_m > m_bone.m_touching_m) {
        return {.inside = true, .depth_m = distance_m, .outward = (closest - local) / distance_m};
      }
      // No surface is nearer, so all points of the sphere are on one side, also where VTK may err about which.
      return {.clearance_m = m_bone.m_is_closed ? distance_m : 0};
    }

   private:
    const VtkBone& m_bone;
    vtkSmartPointer<vtkImplicitPolyDataDistance> m_distance;
  };

  [[nodiscard]] Session session() const { return Session(*this); }

  /// Of surfaces whose normals tell the side; elsewhere VTK may err by any depth.
  [[nodiscard]] AnswerBound answer_bound() const {
    const double side_m = m_is_clean ? m_touching_m : std::numeric_limits<double>::infinity();
    return {side_m, side_m};
  }
  /// With one thread: what VTK says of the surface that objects are made from and of an object's own, and its tree: an
  /// index a triangle, and as many in the buckets that it crosses (two and a half on average). VTK does not tell the
  /// size of that. Each further thread takes an object more.
  [[nodiscard]] std::size_t bytes() const {
    constexpr std::size_t kibibyte = 1024;
    constexpr double copies = 2.5;
    const auto indices = static_cast<std::size_t>(copies * static_cast<double>(m_surface->GetNumberOfPolys()));
    return sizeof(*this) + 2 * m_surface->GetActualMemorySize() * kibibyte + indices * sizeof(vtkIdType);
  }
  [[nodiscard]] static std::optional<StructureError> error() { return std::nullopt; }

 private:
  [[nodiscard]] vtkSmartPointer<vtkImplicitPolyDataDistance> make_distance() const {
    const vtkNew<vtkPolyData> own;
    own->DeepCopy(m_surface);
    auto made = vtkSmartPointer<vtkImplicitPolyDataDistance>::New();
    made->SetInput(own);
    return made;
  }
  [[nodiscard]] vtkSmartPointer<vtkImplicitPolyDataDistance> take() const {
    const std::scoped_lock lock(m_mutex);
    if (m_free.empty()) return make_distance();
    auto taken = std::move(m_free.back());
    m_free.pop_back();
    return taken;
  }
  void give_back(vtkSmartPointer<vtkImplicitPolyDataDistance> taken) const {
    const std::scoped_lock lock(m_mutex);
    m_free.push_back(std::move(taken));
  }

  Vec3 m_origin;
  vtkSmartPointer<vtkPolyData> m_surface;
  double m_touching_m;
  bool m_is_closed;
  bool m_is_clean;
  mutable std::mutex m_mutex;
  mutable std::vector<vtkSmartPointer<vtkImplicitPolyDataDistance>> m_free;
};

std::unique_ptr<CollisionBackend> make_vtk_backend(const Parameters& parameters) {
  return make_point_backend(
      {.capabilities = {.has_cache = uses_clearance_cache(parameters)},
       .nodes_a_batch = 64,
       .contact_reach_m = [](const Bone& bone) { return touching_distance_m(bone.surface.mesh); },
       .build = build_located(parameters, [](const Bone& bone, int threads, const ShareReport& /*report*/) {
         return std::make_unique<const VtkBone>(bone, threads);
       })});
}

}  // namespace

// How it is driven follows the class reference of vtkImplicitPolyDataDistance (VTK 9.1).
BackendEntry vtk_entry() {
  return {.name = "vtk",
          .help = "signed distance by VTK's vtkImplicitPolyDataDistance, as 3D Slicer calls it",
          .implementation = "VTK " VTK_VERSION ", BSD-3-Clause",
          .default_response = ResponseKind::project,
          .parameters = {cull_parameter(), clearance_cache_parameter()},
          .make = make_vtk_backend};
}

}  // namespace musclebench

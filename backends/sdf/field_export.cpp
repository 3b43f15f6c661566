#include "backends/sdf/field_export.hpp"

#include <memory>
#include <string>

#include <fmt/format.h>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/build/field_memory.hpp"
#include "backends/sdf/build/octree_builder.hpp"
#include "backends/sdf/files/discregrid_file.hpp"
#include "backends/sdf/files/field_file.hpp"
#include "backends/sdf/files/octree_file.hpp"
#include "backends/sdf/sdf_settings.hpp"
#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

namespace fs = std::filesystem;

/// The extension of the path chooses the format.
void require_fit(const Parameters& parameters, const fs::path& out) {
  const bool octree = wants_octree(parameters);
  if (!parameters.word("discregrid").empty()) {
    throw InputError("--param discregrid", "is for fields that are there already; leave it out to build one");
  }
  const std::string ending = out.extension().string();
  if (octree ? ending != ".octree" : (ending != ".cdf" && ending != ".field")) {
    throw InputError("--out " + out.string(),
                     fmt::format("has to end in {} for this field", octree ? ".octree" : ".cdf or .field"));
  }
}

BuiltStructure build_octree_of(const Bone& bone, const Parameters& parameters, int threads, const ShareReport& report) {
  const OctreeSettings settings = octree_settings(parameters);
  const auto field = std::make_shared<const OctreeField>(
      build_octree(bone.signed_distance(), bone.surface.mesh, settings, bone.name, threads, report));
  const OctreeQuality& quality = field->quality();
  const std::string cells = fmt::format("{} of {:.3g} to {:.3g} mm", field->leaf_count(), quality.finest_edge_m * 1e3,
                                        field->shape().root_edge_m * 1e3);
  return {cells,
          field->bytes(),
          quality.p99_m,
          quality.largest_m,
          quality.samples,
          [field, settings, digest = surface_digest(bone.surface)](const fs::path& out) {
            save_octree(*field, digest, settings, out);
          }};
}

BuiltStructure build_grid_of(const Bone& bone, const Parameters& parameters, int threads, const ShareReport& report) {
  const GridSettings grid = grid_settings(parameters);
  const GridShape shape = grid_over(bone.surface.mesh, grid, bone.name);
  require_room({&shape, 1}, grid);
  const auto field = std::make_shared<const CubicField>(build_field(bone.signed_distance(), shape, threads, report));
  const FieldError& error = field->facts().error;
  const Vec3 size_mm = shape.cell_size_m * 1e3;
  const std::string cells = fmt::format("{} x {} x {} of {:.3g} x {:.3g} x {:.3g} mm", shape.cells[0], shape.cells[1],
                                        shape.cells[2], size_mm[0], size_mm[1], size_mm[2]);
  return {cells,
          field->bytes(),
          error.p99_m,
          error.largest_m,
          error.samples,
          [field, digest = surface_digest(bone.surface)](const fs::path& out) {
            if (out.extension() == ".cdf") {
              write_discregrid(*field, out);
            } else {
              save_field(*field, digest, out);
            }
          }};
}

}  // namespace

StructureExport field_export() {
  return {.formats = ".field, .cdf (Discregrid's format), or .octree for a field with max_error_mm",
          .require_fit = require_fit,
          .build = [](const Bone& bone, const Parameters& parameters, int threads, const ShareReport& report) {
            return wants_octree(parameters) ? build_octree_of(bone, parameters, threads, report)
                                            : build_grid_of(bone, parameters, threads, report);
          }};
}

}  // namespace musclebench

#include "bench/cases/bone_cells.hpp"

#include <algorithm>
#include <optional>

#include "bench/cases/build_backend.hpp"

namespace musclebench {

std::vector<BoneCells> bone_cells(const Case& resolved, const std::function<void(double share)>& report) {
  const BuiltBackend built = build_backend(resolved, report);
  const std::vector<StructureError> errors = built.backend->structure_errors();
  std::vector<BoneCells> cells;
  for (std::size_t bone = 0; bone < resolved.scene.bones.size(); ++bone) {
    // Several backends may be asked about a bone: cells and errors are the largest, the name is that of the first.
    const BackendChoice choice =
        backend_of_pair(resolved.scene.bone_pair(0, bone), resolved.backend, resolved.parameters, resolved.colliders);
    BoneCells& of_bone = cells.emplace_back();
    of_bone.backend = choice.entry->name;
    of_bone.cell_m = built.backend->step_m(static_cast<int>(bone));
    std::optional<double> measured_m;
    for (const StructureError& error : errors) {
      if (error.bone == resolved.scene.bones[bone].name) {
        measured_m = std::max(measured_m.value_or(0), error.p99_m);
      }
    }
    const bool finds_contacts = choice.make()->capabilities().finds_contacts;
    of_bone.error_m = measured_m.value_or(finds_contacts ? of_bone.cell_m : 0);
    // Exact backends miss what rounding can't tell; a cell is larger by far.
    of_bone.misses = built.backend->answer_bound(static_cast<int>(bone)).missed_depth_m > 1e-3 * of_bone.cell_m;
    const ParameterSpec* finer = find_parameter(choice.entry->parameters, ParameterRole::resolution);
    if (finer != nullptr) of_bone.parameter = finer->name;
  }
  return cells;
}

}  // namespace musclebench

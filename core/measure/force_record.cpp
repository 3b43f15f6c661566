#include "core/measure/force_record.hpp"

#include <array>

#include <fmt/format.h>

#include "core/measure/number_cell.hpp"
#include "core/mesh/rigid_motion.hpp"

namespace musclebench {

namespace {

constexpr std::array<Column<ForceRow>, 21> force_table{{
    {{"frame", "", "1 for the first"}, [](const ForceRow& r) { return fmt::format("{}", r.frame); }},
    {{"angle_deg", "deg", "of the bone that turns"},
     [](const ForceRow& r) { return number_cell(r.angle_rad * degrees_per_radian); }},
    {{"muscle", "", "on which the force acts; empty for a joint, whose force acts on its bone"},
     [](const ForceRow& r) { return r.muscle; }},
    {{"source", "",
      "bone, muscle or itself: contact; unknown: contact that does not tell with what; attachment; retinaculum; joint: "
      "all that "
      "muscles do to a bone"},
     [](const ForceRow& r) { return std::string(name_of(r.source)); }},
    {{"other", "", "the bone, muscle, attachment or retinaculum that exerts the force"},
     [](const ForceRow& r) { return r.other; }},
    {{"bone", "", "that touches or carries the muscle, or a joint's; empty elsewhere"},
     [](const ForceRow& r) { return r.bone; }},
    {{"force_x_n", "N", "mean over the frame, along x of the world"},
     [](const ForceRow& r) { return number_cell(r.force_n.x()); }},
    {{"force_y_n", "N", "along y"}, [](const ForceRow& r) { return number_cell(r.force_n.y()); }},
    {{"force_z_n", "N", "along z"}, [](const ForceRow& r) { return number_cell(r.force_n.z()); }},
    {{"force_n", "N", "its size"}, [](const ForceRow& r) { return number_cell(r.force_n.norm()); }},
    {{"at_x_m", "m", "where it acts: the mean of its nodes by the size of their forces; a joint's axis"},
     [](const ForceRow& r) { return number_cell(r.at_m.x()); }},
    {{"at_y_m", "m", "along y"}, [](const ForceRow& r) { return number_cell(r.at_m.y()); }},
    {{"at_z_m", "m", "along z"}, [](const ForceRow& r) { return number_cell(r.at_m.z()); }},
    {{"normal_n", "N", "of contact: sum of the sizes of all pushes along normals"},
     [](const ForceRow& r) { return number_cell(r.normal_n); }},
    {{"friction_n", "N", "of contact: size of the sum of all that does not push along normals"},
     [](const ForceRow& r) { return number_cell(r.friction_n); }},
    {{"area_m2", "m2", "of contact: that faces the pushes, of each pushed node a third of the triangles about it"},
     [](const ForceRow& r) { return number_cell(r.area_m2); }},
    {{"peak_pressure_pa", "Pa", "of contact: largest push of a node over its area"},
     [](const ForceRow& r) { return number_cell(r.peak_pressure_pa); }},
    {{"fibres_n", "N", "of an attachment: mean force along all fibres of its muscle (`fibre_force`)"},
     [](const ForceRow& r) { return number_cell(r.fibres_n); }},
    {{"active_n", "N", "of an attachment: size of what fibres pull there, active (`activation`) or by `fibre_force`"},
     [](const ForceRow& r) { return number_cell(r.active_n); }},
    {{"passive_n", "N",
      "of an attachment: the part of all other effects along the active part, < 0: against it; its size where nothing "
      "is active"},
     [](const ForceRow& r) { return number_cell(r.passive_n); }},
    {{"torque_n_m", "N m", "what the force does to the bone, about the axis of its rotation; empty: it stands still"},
     [](const ForceRow& r) { return number_cell(r.torque_n_m); }},
}};

constexpr std::array<Column<BoneVertexRow>, 6> bone_vertex_table{{
    {{"bone", "", "that is pressed"}, [](const BoneVertexRow& r) { return r.bone; }},
    {{"vertex", "", "of meshes/BONE.ply, from 0; vertices that nothing presses have no row"},
     [](const BoneVertexRow& r) { return fmt::format("{}", r.vertex); }},
    {{"pressure_pa", "Pa",
      "sum over muscles of the push over the area that faces it, a third of the triangles about it"},
     [](const BoneVertexRow& r) { return number_cell(r.pressure_pa); }},
    {{"force_x_n", "N", "mean push over the frame, on the bone, along x of the world; without friction"},
     [](const BoneVertexRow& r) { return number_cell(r.force_n.x()); }},
    {{"force_y_n", "N", "along y"}, [](const BoneVertexRow& r) { return number_cell(r.force_n.y()); }},
    {{"force_z_n", "N", "along z"}, [](const BoneVertexRow& r) { return number_cell(r.force_n.z()); }},
}};

}  // namespace

std::string_view name_of(ForceSource source) {
  constexpr std::array<std::string_view, 7> names{"bone",       "muscle",      "itself", "unknown",
                                                  "attachment", "retinaculum", "joint"};
  return names[static_cast<std::size_t>(source)];
}

std::span<const Column<ForceRow>> force_columns() { return force_table; }
std::span<const Column<BoneVertexRow>> bone_vertex_columns() { return bone_vertex_table; }

}  // namespace musclebench

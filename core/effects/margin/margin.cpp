#include <algorithm>
#include <tuple>

#include "core/clearance/clearance_cache.hpp"
#include "core/clearance/stage_surface.hpp"
#include "core/effects/effect_registry.hpp"

namespace musclebench {

namespace {

std::tuple<int, int> bone_and_node(const Contact& contact) { return {contact.bone, contact.node}; }

class Margin final : public ContactStage {
 public:
  Margin(const StageInput& input, double thickness_m) : m_thickness_m(thickness_m) {
    m_clearances.reset(input.bones, input.nodes);
    for (std::size_t bone = 0; bone < input.bones.size(); ++bone) {
      m_bones.push_back(
          {exact_stage_surface(input.bones[bone], input.is_untouched(bone)), std::vector<int>(input.nodes, 0)});
    }
    m_added.reserve(input.nodes * input.bones.size());
  }

  [[nodiscard]] std::string_view name() const override { return "margin"; }

  void add_contacts(const ContactStageInput& input, std::vector<Contact>& contacts) override {
    m_clearances.collect_expired(input.bone_poses, input.predicted, input.free_nodes);
    m_added.clear();
    for (std::size_t bone = 0; bone < m_bones.size(); ++bone) {
      for (const int node : m_clearances.expired(static_cast<int>(bone))) query_node(node, bone, input);
    }
    for (Contact& contact : contacts) contact.depth_m += m_thickness_m;
    // A node that the backend has found keeps the backend's answer.
    std::erase_if(m_added, [&](const Contact& added) {
      return std::ranges::binary_search(contacts, bone_and_node(added), {}, bone_and_node);
    });
    contacts.insert(contacts.end(), m_added.begin(), m_added.end());
    std::ranges::sort(contacts, {}, bone_and_node);
  }

  [[nodiscard]] int contact_count() const override { return static_cast<int>(m_added.size()); }

 private:
  struct BoneSurface {
    ExactStageSurface surface;
    std::vector<int> near_triangles;  ///< by node
  };

  void query_node(int node, std::size_t bone, const ContactStageInput& input) {
    auto& [surface, near_triangles] = m_bones[bone];
    int& near = near_triangles[static_cast<std::size_t>(node)];
    const RigidMotion& pose = input.bone_poses[bone];
    const Vec3 point = pose.apply_inverse(input.predicted[static_cast<std::size_t>(node)]);
    if (!point.allFinite()) {
      return;  // the run ends as diverged after this frame
    }
    if (const double by_box_m = surface.box_distance_m(point); by_box_m > m_thickness_m) {
      m_clearances.store(static_cast<int>(bone), node, point, by_box_m - m_thickness_m);
      return;
    }
    const Clearance clearance = surface.get().tree().clearance_from(point, near);
    if (clearance.distance_m > 0) near = clearance.triangle;
    if (clearance.distance_m > m_thickness_m) {  // or deeper inside, which is the backend's to find
      m_clearances.store(static_cast<int>(bone), node, point, clearance.distance_m - m_thickness_m);
      return;
    }
    const SignedPoint located = surface.get().locate_from(point, near);
    near = located.closest.triangle;
    const double depth_m = m_thickness_m - located.signed_distance_m();
    if (depth_m > 0) {
      m_added.push_back(
          {node, static_cast<int>(bone), depth_m, pose.apply_to_direction(surface.get().outward(point, located))});
    }
  }

  double m_thickness_m;
  ClearanceCache m_clearances;
  std::vector<BoneSurface> m_bones;
  std::vector<Contact> m_added;
};

std::unique_ptr<ContactStage> make_margin(const StageInput& input, const Parameters& parameters) {
  return std::make_unique<Margin>(input, parameters.number("thickness_m"));
}

void set_margin(ContactProperties& contacts, const Parameters& parameters) {
  contacts.margin_m = parameters.number("thickness_m");
}

std::vector<ParameterSpec> margin_parameters() {
  return {parameter::number({.name = "thickness_m",
                             .unit = "m",
                             .default_value = 5e-4,
                             .minimum = 0,
                             .maximum = 1,
                             .help = "thickness of the skin on the bones"})};
}

}  // namespace

/// A skin on the bones (paper, section IV-C): nodes that come closer than `thickness_m` are in contact, as deep as they
/// are in the skin, and the backend's own contacts are deeper by the skin. The distance is exact, whatever the backend:
/// only nodes near a bone are queried (ClearanceCache). Faces keep it with `surface_contact` (`set_margin`).
EffectEntry margin_entry() {
  return {.name = "margin",
          .help = "a skin on the bones; nodes stay out of it, and faces with `surface_contact`",
          .parameters = margin_parameters(),
          .make_stage = make_margin,
          .set_contacts = set_margin,
          .needs_normals = true,
          .needs_projection = true,
          .inert_at_zero = {"thickness_m"},
          .colour = "#F0E442"};
}

}  // namespace musclebench

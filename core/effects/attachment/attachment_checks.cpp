#include "core/scene/check/effect_checks.hpp"
#include "core/scene/check/rule_words.hpp"

namespace musclebench {

namespace {

void find_attachments(CheckContext& context, Findings& findings) {
  const Scene& scene = context.scene;
  const bool wants = scene.attach_at_first_contact || !scene.attachments.empty();
  const bool has = has_effect(scene, "attachment");
  if (has && !wants) {
    findings.push_back(cannot_act(key_of("attachment"), "has nothing to act on: the scene has no [[attachment]]"));
    findings.back().remove = {"[effects.attachment]"};
  }
  if (has || !wants) return;
  findings.push_back({.where = "attachment",
                      .what = "the scene has attachments, but no effect moves their nodes: the nodes stand still while "
                              "the bones move",
                      .add = {"[effects.attachment]"},
                      .effect = AdvisedEffect{"attachment"}});
}

}  // namespace

EffectChecks attachment_checks() { return {.rules = {{.id = "attachment", .look = find_attachments}}}; }

}  // namespace musclebench

#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "bench/hard/hard_case.hpp"
#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// What a broken backend does to the contacts that the sound one has found. It is made anew for each backend, and so
/// may have a state.
using SpoilContacts = std::function<void(std::vector<Contact>& contacts, int threads)>;

/// A backend with answers that are made wrong.
class BrokenBackend final : public CollisionBackend {
 public:
  BrokenBackend(std::unique_ptr<CollisionBackend> inner, SpoilContacts spoil)
      : m_inner(std::move(inner)), m_spoil(std::move(spoil)) {}
  [[nodiscard]] Capabilities capabilities() const override { return m_inner->capabilities(); }
  [[nodiscard]] AnswerBound answer_bound(int bone) const override { return m_inner->answer_bound(bone); }
  [[nodiscard]] std::size_t structure_bytes() const override { return m_inner->structure_bytes(); }
  [[nodiscard]] double step_m(int bone) const override { return m_inner->step_m(bone); }

 private:
  void do_build() override { m_inner->build(bones(), muscle(), threads()); }
  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_inner->update(poses(), positions);
    m_inner->detect(positions, nodes, contacts);
    m_spoil(contacts, threads());
  }

  std::unique_ptr<CollisionBackend> m_inner;
  SpoilContacts m_spoil;
};

/// `base` with answers that `make_spoil()` makes wrong.
inline BackendEntry broken(BackendEntry base, const std::string& name, std::function<SpoilContacts()> make_spoil) {
  base.name = name;
  base.make = [make = base.make, make_spoil = std::move(make_spoil)](const Parameters& parameters) {
    return std::make_unique<BrokenBackend>(make(parameters), make_spoil());
  };
  return base;
}

/// `base` that says it finds contacts, and never answers.
inline BackendEntry blind(BackendEntry base) {
  class Blind final : public CollisionBackend {
   public:
    explicit Blind(Capabilities capabilities) : m_capabilities(capabilities) {}
    [[nodiscard]] Capabilities capabilities() const override { return m_capabilities; }
    [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override { return {}; }
    [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

   private:
    void do_build() override {}
    void do_detect(std::span<const Vec3> /*positions*/, std::span<const int> /*nodes*/,
                   std::vector<Contact>& /*contacts*/) override {}
    Capabilities m_capabilities;
  };
  base.name = "blind";
  base.make = [make = base.make](const Parameters& parameters) {
    return std::make_unique<Blind>(make(parameters)->capabilities());
  };
  base.signed_distance = [](const Bone& /*bone*/, int /*threads*/) {
    return [](const Vec3& /*point*/) { return 1.0; };
  };
  return base;
}

/// A sanitized program, or a slow machine.
inline bool takes_too_long(const HardCell& cell) {
  return cell.verdict == Verdict::not_applicable && cell.detail.find("would take ") != std::string::npos;
}

/// A run of the scene either has the sane figures, or its case says why some are left out.
inline void expect_sane_figures(const HardCase& each, const HardCell& cell) {
  if (each.scene.empty() || !each.left_out_because.empty()) return;
  for (const char* figure : {"triangles through bones", "triangles through the muscle itself",
                             "nodes on the wrong side of a bone", "depth of the surface in bones", "volume error",
                             "longest edge over its length at rest", "runs that end with another status than ok"}) {
    EXPECT_TRUE(std::ranges::any_of(cell.figures, [&](const HardFigure& own) { return own.name.ends_with(figure); }))
        << each.id << " has no " << figure << " and does not say why";
  }
}

}  // namespace musclebench

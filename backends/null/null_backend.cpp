#include "backends/null/null_backend.hpp"

#include <limits>

namespace musclebench {

namespace {

class NullBackend final : public CollisionBackend {
 public:
  /// There is no contact that a response could miss something of, so it can be paired with any.
  [[nodiscard]] Capabilities capabilities() const override {
    return {.finds_contacts = false, .has_step = true, .steady_memory = true, .times_pairs = true};
  }
  [[nodiscard]] double step_m(int /*bone*/) const override { return 1; }
  [[nodiscard]] AnswerBound answer_bound(int /*bone*/) const override {
    return {std::numeric_limits<double>::infinity(), 0};
  }
  [[nodiscard]] std::size_t structure_bytes() const override { return 0; }

 private:
  void do_build() override {}
  void do_detect(std::span<const Vec3> /*positions*/, std::span<const int> /*nodes*/,
                 std::vector<Contact>& /*contacts*/) override {}
};

}  // namespace

BackendEntry null_entry() {
  return {.name = "null",
          .help = "no collision: the cost of the loop alone",
          .implementation = "this project",
          .default_response = ResponseKind::project,
          .make = [](const Parameters& /*parameters*/) { return std::make_unique<NullBackend>(); }};
}

}  // namespace musclebench

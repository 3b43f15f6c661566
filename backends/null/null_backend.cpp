#include "backends/null/null_backend.hpp"

#include <limits>

namespace musclebench {

namespace {

class NullBackend final : public CollisionBackend {
 public:
  [[nodiscard]] Capabilities capabilities() const override { return {.depth = false, .point_queries = true}; }
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

std::unique_ptr<CollisionBackend> make_null_backend(const Parameters& /*parameters*/) {
  return std::make_unique<NullBackend>();
}

std::vector<ParameterSpec> null_parameters() { return {}; }

}  // namespace musclebench

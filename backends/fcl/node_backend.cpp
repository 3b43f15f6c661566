#include "backends/fcl/node_backend.hpp"

#include <limits>

#include "backends/fcl/node_queries.hpp"

namespace musclebench {

namespace {

class NodeBackend final : public CollisionBackend {
 public:
  explicit NodeBackend(FclOptions options) : m_options(std::move(options)) {}

  [[nodiscard]] Capabilities capabilities() const override { return {}; }

  /// Exact by distance, on a surface whose pseudo-normals tell the side. A sphere misses what is deeper than it
  /// reaches, at any depth, and reports nothing that it does not reach.
  [[nodiscard]] AnswerBound answer_bound(int bone) const override {
    const double infinity = std::numeric_limits<double>::infinity();
    const double touching_m = m_queries->touching_m(bone);
    const bool clean = bones()[static_cast<std::size_t>(bone)].surface.clean;
    if (m_options.query == Query::node_collide) {
      return {infinity, clean ? touching_m : m_options.node_radius_m};
    }
    return clean ? AnswerBound{touching_m, touching_m} : AnswerBound{infinity, infinity};
  }

  [[nodiscard]] std::size_t structure_bytes() const override { return m_queries == nullptr ? 0 : m_queries->bytes(); }

 private:
  void do_build() override { m_queries = std::make_unique<NodeQueries>(m_options, bones(), threads()); }

  void do_update(std::span<const Vec3> /*positions*/) override { m_queries->move_bones(poses()); }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    m_queries->append(positions, nodes, contacts);
  }

  FclOptions m_options;
  std::unique_ptr<NodeQueries> m_queries;
};

}  // namespace

std::unique_ptr<CollisionBackend> make_node_backend(const FclOptions& options) {
  return std::make_unique<NodeBackend>(options);
}

}  // namespace musclebench

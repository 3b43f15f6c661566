#include "core/clearance/point_backend.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/mesh/mesh_size.hpp"
#include "core/signed_distance/signed_surface.hpp"

namespace musclebench {

namespace {

class PointBackend final : public CollisionBackend {
 public:
  explicit PointBackend(PointMethod method) : m_method(std::move(method)) {}

  [[nodiscard]] Capabilities capabilities() const override {
    Capabilities can = m_method.capabilities;
    can.times_pairs = true;
    return can;
  }
  [[nodiscard]] AnswerBound answer_bound(int bone) const override {
    const auto& built = m_structures[static_cast<std::size_t>(bone)];  // none over a bone that is out of reach
    return built ? built->answer_bound() : AnswerBound{};
  }
  [[nodiscard]] double step_m(int bone) const override { return structure(bone).step_m(); }
  [[nodiscard]] double contact_reach_m(const Bone& bone) const override {
    return m_method.contact_reach_m ? m_method.contact_reach_m(bone) : CollisionBackend::contact_reach_m(bone);
  }

  [[nodiscard]] std::size_t structure_bytes() const override {
    std::size_t bytes = m_keeps_clearances ? m_clearances.bytes() : 0;
    for (const auto& each : m_structures) {
      bytes += each ? each->bytes() : 0;
    }
    return bytes;
  }

  [[nodiscard]] StructureOrigin structure_origin() const override {
    std::optional<StructureOrigin> all;
    for (const auto& each : m_structures) {
      if (each != nullptr) all = all ? all->with(each->origin()) : each->origin();
    }
    return all.value_or(StructureOrigin{});
  }

  [[nodiscard]] std::vector<PrunedBone> pruned_bones() const override {
    std::vector<PrunedBone> all = CollisionBackend::pruned_bones();
    all.insert(all.end(), m_partial.begin(), m_partial.end());
    std::ranges::sort(all, {}, &PrunedBone::bone);
    return all;
  }

  [[nodiscard]] std::vector<StructureError> structure_errors() const override {
    std::vector<StructureError> errors;
    for (std::size_t bone = 0; bone < m_structures.size(); ++bone) {
      if (m_structures[bone] == nullptr) continue;
      if (std::optional<StructureError> error = m_structures[bone]->error()) {
        error->bone = bones()[bone].name;
        errors.push_back(*std::move(error));
      }
    }
    return errors;
  }

 private:
  struct DealtBatch {
    NodeBatch batch;
    std::size_t muscle;         ///< of those that are told apart
    Nanoseconds detect_ns = 0;  ///< where they are
  };

  [[nodiscard]] const BoneStructure& structure(int bone) const { return *m_structures[static_cast<std::size_t>(bone)]; }

  [[nodiscard]] std::unique_ptr<BoneStructure> build_over(std::size_t bone, const Eigen::AlignedBox3d& expected,
                                                          const ShareReport& report) const {
    return m_method.build_part ? m_method.build_part(bones()[bone], threads(), report, expected)
                               : m_method.build(bones()[bone], threads(), report);
  }

  void do_build() override {
    m_structures.clear();
    m_partial.clear();
    m_keeps_clearances = m_method.capabilities.has_cache &&
                         (!m_method.cache_needs_closed_bones ||
                          std::ranges::all_of(bones(), [](const Bone& bone) { return is_closed(bone.surface.mesh); }));
    if (m_method.require_fit) {
      m_method.require_fit(bones());
    }
    for (std::size_t bone = 0; bone < bones().size(); ++bone) {
      const auto report = [&](double share) {
        build_report()((static_cast<double>(bone) + share) / static_cast<double>(bones().size()));
      };
      m_structures.push_back(
          is_pruned(bone) ? nullptr
                          : build_over(bone, expected_box(bone), build_report() ? ShareReport(report) : nullptr));
      if (m_structures.back() && m_structures.back()->kept_share() < 1) {
        m_partial.push_back({.bone = static_cast<int>(bone), .kept_share = m_structures.back()->kept_share()});
      }
    }
    reset_nodes(muscle().vertices.size());
  }

  void do_bring_back(std::size_t bone) override { build_whole(bone); }

  void build_whole(std::size_t bone) {
    m_structures[bone] = build_over(bone, unbounded_box(), nullptr);
    if (m_keeps_clearances) {
      m_clearances.take_up(static_cast<int>(bone));
      m_structures[bone]->reset_nodes(m_clearances.nodes());
    }
  }

  /// Those that were asked about what they leave out; whether there were any.
  bool complete_structures() {
    bool any = false;
    for (PrunedBone& partial : m_partial) {
      const auto bone = static_cast<std::size_t>(partial.bone);
      if (partial.is_back || !m_structures[bone]->found_left_out()) continue;
      any = partial.is_back = true;
      const ScopedTimer timer(partial.build_ns);
      build_whole(bone);
    }
    return any;
  }

  void reset_nodes(std::size_t nodes) {
    if (!m_keeps_clearances) {
      return;
    }
    m_clearances.reset(bones(), nodes);
    for (std::size_t bone = 0; bone < m_structures.size(); ++bone) {
      if (m_structures[bone]) {
        m_structures[bone]->reset_nodes(nodes);
      } else {
        m_clearances.leave_out(static_cast<int>(bone));
      }
    }
  }

  void do_detect(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) override {
    detect_all(positions, nodes, contacts);
    if (!complete_structures()) return;
    contacts.clear();
    detect_all(positions, nodes, contacts);
  }

  void detect_all(std::span<const Vec3> positions, std::span<const int> nodes, std::vector<Contact>& contacts) {
    if (m_keeps_clearances && positions.size() != m_clearances.nodes()) {
      reset_nodes(positions.size());
    }
    const bool uses_cache =
        m_keeps_clearances && (!m_method.asks_few_without_cache || m_clearances.sweeps(nodes.size()));
    if (uses_cache) {
      m_clearances.collect_expired(poses(), positions, nodes);
    }
    deal_out(positions, nodes, uses_cache);
    detect_batches(contacts);
  }

  /// In the order of the contacts: a batch a bone and muscle, or several where a thread more pays.
  void deal_out(std::span<const Vec3> positions, std::span<const int> nodes, bool uses_cache) {
    m_batches.clear();
    m_pays_for_threads = false;
    for (int bone = 0; bone < static_cast<int>(m_structures.size()); ++bone) {
      if (!m_structures[static_cast<std::size_t>(bone)]) continue;
      NodeBatch batch{bone, poses()[static_cast<std::size_t>(bone)], positions, {}, nullptr};
      std::span<const int> queried = nodes;
      if (uses_cache) {
        batch.clearances = &m_clearances;
        queried = m_clearances.expired(bone);
      }
      m_pays_for_threads |= threads() > 1 && queried.size() > m_method.nodes_a_batch;
      if (muscles().empty()) {
        deal_out_nodes(batch, 0, queried);
        continue;
      }
      for (std::size_t muscle = 0; muscle < muscles().size(); ++muscle) {
        const auto end = std::ranges::lower_bound(queried, muscles()[muscle].last_node);
        const auto own = static_cast<std::size_t>(end - queried.begin());
        deal_out_nodes(batch, muscle, queried.first(own));
        queried = queried.subspan(own);
      }
    }
  }

  void deal_out_nodes(NodeBatch batch, std::size_t muscle, std::span<const int> nodes) {
    while (!nodes.empty()) {
      batch.nodes = nodes.first(threads() > 1 ? std::min(nodes.size(), m_method.nodes_a_batch) : nodes.size());
      m_batches.push_back({batch, muscle});
      nodes = nodes.subspan(batch.nodes.size());
    }
  }

  void detect_batches(std::vector<Contact>& contacts) {
    // Without OpenMP where no bone has work for two: it allocates even a team of one.
    if (!m_pays_for_threads) {
      for (DealtBatch& batch : m_batches) detect_batch(batch, contacts);
      add_pair_times();
      return;
    }
    while (m_found.size() < m_batches.size()) {
      m_found.emplace_back().reserve(m_method.nodes_a_batch);
    }
    // Without a cache a thread gets the same batches in every step, so that what they read is near it.
#pragma omp parallel for schedule(static, 1) num_threads(threads())
    for (std::size_t n = 0; n < m_batches.size(); ++n) {
      m_found[n].clear();
      detect_batch(m_batches[n], m_found[n]);
    }
    for (std::size_t n = 0; n < m_batches.size(); ++n) {
      contacts.insert(contacts.end(), m_found[n].begin(), m_found[n].end());
    }
    add_pair_times();
  }

  void detect_batch(DealtBatch& dealt, std::vector<Contact>& contacts) {
    BoneStructure& structure = *m_structures[static_cast<std::size_t>(dealt.batch.bone)];
    if (muscles().empty()) {
      structure.detect(dealt.batch, contacts);
      return;
    }
    const ScopedTimer timer(dealt.detect_ns);
    structure.detect(dealt.batch, contacts);
  }

  void add_pair_times() {
    if (muscles().empty()) {
      return;
    }
    for (const DealtBatch& dealt : m_batches) {
      add_pair_time(static_cast<std::size_t>(dealt.batch.bone), dealt.muscle, dealt.detect_ns);
    }
  }

  PointMethod m_method;
  bool m_keeps_clearances = false;
  std::vector<std::unique_ptr<BoneStructure>> m_structures;  ///< one a bone
  std::vector<PrunedBone> m_partial;                         ///< bones of whose grid a part was built at first
  ClearanceCache m_clearances;
  // Scratch memory, kept so that a frame allocates nothing.
  std::vector<DealtBatch> m_batches;
  bool m_pays_for_threads = false;
  std::vector<std::vector<Contact>> m_found;  ///< by batch
};

}  // namespace

std::unique_ptr<CollisionBackend> make_point_backend(PointMethod method) {
  return std::make_unique<PointBackend>(std::move(method));
}

ParameterSpec cull_parameter() {
  return parameter::flag(
      {.name = "cull", .default_value = true, .help = "do not ask about nodes outside the bone's box"});
}

}  // namespace musclebench

#include "bench/cases/probe_case.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "core/base/random_numbers.hpp"
#include "core/mesh/surface_sampler.hpp"
#include "core/mesh_repair/sharp_features.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

namespace {

/// Only points inside tell a depth, but those outside tell whether they are taken for inside.
constexpr double share_inside = 0.75;
/// Points judged between two calls of `report`.
constexpr int report_interval = 1000;

std::vector<Vec3> points_about(const TriangleMesh& mesh, const ProbeCase& what) {
  const SurfaceSampler sampler(mesh);
  RandomNumbers random(what.seed);
  std::vector<Vec3> points;
  points.reserve(static_cast<std::size_t>(what.points));
  for (int i = 0; i < what.points; ++i) {
    const SurfaceSample sample = sampler.draw(random);
    const bool inwards = random.share() < share_inside;
    const double away_m = what.band_m * random.share();
    points.emplace_back(sample.point + (inwards ? -away_m : away_m) * sample.normal);
  }
  return points;
}

/// Gathers the rows of one bone.
class RegionErrors {
 public:
  void add(bool sharp, double signed_distance_m, const Contact* answer, bool has_depth) {
    const bool inside = signed_distance_m < 0;
    const bool reported = answer != nullptr;
    for (Region* region : {&m_all, sharp ? &m_sharp : &m_smooth}) {
      ++region->points;
      region->wrong_side += inside != reported ? 1 : 0;
      if (inside || reported) {
        region->errors_m.push_back(depth_error_m(signed_distance_m, answer, has_depth));
      }
    }
  }

  void append_rows(const std::string& bone, std::vector<ProbeRow>& rows) const {
    for (const auto& [name, region] : {std::pair("smooth", &m_smooth), {"sharp", &m_sharp}, {"all", &m_all}}) {
      rows.push_back({bone, name, region->points, static_cast<int>(region->errors_m.size()),
                      error_statistics(region->errors_m), region->wrong_side});
    }
  }

 private:
  struct Region {
    int points = 0;
    int wrong_side = 0;
    std::vector<double> errors_m;
  };
  Region m_smooth;
  Region m_sharp;
  Region m_all;
};

/// Of each point the contact with `bone`, or nullptr.
std::vector<const Contact*> answers_about(int bone, std::span<const Contact> contacts, std::size_t points) {
  std::vector<const Contact*> answers(points, nullptr);
  for (const Contact& contact : contacts) {
    if (contact.bone == bone) {
      answers[static_cast<std::size_t>(contact.node)] = &contact;
    }
  }
  return answers;
}

class Probe {
 public:
  Probe(const ProbeCase& what, const std::function<void(int)>& report)
      : m_what(what), m_report(report), m_backend(what.backend.make(what.parameters)) {}

  ProbeResult run() {
    if (!m_backend->capabilities().point_queries) {
      m_result.status = "unsupported";
      m_result.status_detail =
          fmt::format("{} collides whole surfaces and cannot be asked about points", m_what.backend.name);
      return m_result;
    }
    const Nanoseconds start_ns = monotonic_now_ns();
    m_backend->build(m_what.scene.bones, m_what.scene.muscle_mesh, m_what.threads);
    m_result.build_ns = monotonic_now_ns() - start_ns;
    m_result.structure_bytes = m_backend->structure_bytes();
    m_result.structures = m_backend->structure_origin();
    const Referee referee(m_what.scene.bones, 0);
    for (std::size_t bone = 0; bone < m_what.scene.bones.size(); ++bone) {
      probe_bone(static_cast<int>(bone), referee);
    }
    return m_result;
  }

 private:
  void probe_bone(int bone, const Referee& referee) {
    const Bone& of = m_what.scene.bones[static_cast<std::size_t>(bone)];
    const std::vector<Vec3> points = points_about(of.surface.mesh, m_what);
    const std::vector<Contact> contacts = detect(points);
    const std::vector<const Contact*> answers = answers_about(bone, contacts, points.size());
    const SharpFeatures sharp(of.surface.mesh);
    const bool has_depth = m_backend->capabilities().depth;
    RegionErrors errors;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const SurfaceDistance truth = referee.closest(bone, points[i]);
      errors.add(sharp.near(truth.closest_point_m), truth.signed_distance_m, answers[i], has_depth);
      if (++m_judged % report_interval == 0) {
        m_report(m_judged);
      }
    }
    errors.append_rows(of.name, m_result.rows);
    m_result.bones.push_back({of.name, m_backend->step_m(bone), sharp.radius_m(), sharp.edges(), sharp.vertices()});
  }

  std::vector<Contact> detect(const std::vector<Vec3>& points) {
    std::vector<int> nodes(points.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      nodes[i] = static_cast<int>(i);
    }
    std::vector<Contact> contacts;
    m_backend->update(std::vector<RigidMotion>(m_what.scene.bones.size()), points);
    const Nanoseconds start_ns = monotonic_now_ns();
    m_backend->detect(points, nodes, contacts);
    m_result.detect_ns += monotonic_now_ns() - start_ns;
    return contacts;
  }

  const ProbeCase& m_what;
  const std::function<void(int)>& m_report;
  std::unique_ptr<CollisionBackend> m_backend;
  ProbeResult m_result;
  int m_judged = 0;
};

}  // namespace

ProbeResult probe(const ProbeCase& what, const std::function<void(int points_done)>& report) {
  return Probe(what, report).run();
}

}  // namespace musclebench

#include "bench/cases/query_set.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "backends/registry.hpp"
#include "bench/cases/verification.hpp"
#include "core/base/atomic_file.hpp"
#include "core/base/input_error.hpp"
#include "core/base/percentile.hpp"
#include "core/base/sha256.hpp"
#include "core/mesh/mesh_size.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

namespace {

constexpr std::string_view hash_word = "sha256 ";
constexpr std::size_t hash_line_bytes = hash_word.size() + 64 + 1;
constexpr std::size_t asked_of_slow_backends = 2000;

Vec3 vector_at(const std::vector<double>& values, std::size_t i) { return Eigen::Map<const Vec3>(&values[3 * i]); }

void add_vector(std::vector<double>& values, const Vec3& vector) {
  values.insert(values.end(), vector.data(), vector.data() + 3);
}

/// Queries within the band, with all that classify_sites needs.
struct FoundQueries {
  std::vector<ContactSite> sites;  ///< `surface_point_m` is the closest point
  std::vector<Vec3> points_m;
  std::vector<double> distances_m;
  std::vector<int> steps;

  /// Keeps the queries of every `stride`-th free node.
  void thin_out(std::span<const int> free_nodes, std::size_t stride) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < sites.size(); ++i) {
      const auto rank = std::lower_bound(free_nodes.begin(), free_nodes.end(), sites[i].node) - free_nodes.begin();
      if (static_cast<std::size_t>(rank) % stride != 0) continue;
      sites[kept] = sites[i];
      points_m[kept] = points_m[i];
      distances_m[kept] = distances_m[i];
      steps[kept] = steps[i];
      ++kept;
    }
    sites.resize(kept);
    points_m.resize(kept);
    distances_m.resize(kept);
    steps.resize(kept);
  }
};

/// The bone's box, which tells without a search that a node is far.
void find_within_band(const Referee& referee, const std::vector<Eigen::AlignedBox3d>& boxes, const RecordedStep& step,
                      int step_number, std::span<const int> nodes, double band_m, FoundQueries& found) {
  for (int bone = 0; bone < static_cast<int>(boxes.size()); ++bone) {
    const RigidMotion& pose = step.bone_poses[static_cast<std::size_t>(bone)];
    for (const int node : nodes) {
      const Vec3 point = pose.apply_inverse(step.positions[static_cast<std::size_t>(node)]);
      if (!point.allFinite() || boxes[static_cast<std::size_t>(bone)].exteriorDistance(point) > band_m) continue;
      const SurfaceDistance answer = referee.closest(bone, point);
      if (std::abs(answer.signed_distance_m) > band_m) continue;
      found.sites.push_back({bone, 0, node, answer.closest_point_m, answer.normal});
      found.points_m.push_back(point);
      found.distances_m.push_back(answer.signed_distance_m);
      found.steps.push_back(step_number);
    }
  }
}

/// Points that no node was at.
void add_points(const Referee& referee, std::size_t bone, std::span<const Vec3> points, QuerySet& set) {
  const auto index = static_cast<std::int32_t>(bone);
  for (const Vec3& point : points) {
    const SurfaceDistance answer = referee.closest(index, point);
    add_vector(set.points_m, point);
    add_vector(set.closest_m, answer.closest_point_m);
    set.distances_m.push_back(answer.signed_distance_m);
    set.bone.push_back(index);
    set.node.push_back(-1);
    set.step.push_back(-1);
    set.difficulty.push_back(around_the_bone);
  }
}

QuerySet::Bone bone_of(const Bone& bone) {
  QuerySet::Bone copy{bone.name, {}, {}};
  std::replace(copy.name.begin(), copy.name.end(), ' ', '_');  // the head has words
  for (const Vec3& vertex : bone.surface.mesh.vertices) add_vector(copy.vertices_m, vertex);
  for (const Triangle& corners : bone.surface.mesh.triangles) {
    copy.triangles.insert(copy.triangles.end(), corners.begin(), corners.end());
  }
  return copy;
}

Bone bone_of(const QuerySet::Bone& bone) {
  Bone copy{bone.name, {}};
  for (std::size_t i = 0; 3 * i < bone.vertices_m.size(); ++i) {
    copy.surface.mesh.vertices.push_back(vector_at(bone.vertices_m, i));
  }
  for (std::size_t i = 0; i < bone.triangles.size(); i += 3) {
    copy.surface.mesh.triangles.push_back({bone.triangles[i], bone.triangles[i + 1], bone.triangles[i + 2]});
  }
  return copy;
}

std::string head_of(const QuerySet& set) {
  std::string head = fmt::format("musclebench queries 1\n{}\n{} {}\n", set.about, set.bones.size(), set.bone.size());
  for (const QuerySet::Bone& bone : set.bones) {
    head += fmt::format("{} {} {}\n", bone.vertices_m.size() / 3, bone.triangles.size() / 3, bone.name);
  }
  return head;
}

template <typename Look>
void for_each_array(const QuerySet& set, const Look& look) {
  for (const QuerySet::Bone& bone : set.bones) {
    look(bone.vertices_m);
    look(bone.triangles);
  }
  look(set.points_m);
  look(set.closest_m);
  look(set.distances_m);
  for (const auto* values : {&set.bone, &set.node, &set.step, &set.difficulty}) look(*values);
}

void require_in_range(const std::filesystem::path& path, const char* what, const std::vector<std::int32_t>& values,
                      std::size_t end) {
  for (const std::int32_t value : values) {
    if (value < 0 || static_cast<std::size_t>(value) >= end) {
      throw InputError(path.string(), fmt::format("{} {} is out of range; write the set again", what, value));
    }
  }
}

void require_hash(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::size_t hashed = bytes.size() - std::min(bytes.size(), hash_line_bytes);
  Sha256 hash;
  hash.add(std::string_view(bytes).substr(0, hashed));
  if (bytes.substr(hashed) != fmt::format("{}{}\n", hash_word, hash.hex_digest())) {
    throw InputError(path.string(), "does not end in the hash of its content; it was cut off or changed");
  }
}

}  // namespace

std::string_view difficulty_name(std::int32_t difficulty) {
  return difficulty == around_the_bone ? "around the bone" : contact_difficulties[static_cast<std::size_t>(difficulty)];
}

QuerySet queries_of(const Scene& scene, FrameSource& recording, const QueryChoice& choice,
                    const std::function<void(int)>& report) {
  const RecordingHeader& header = recording.header();
  const Referee referee(scene.bones, 0);
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<double> diagonals_m;
  for (const Bone& bone : scene.bones) {
    boxes.push_back(bounding_box(bone.surface.mesh.vertices));
    diagonals_m.push_back(boxes.back().diagonal().norm());
  }
  FoundQueries found;
  RecordedFrame frame;
  recording.rewind();
  for (int index = 1, moment = 0; index <= header.frames(); ++index) {
    recording.read(frame);
    // The moments divide the motion evenly, and the last is its last frame.
    if (static_cast<long>(index) * choice.moments < static_cast<long>(moment + 1) * header.frames()) continue;
    const std::size_t steps = std::min(frame.steps.size(), static_cast<std::size_t>(choice.steps));
    for (std::size_t i = 0; i < steps; ++i) {
      const int number = (index - 1) * header.steps_per_frame() + static_cast<int>(i);
      find_within_band(referee, boxes, frame.steps[i], number, header.free_nodes, choice.band_m, found);
    }
    moment = static_cast<int>(static_cast<long>(index) * choice.moments / header.frames());
    report(moment);
  }
  if (found.sites.empty()) {
    throw InputError(scene.name, fmt::format("no node comes within {:g} mm of a bone at the moments chosen; choose a "
                                             "wider --band-mm or more --moments",
                                             1e3 * choice.band_m));
  }
  if (found.sites.size() > choice.most) {
    found.thin_out(header.free_nodes, (found.sites.size() + choice.most - 1) / choice.most);
  }
  classify_sites(referee, diagonals_m, scene.muscle_mesh, header.free_nodes, found.sites);

  QuerySet set;
  for (const Bone& bone : scene.bones) set.bones.push_back(bone_of(bone));
  for (std::size_t i = 0; i < found.sites.size(); ++i) {
    const ContactSite& site = found.sites[i];
    add_vector(set.points_m, found.points_m[i]);
    add_vector(set.closest_m, site.surface_point_m);
    set.distances_m.push_back(found.distances_m[i]);
    set.bone.push_back(site.bone);
    set.node.push_back(site.node);
    set.step.push_back(found.steps[i]);
    set.difficulty.push_back(static_cast<std::int32_t>(site.difficulty));
  }
  for (std::size_t bone = 0; bone < scene.bones.size(); ++bone) {
    // Vertices, middles of edges, points next to the surface and anywhere: a muscle brings few of these.
    add_points(referee, bone, points_about(scene.bones[bone].surface.mesh, choice.around, 1 + bone), set);
  }
  return set;
}

QuerySet queries_about(const Bone& bone, std::span<const Vec3> points) {
  const Referee referee(std::span(&bone, 1), 0);
  QuerySet set;
  set.bones.push_back(bone_of(bone));
  add_points(referee, 0, points, set);
  return set;
}

std::string write_query_set(const std::filesystem::path& path, const QuerySet& set) {
  Sha256 hash;
  std::string digest;
  write_atomically(path, [&](std::ostream& file) {
    const std::string head = head_of(set);
    hash.add(head);
    file << head;
    for_each_array(set, [&](const auto& values) {
      const auto bytes = std::as_bytes(std::span(values));
      hash.add(bytes);
      file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    });
    digest = hash.hex_digest();
    file << hash_word << digest << '\n';
  });
  return digest;
}

QuerySet read_checked_query_set(const std::filesystem::path& path) {
  QuerySet set;
  try {
    set = read_query_set(path.string());
  } catch (const std::runtime_error& problem) {
    throw InputError(path.string(), std::string(problem.what()).substr(path.string().size() + 2) +
                                        "; name a file that `musclebench queries` wrote");
  }
  require_hash(path);
  for (const QuerySet::Bone& bone : set.bones) {
    require_in_range(path, "vertex", bone.triangles, bone.vertices_m.size() / 3);
  }
  require_in_range(path, "bone", set.bone, set.bones.size());
  require_in_range(path, "difficulty", set.difficulty, around_the_bone + std::size_t{1});
  return set;
}

std::vector<double> read_answers(const std::filesystem::path& path, const QuerySet& set) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw InputError(path.string(), "cannot be read; name the file with the answers");
  const auto bytes = static_cast<std::uint64_t>(std::streamoff(file.tellg()));
  if (bytes != set.bone.size() * sizeof(double)) {
    throw InputError(path.string(), fmt::format("has {} bytes, and {} queries have {}; write one double a query", bytes,
                                                set.bone.size(), set.bone.size() * sizeof(double)));
  }
  std::vector<double> answers(set.bone.size());
  file.seekg(0);
  file.read(reinterpret_cast<char*>(answers.data()), static_cast<std::streamsize>(bytes));
  return answers;
}

QueryErrors compare_answers(const QuerySet& set, const std::vector<double>& answers,
                            const std::function<bool(std::size_t)>& counts) {
  std::vector<double> unclear_m;  // nearer to the surface than this the side may be either
  for (const QuerySet::Bone& bone : set.bones) {
    const TriangleMesh mesh = bone_of(bone).surface.mesh;
    unclear_m.push_back(std::max(touching_distance_m(mesh), agreed_difference_m(mesh)));
  }
  QueryErrors found;
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!counts(i)) continue;
    ++found.queries;
    const double truth_m = set.distances_m[i];
    if (!std::isfinite(answers[i])) {
      ++found.unanswered;
      continue;
    }
    errors_m.push_back(std::abs(answers[i] - truth_m));
    const bool is_clear = std::abs(truth_m) > unclear_m[static_cast<std::size_t>(set.bone[i])];
    if (is_clear && (answers[i] < 0) != (truth_m < 0)) ++found.wrong_sides;
  }
  if (errors_m.empty()) return found;
  found.largest_m = *std::max_element(errors_m.begin(), errors_m.end());
  found.p99_m = percentile(std::move(errors_m), 0.99);
  return found;
}

std::vector<QuerySetCheck> check_query_set(const QuerySet& set) {
  std::vector<Bone> bones;
  double agreed_m = 0;
  for (const QuerySet::Bone& bone : set.bones) {
    bones.push_back(bone_of(bone));
    agreed_m = std::max(agreed_m, agreed_difference_m(bones.back().surface.mesh));
  }
  std::vector<QuerySetCheck> checks;
  for (const BackendEntry& backend : backend_registry()) {
    if (!backend.exact || !backend.signed_distance) continue;
    std::vector<SignedDistance> distances;
    for (const Bone& bone : bones) distances.push_back(backend.signed_distance(bone, 1));
    const bool is_slow = &backend != &exact_backend();
    const std::size_t stride = is_slow ? set.bone.size() / asked_of_slow_backends + 1 : 1;
    std::vector<double> answers(set.bone.size());
    for (std::size_t i = 0; i < answers.size(); i += stride) {
      answers[i] = distances[static_cast<std::size_t>(set.bone[i])](vector_at(set.points_m, i));
    }
    checks.push_back(
        {backend.name, compare_answers(set, answers, [&](std::size_t i) { return i % stride == 0; }), agreed_m});
  }
  return checks;
}

double largest_gap_m(const QuerySet& set) {
  double largest_m = 0;
  for (std::size_t i = 0; i < set.bone.size(); ++i) {
    const double distance_m = (vector_at(set.points_m, i) - vector_at(set.closest_m, i)).norm();
    const double gap_m = std::abs(distance_m - std::abs(set.distances_m[i]));
    if (!(gap_m <= largest_m)) largest_m = gap_m;  // NaN is the largest
  }
  return largest_m;
}

}  // namespace musclebench

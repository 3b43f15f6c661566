#include "bench/queries/query_set_file.hpp"

#include <algorithm>
#include <fstream>
#include <span>
#include <stdexcept>

#include <fmt/format.h>

#include "core/base/atomic_file.hpp"
#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"
#include "core/measure/contact_sites.hpp"

namespace musclebench {

namespace {

constexpr std::string_view hash_word = "sha256 ";
constexpr std::size_t hash_line_bytes = hash_word.size() + 64 + 1;

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

}  // namespace musclebench

#pragma once
// Reads a query set of musclebench (datasets/queries/README.md). Needs nothing but C++17 and a little-endian machine.

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

struct QuerySet {
  struct Bone {
    std::string name;
    std::vector<double> vertices_m;       // x, y, z of each vertex
    std::vector<std::int32_t> triangles;  // three vertices of each, counter-clockwise from outside
  };
  std::string about;
  std::vector<Bone> bones;
  std::vector<double> points_m;                            // x, y, z of each query, in the rest frame of its bone
  std::vector<double> closest_m;                           // x, y, z of the closest point of the bone's surface
  std::vector<double> distances_m;                         // signed, one a query: negative inside
  std::vector<std::int32_t> bone, node, step, difficulty;  // one a query
};

inline QuerySet read_query_set(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto file_bytes = static_cast<std::uint64_t>(file ? std::streamoff(file.tellg()) : 0);
  std::uint64_t left_bytes = file_bytes;  // no more is allocated than the file can hold
  file.seekg(0);
  std::string line;
  const auto next_line = [&]() -> std::string& {
    if (!std::getline(file, line)) throw std::runtime_error(path + ": cannot be read, or is cut off");
    return line;
  };
  const auto read = [&](auto& values, std::uint64_t count) {
    const std::uint64_t bytes = sizeof(values[0]) * count;
    if (count > file_bytes || bytes > left_bytes) throw std::runtime_error(path + ": is cut off");
    left_bytes -= bytes;
    values.resize(count);
    file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(bytes));
    if (!file) throw std::runtime_error(path + ": is cut off");
  };
  if (next_line() != "musclebench queries 1") throw std::runtime_error(path + ": is no query set of version 1");
  QuerySet set;
  set.about = next_line();
  std::uint64_t bones = 0, queries = 0;
  if (!(std::istringstream(next_line()) >> bones >> queries)) throw std::runtime_error(path + ": lacks its counts");
  std::vector<std::uint64_t> counts;
  for (std::uint64_t i = 0; i < bones; ++i) {
    std::uint64_t vertices = 0, triangles = 0;
    std::istringstream told(next_line());
    set.bones.emplace_back();
    if (!(told >> vertices >> triangles >> set.bones.back().name)) throw std::runtime_error(path + ": lacks a bone");
    counts.insert(counts.end(), {vertices, triangles});
  }
  for (std::size_t i = 0; i < set.bones.size(); ++i) {
    read(set.bones[i].vertices_m, 3 * counts[2 * i]);
    read(set.bones[i].triangles, 3 * counts[2 * i + 1]);
  }
  read(set.points_m, 3 * queries);
  read(set.closest_m, 3 * queries);
  read(set.distances_m, queries);
  for (std::vector<std::int32_t>* values : {&set.bone, &set.node, &set.step, &set.difficulty}) read(*values, queries);
  return set;
}

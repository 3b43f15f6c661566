#include "backends/sdf/files/octree_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/files/sealed_file.hpp"
#include "backends/sdf/octree/octree_entry.hpp"
#include "backends/sdf/octree/octree_polynomial.hpp"

namespace musclebench {

namespace {

/// Raise when the meaning of the bytes changes, or what the builder makes of the same settings.
constexpr std::uint32_t octree_format_version = 3;
constexpr FileMark octree_file_mark{
    {'M', 'B', 'O', 'C', 'T', 'R', 'E', 'E'}, FileMark{}.byte_order, octree_format_version};

struct OctreeHeader {
  FileMark mark = octree_file_mark;
  double wanted_m = 0;
  double wanted_near_m = 0;
  double margin = 0;
  std::array<double, 3> lower_m{};
  double root_edge_m = 0;
  std::array<std::int32_t, 3> roots{};
  std::uint32_t unused = 0;
  OctreeQuality quality;
  std::uint64_t entries = 0;
  std::uint64_t coefficients = 0;
  FileDigest surface{};
  FileDigest content{};  ///< of the header with this field zero, the entries and the coefficients
};
static_assert(sizeof(OctreeQuality) == 10 * 8);
static_assert(sizeof(OctreeHeader) == 16 + 24 + 32 + 16 + sizeof(OctreeQuality) + 16 + 128,
              "written as it stands: there must be no padding");

OctreeHeader header_of(const std::string& digest, const OctreeSettings& settings) {
  OctreeHeader header;
  header.wanted_m = settings.max_error_m;
  header.wanted_near_m = settings.near_m;
  header.margin = settings.margin;
  header.surface = as_file_digest(digest);
  return header;
}

std::string first_difference(const OctreeHeader& found, const OctreeHeader& wanted) {
  if (std::string mark = first_difference(found.mark, wanted.mark, "an adaptive field's file"); !mark.empty()) {
    return mark;
  }
  if (found.surface != wanted.surface) {
    return "was made from another surface";
  }
  if (found.wanted_m != wanted.wanted_m) {
    return fmt::format("was built to {} mm, wanted is {}", found.wanted_m * 1e3, wanted.wanted_m * 1e3);
  }
  if (found.margin != wanted.margin || found.wanted_near_m != wanted.wanted_near_m) {
    return "was built with another margin";
  }
  return "";
}

/// Whether every path through the tree ends at a leaf whose coefficients are there.
bool is_tree(const OctreeHeader& header, std::span<const std::uint32_t> entries, std::size_t coefficients) {
  double roots = 1;
  for (const std::int32_t along : header.roots) {
    if (along < 1) {
      return false;
    }
    roots *= along;
  }
  if (roots > static_cast<double>(entries.size())) {
    return false;
  }
  for (std::size_t index = 0; index < entries.size(); ++index) {
    const std::size_t offset = octree_entry::offset_of(entries[index]);
    const bool is_split = octree_entry::kind_of(entries[index]) == octree_entry::Kind::split;
    // Children come after their parent, so no path is a circle.
    if (is_split ? offset <= index || offset + 8 > entries.size() : offset + cubic_terms > coefficients) {
      return false;
    }
  }
  return true;
}

bool has_sensible_numbers(const OctreeHeader& header, std::span<const float> coefficients) {
  const OctreeQuality& quality = header.quality;
  return header.root_edge_m > 0 && std::isfinite(header.root_edge_m) && quality.sign_error_distance_m >= 0 &&
         std::isfinite(quality.sign_error_distance_m) && quality.excess_m >= 0 && std::isfinite(quality.excess_m) &&
         std::all_of(header.lower_m.begin(), header.lower_m.end(), [](double x) { return std::isfinite(x); }) &&
         std::all_of(coefficients.begin(), coefficients.end(), [](float x) { return std::isfinite(x); });
}

}  // namespace

void save_octree(const OctreeField& field, const std::string& digest, const OctreeSettings& settings,
                 const std::filesystem::path& path) {
  OctreeHeader header = header_of(digest, settings);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.lower_m[axis] = field.shape().lower_m[static_cast<Eigen::Index>(axis)];
  }
  header.root_edge_m = field.shape().root_edge_m;
  header.roots = field.shape().roots;
  header.quality = field.quality();
  header.entries = field.entries().size();
  header.coefficients = field.coefficients().size();
  const std::array parts{std::as_bytes(std::span(field.entries())), std::as_bytes(std::span(field.coefficients()))};
  write_sealed(path, header, parts);
}

std::optional<OctreeField> load_octree(const std::filesystem::path& path, const std::string& digest,
                                       const OctreeSettings& settings) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return std::nullopt;
  }
  SealedReader<OctreeHeader> in(path);
  const OctreeHeader& found = in.header();
  if (const std::string difference = first_difference(found, header_of(digest, settings)); !difference.empty()) {
    in.refuse(difference);
  }
  std::vector<std::uint32_t> entries = in.read_all<std::uint32_t>(found.entries);
  std::vector<float> coefficients = in.read_all<float>(found.coefficients);
  in.require_intact();
  if (!is_tree(found, entries, coefficients.size()) || !has_sensible_numbers(found, coefficients)) {
    in.refuse("does not hold an octree");
  }
  OctreeShape shape{{found.lower_m[0], found.lower_m[1], found.lower_m[2]}, found.root_edge_m, found.roots};
  return OctreeField(shape, found.quality, std::move(entries), std::move(coefficients));
}

}  // namespace musclebench

#include <array>
#include <utility>

#include "backends/sdf/build/field_builder.hpp"
#include "backends/sdf/build/octree_builder.hpp"
#include "backends/sdf/files/discregrid_file.hpp"
#include "backends/sdf/files/field_file.hpp"
#include "backends/sdf/files/foreign_field.hpp"
#include "backends/sdf/files/octree_file.hpp"
#include "backends/sdf/octree/octree_entry.hpp"
#include "backends/sdf/octree/octree_polynomial.hpp"
#include "core/base/sha256.hpp"
#include "core/fuzz/fuzzed_reader.hpp"
#include "core/mesh/shapes.hpp"

namespace musclebench {
namespace {

/// The bone of all files, and what they are made with.
struct FuzzedBone {
  RepairedMesh surface{make_sphere(0.1, 1), true, {}};
  SignedSurface distance{surface};
  GridShape shape = grid_over(surface.mesh, {.cells = 2}, "ball");
  OctreeSettings octree;
  std::string digest = surface_digest(surface);
};

/// Made once: a search of a surface takes longer to build than a file to read.
const FuzzedBone& fuzzed_bone() {
  static const FuzzedBone bone;
  return bone;
}

/// Within the bone, near its surface, and out of the domain.
constexpr std::array<double, 5> query_positions_m{-0.3, -0.1, 0.01, 0.07, 0.1};

template <typename Field>
void ask(const Field& field) {
  for (const double x : query_positions_m) {
    for (const double y : query_positions_m) (void)field.sample(Vec3(x, y, -0.02));
  }
}

constexpr std::size_t digits_of_digest = 64;

/// Where a sealed file has the digest of its content: the first of so many hexadecimal digits behind the surface's own.
std::size_t digest_offset(std::string_view file) { return file.find(fuzzed_bone().digest) + digits_of_digest; }

/// With the digest that its bytes have, as no change of a bit would get past the old one.
std::string sealed(std::string_view bytes, std::size_t offset) {
  std::string file(bytes);
  if (file.size() < offset + digits_of_digest) return file;
  file.replace(offset, digits_of_digest, digits_of_digest, '\0');
  Sha256 hash;
  hash.add(file);
  return file.replace(offset, digits_of_digest, hash.hex_digest());
}

std::vector<std::string> make_fields() {
  const TemporaryFile file("", ".field");
  save_field(build_field(fuzzed_bone().distance, fuzzed_bone().shape, 1), fuzzed_bone().digest, file.path());
  return {file.bytes()};
}

/// Two cubes, one split; a built one has some hundred kilobytes.
OctreeField small_octree() {
  using octree_entry::entry;
  using octree_entry::Kind;
  std::vector<std::uint32_t> entries{entry(Kind::split, 2), entry(Kind::outside, 0)};
  for (std::size_t leaf = 0; leaf < 8; ++leaf) {
    entries.push_back(entry(leaf % 2 == 0 ? Kind::quadratic : Kind::cubic, leaf));
  }
  return {{.lower_m = Vec3::Constant(-0.1), .root_edge_m = 0.1, .roots = {2, 1, 1}},
          {.finest_edge_m = 0.05},
          std::move(entries),
          std::vector<float>(8 + cubic_terms, 0.01F)};
}

std::vector<std::string> make_octrees() {
  const TemporaryFile file("", ".octree");
  save_octree(small_octree(), fuzzed_bone().digest, fuzzed_bone().octree, file.path());
  return {file.bytes()};
}

std::vector<std::string> make_discregrids() {
  const TemporaryFile file("", ".cdf");
  write_discregrid(build_field(fuzzed_bone().distance, fuzzed_bone().shape, 1), file.path());
  return {file.bytes()};
}

void read_field_bytes(std::string_view bytes) {
  static const std::size_t offset = digest_offset(make_fields().front());
  const TemporaryFile file(sealed(bytes, offset), ".field");
  ask(load_field(file.path(), fuzzed_bone().digest, fuzzed_bone().shape).value());
}

void read_octree_bytes(std::string_view bytes) {
  static const std::size_t offset = digest_offset(make_octrees().front());
  const TemporaryFile file(sealed(bytes, offset), ".octree");
  ask(load_octree(file.path(), fuzzed_bone().digest, fuzzed_bone().octree).value());
}

void read_discregrid_bytes(std::string_view bytes) {
  const FuzzedBone& bone = fuzzed_bone();
  const TemporaryFile file(bytes, ".cdf");
  const CubicField field = read_discregrid(file.path(), 1);
  ask(field);
  require_field_of(field, bone.surface.mesh, bone.distance, "ball", file.path());
}

}  // namespace

std::span<const FuzzedReader> fuzzed_readers() {
  static constexpr std::array readers = {
      FuzzedReader{"field", read_field_bytes, make_fields},
      FuzzedReader{"octree", read_octree_bytes, make_octrees},
      FuzzedReader{"discregrid", read_discregrid_bytes, make_discregrids},
  };
  return readers;
}

}  // namespace musclebench

#include "backends/sdf/files/field_file.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "backends/sdf/files/sealed_file.hpp"
#include "core/base/sha256.hpp"

namespace musclebench {

namespace {

/// Raise when the meaning of a field's bytes changes.
constexpr std::uint32_t field_format_version = 4;
constexpr FileMark field_file_mark{
    {'M', 'B', 'F', 'I', 'E', 'L', 'D', '\0'}, FileMark{}.byte_order, field_format_version};

struct FieldHeader {
  FileMark mark = field_file_mark;
  std::array<double, 3> lower_m{};
  std::array<double, 3> cell_size_m{};
  std::array<std::int32_t, 3> cells{};
  std::uint32_t unused = 0;  ///< so that what follows is aligned
  FieldFacts facts;
  FileDigest surface{};
  FileDigest content{};  ///< of the header with this field zero, all that follows
};
static_assert(sizeof(FieldHeader) == 8 + 8 + 48 + 16 + 48 + 128, "written as it stands: there must be no padding");

FieldHeader header_of(const GridShape& shape, const std::string& digest) {
  FieldHeader header;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.lower_m[axis] = shape.lower_m[static_cast<Eigen::Index>(axis)];
    header.cell_size_m[axis] = shape.cell_size_m[static_cast<Eigen::Index>(axis)];
  }
  header.cells = shape.cells;
  header.surface = as_file_digest(digest);
  return header;
}

std::string first_difference(const FieldHeader& found, const FieldHeader& wanted) {
  if (std::string mark = first_difference(found.mark, wanted.mark, "a field file"); !mark.empty()) {
    return mark;
  }
  if (found.cells != wanted.cells) {
    return fmt::format("has {} x {} x {} cells, wanted are {} x {} x {}", found.cells[0], found.cells[1],
                       found.cells[2], wanted.cells[0], wanted.cells[1], wanted.cells[2]);
  }
  if (found.surface != wanted.surface) {
    return "was made from another surface";
  }
  if (found.lower_m != wanted.lower_m || found.cell_size_m != wanted.cell_size_m) {
    return "covers another box (another margin or cell size)";
  }
  return "";
}

}  // namespace

std::string surface_digest(const RepairedMesh& surface) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(surface.mesh.vertices)));
  hash.add(std::as_bytes(std::span(surface.mesh.triangles)));
  hash.add(surface.clean ? std::string_view("pseudo-normals") : std::string_view("winding number"));
  return hash.hex_digest();
}

void save_field(const CubicField& field, const std::string& digest, const std::filesystem::path& path) {
  FieldHeader header = header_of(field.shape(), digest);
  header.facts = field.facts();
  write_sealed(path, header,
               std::array{std::as_bytes(std::span(field.values())), std::as_bytes(std::span(field.mask()))});
}

std::optional<CubicField> load_field(const std::filesystem::path& path, const std::string& digest,
                                     const GridShape& shape) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return std::nullopt;
  }
  SealedReader<FieldHeader> in(path);
  if (const std::string difference = first_difference(in.header(), header_of(shape, digest)); !difference.empty()) {
    in.refuse(difference);
  }
  CubicField field(shape);
  in.read_into(field.values());
  in.read_into(field.mask());
  field.facts() = in.header().facts;
  in.require_intact();
  return field;
}

}  // namespace musclebench

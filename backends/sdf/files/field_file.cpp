#include "backends/sdf/files/field_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "backends/sdf/files/sealed_file.hpp"
#include "core/base/sha256.hpp"

namespace musclebench {

namespace {

/// Raise when the meaning of a field's bytes changes.
constexpr std::uint32_t format_version = 2;
constexpr FileMark file_mark{{'M', 'B', 'F', 'I', 'E', 'L', 'D', '\0'}, FileMark{}.byte_order, format_version};

struct Header {
  FileMark mark = file_mark;
  std::array<double, 3> lower_m{};
  std::array<double, 3> cell_size_m{};
  std::array<std::int32_t, 3> cells{};
  std::uint32_t bytes_per_value = 0;  ///< 2: compact records
  double band_m = 0;
  FieldFacts facts;
  FileDigest surface{};
  FileDigest content{};  ///< of the header with this field zero, all that follows
};
static_assert(sizeof(Header) == 8 + 8 + 48 + 16 + 8 + 56 + 128, "written as it stands: there must be no padding");

/// Calls visit(range) for everything of a field that stands in the file behind the header, in its order.
template <typename Field, typename Visit>
void for_each_part(Field& field, const Visit& visit) {
  visit(field.single_values());
  visit(field.double_values());
  visit(field.compact_records());
  visit(field.mask());
}

template <typename Band, typename Visit>
void for_each_part_of_band(Band& band, const Visit& visit) {
  visit(band.cell_bits());
  visit(band.far_bounds_m());
}

Header header_of(const GridShape& shape, const FieldSettings& settings, const std::string& digest) {
  Header header;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.lower_m[axis] = shape.lower_m[static_cast<Eigen::Index>(axis)];
    header.cell_size_m[axis] = shape.cell_size_m[static_cast<Eigen::Index>(axis)];
  }
  header.cells = shape.cells;
  header.bytes_per_value = static_cast<std::uint32_t>(settings.precision);
  header.band_m = settings.band_m.value_or(0);
  header.surface = as_file_digest(digest);
  return header;
}

FileDigest content_digest(Header header, const CubicField& field) {
  header.content.fill('\0');
  Sha256 hash;
  hash.add(std::as_bytes(std::span(&header, 1)));
  const auto add = [&](const auto& range) { hash.add(std::as_bytes(std::span(range))); };
  if (field.band()) {
    for_each_part_of_band(*field.band(), add);
  }
  for_each_part(field, add);
  return as_file_digest(hash.hex_digest());
}

std::string first_difference(const Header& found, const Header& wanted) {
  if (const std::string mark = first_difference(found.mark, wanted.mark, "a field file"); !mark.empty()) {
    return mark;
  }
  if (found.bytes_per_value != wanted.bytes_per_value) {
    return fmt::format("holds values of {} bytes, wanted are {}", found.bytes_per_value, wanted.bytes_per_value);
  }
  if (found.band_m != wanted.band_m) {
    return fmt::format("has a band of {} m, wanted is {} m (0: all cells)", found.band_m, wanted.band_m);
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

void write_all(std::ostream& out, const Header& header, const CubicField& field) {
  write_bytes(out, std::as_bytes(std::span(&header, 1)));
  const auto write_range = [&](const auto& range) { write_bytes(out, std::as_bytes(std::span(range))); };
  if (field.band()) {
    for_each_part_of_band(*field.band(), write_range);
  }
  for_each_part(field, write_range);
  out.flush();
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
  Header header = header_of(field.shape(), {field.precision(), field.band() ? field.band()->width_m() : 0.0}, digest);
  header.facts = field.facts();
  header.content = content_digest(header, field);
  write_atomically(path, [&](std::ostream& out) { write_all(out, header, field); });
}

std::optional<CubicField> load_field(const std::filesystem::path& path, const std::string& digest,
                                     const GridShape& shape, const FieldSettings& settings) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return std::nullopt;
  }
  std::ifstream in(path, std::ios::binary);
  const auto read = [&](std::span<std::byte> bytes) {
    return static_cast<bool>(
        in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())));
  };
  Header found;
  const bool header_read = read(std::as_writable_bytes(std::span(&found, 1)));
  if (!header_read) {
    refuse_structure(path, in.is_open() ? "is too short for a field file" : "cannot be read");
  }
  if (const std::string difference = first_difference(found, header_of(shape, settings, digest)); !difference.empty()) {
    refuse_structure(path, difference);
  }
  bool complete = true;
  const auto read_range = [&](auto& range) { complete = complete && read(std::as_writable_bytes(std::span(range))); };
  std::optional<NarrowBand> band;
  if (settings.band_m) {
    band.emplace(shape, *settings.band_m);
    for_each_part_of_band(*band, read_range);
    band->index_records(shape);
  }
  CubicField field =
      band ? CubicField(shape, settings.precision, *std::move(band)) : CubicField(shape, settings.precision);
  for_each_part(field, read_range);
  field.facts() = found.facts;
  if (!complete) {
    refuse_structure(path, "is truncated");
  }
  if (in.peek() != std::ifstream::traits_type::eof()) {
    refuse_structure(path, "goes on after its end");
  }
  if (content_digest(found, field) != found.content) {
    refuse_structure(path, "is damaged: its checksum does not fit");
  }
  return field;
}

}  // namespace musclebench

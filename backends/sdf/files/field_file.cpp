#include "backends/sdf/files/field_file.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/files/sealed_file.hpp"
#include "core/base/sha256.hpp"

namespace musclebench {

namespace {

/// Raise when the meaning of a field's bytes changes.
constexpr std::uint32_t field_format_version = 3;
constexpr FileMark field_file_mark{
    {'M', 'B', 'F', 'I', 'E', 'L', 'D', '\0'}, FileMark{}.byte_order, field_format_version};

struct FieldHeader {
  FileMark mark = field_file_mark;
  std::array<double, 3> lower_m{};
  std::array<double, 3> cell_size_m{};
  std::array<std::int32_t, 3> cells{};
  std::uint32_t bytes_per_value = 0;  ///< 2: compact records
  double band_m = 0;
  FieldFacts facts;
  FileDigest surface{};
  FileDigest content{};  ///< of the header with this field zero, all that follows
};
static_assert(sizeof(FieldHeader) == 8 + 8 + 48 + 16 + 8 + 56 + 128, "written as it stands: there must be no padding");

/// Calls visit(range) for everything of a field that stands in the file behind the header, in its order.
template <typename Field, typename Visit>
void for_each_part(Field& field, const Visit& visit) {
  visit(field.single_values());
  visit(field.compact_records());
  visit(field.mask());
}

template <typename Band, typename Visit>
void for_each_part_of_band(Band& band, const Visit& visit) {
  visit(band.cell_bits());
  visit(band.far_bounds_m());
}

FieldHeader header_of(const GridShape& shape, const FieldSettings& settings, const std::string& digest) {
  FieldHeader header;
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

const char* precision_word(std::uint32_t bytes_per_value) {
  return bytes_per_value == static_cast<std::uint32_t>(FieldPrecision::compact) ? "compact" : "float";
}

std::string first_difference(const FieldHeader& found, const FieldHeader& wanted) {
  if (std::string mark = first_difference(found.mark, wanted.mark, "a field file"); !mark.empty()) {
    return mark;
  }
  if (found.bytes_per_value == sizeof(double)) {
    return "was stored with `precision=double`, which there is no more";
  }
  if (found.bytes_per_value != wanted.bytes_per_value) {
    return fmt::format("is of precision {}, wanted is {}", precision_word(found.bytes_per_value),
                       precision_word(wanted.bytes_per_value));
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

}  // namespace

std::string surface_digest(const RepairedMesh& surface) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(surface.mesh.vertices)));
  hash.add(std::as_bytes(std::span(surface.mesh.triangles)));
  hash.add(surface.clean ? std::string_view("pseudo-normals") : std::string_view("winding number"));
  return hash.hex_digest();
}

void save_field(const CubicField& field, const std::string& digest, const std::filesystem::path& path) {
  FieldHeader header =
      header_of(field.shape(), {field.precision(), field.band() ? field.band()->width_m() : 0.0}, digest);
  header.facts = field.facts();
  std::vector<std::span<const std::byte>> parts;
  const auto add = [&](const auto& range) { parts.push_back(std::as_bytes(std::span(range))); };
  if (field.band()) {
    for_each_part_of_band(*field.band(), add);
  }
  for_each_part(field, add);
  write_sealed(path, header, parts);
}

std::optional<CubicField> load_field(const std::filesystem::path& path, const std::string& digest,
                                     const GridShape& shape, const FieldSettings& settings) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return std::nullopt;
  }
  SealedReader<FieldHeader> in(path);
  if (const std::string difference = first_difference(in.header(), header_of(shape, settings, digest));
      !difference.empty()) {
    in.refuse(difference);
  }
  const auto read = [&](auto& range) { in.read_into(range); };
  std::optional<NarrowBand> band;
  if (settings.band_m) {
    band.emplace(shape, *settings.band_m);
    for_each_part_of_band(*band, read);
    band->index_records(shape);
  }
  CubicField field =
      band ? CubicField(shape, settings.precision, *std::move(band)) : CubicField(shape, settings.precision);
  for_each_part(field, read);
  field.facts() = in.header().facts;
  in.require_intact();
  return field;
}

}  // namespace musclebench

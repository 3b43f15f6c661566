#include "backends/sdf/octree_file.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "backends/sdf/atomic_file.hpp"
#include "core/base/input_error.hpp"
#include "core/base/sha256.hpp"

namespace musclebench {

namespace {

using Digest = std::array<char, 64>;

/// Raise when the meaning of the bytes changes, or what the builder makes of the same settings.
constexpr std::uint32_t format_version = 1;
constexpr std::uint32_t byte_order_mark = 0x01020304;
constexpr std::array<char, 8> magic{'M', 'B', 'O', 'C', 'T', 'R', 'E', 'E'};

struct Header {
  std::array<char, 8> name = magic;
  std::uint32_t byte_order = byte_order_mark;
  std::uint32_t version = format_version;
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
  Digest surface{};
  Digest content{};  ///< of the header with this field zero, the entries and the coefficients
};
static_assert(sizeof(OctreeQuality) == 9 * 8);
static_assert(sizeof(Header) == 16 + 24 + 32 + 16 + sizeof(OctreeQuality) + 16 + 128,
              "written as it stands: there must be no padding");

Digest as_digest(const std::string& text) {
  Digest digest{};
  std::copy_n(text.begin(), std::min(text.size(), digest.size()), digest.begin());
  return digest;
}

Header header_of(const std::string& digest, const OctreeSettings& settings) {
  Header header;
  header.wanted_m = settings.max_error_m;
  header.wanted_near_m = settings.near_m;
  header.margin = settings.margin;
  header.surface = as_digest(digest);
  return header;
}

Digest content_digest(Header header, std::span<const std::uint32_t> entries, std::span<const float> coefficients) {
  header.content.fill('\0');
  Sha256 hash;
  hash.add(std::as_bytes(std::span(&header, 1)));
  hash.add(std::as_bytes(entries));
  hash.add(std::as_bytes(coefficients));
  return as_digest(hash.hex_digest());
}

std::string first_difference(const Header& found, const Header& wanted) {
  if (found.name != wanted.name) {
    return "is not an adaptive field's file";
  }
  if (found.byte_order != wanted.byte_order) {
    return "was written on a machine of another byte order";
  }
  if (found.version != wanted.version) {
    return fmt::format("has format version {}, this program reads {}", found.version, wanted.version);
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

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& reason) {
  throw InputError(path.string(), reason + "; remove the file or name another folder in `structures`");
}

}  // namespace

void save_octree(const OctreeField& field, const std::string& digest, const OctreeSettings& settings,
                 const std::filesystem::path& path) {
  Header header = header_of(digest, settings);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.lower_m[axis] = field.shape().lower_m[static_cast<Eigen::Index>(axis)];
  }
  header.root_edge_m = field.shape().root_edge_m;
  header.roots = field.shape().roots;
  header.quality = field.quality();
  header.entries = field.entries().size();
  header.coefficients = field.coefficients().size();
  header.content = content_digest(header, field.entries(), field.coefficients());
  write_atomically(path, [&](std::ostream& out) {
    const auto write = [&](std::span<const std::byte> bytes) {
      out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    };
    write(std::as_bytes(std::span(&header, 1)));
    write(std::as_bytes(std::span(field.entries())));
    write(std::as_bytes(std::span(field.coefficients())));
  });
}

std::optional<OctreeField> load_octree(const std::filesystem::path& path, const std::string& digest,
                                       const OctreeSettings& settings) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return std::nullopt;
  }
  std::ifstream in(path, std::ios::binary);
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  const auto read = [&](std::span<std::byte> bytes) {
    return static_cast<bool>(
        in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())));
  };
  Header found;
  const bool header_read = !error && read(std::as_writable_bytes(std::span(&found, 1)));
  if (!header_read) {
    refuse(path, in.is_open() ? "is too short for a field file" : "cannot be read");
  }
  if (const std::string difference = first_difference(found, header_of(digest, settings)); !difference.empty()) {
    refuse(path, difference);
  }
  const std::uintmax_t values = (size - sizeof(Header)) / sizeof(float);
  if (found.entries > values || found.coefficients > values - found.entries) {
    refuse(path, "is truncated");
  }
  if (size != sizeof(Header) + (found.entries + found.coefficients) * sizeof(float)) {
    refuse(path, "goes on after its end");
  }
  std::vector<std::uint32_t> entries(found.entries);
  std::vector<float> coefficients(found.coefficients);
  if (!read(std::as_writable_bytes(std::span(entries))) || !read(std::as_writable_bytes(std::span(coefficients)))) {
    refuse(path, "cannot be read");
  }
  if (content_digest(found, entries, coefficients) != found.content) {
    refuse(path, "is damaged: its checksum does not fit");
  }
  OctreeShape shape{{found.lower_m[0], found.lower_m[1], found.lower_m[2]}, found.root_edge_m, found.roots};
  return OctreeField(shape, found.quality, std::move(entries), std::move(coefficients));
}

}  // namespace musclebench

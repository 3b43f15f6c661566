#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <initializer_list>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/mesh_files/polygon_mesh.hpp"

namespace musclebench {

namespace {

/// The vertex index of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`: counted from 1, or backwards from the last vertex.
double obj_index(const TextLines& lines, std::string_view corner, std::size_t vertices) {
  const std::string_view word = corner.substr(0, corner.find('/'));
  long long index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  if (error != std::errc() || end != word.data() + word.size() || index == 0) {
    lines.fail("holds a face corner that is no vertex number; the file is broken");
  }
  const long long from_zero = index > 0 ? index - 1 : static_cast<long long>(vertices) + index;
  if (from_zero < 0) {
    lines.fail("has a face that refers to a vertex before the first; export the mesh anew");
  }
  return static_cast<double>(from_zero);
}

PolygonMesh parse_binary_stl(std::string_view text, std::size_t facets, const std::string& location) {
  PolygonMeshBuilder builder(location);
  constexpr std::size_t header_bytes = 84;
  constexpr std::size_t facet_bytes = 50;
  for (std::size_t facet = 0; facet < facets; ++facet) {
    float values[12];  // the normal, then three corners
    std::memcpy(values, text.data() + header_bytes + facet * facet_bytes, sizeof(values));
    builder.begin_polygon();
    for (int k = 1; k <= 3; ++k) {
      builder.add_vertex(Vec3(values[3 * k], values[3 * k + 1], values[3 * k + 2]));
      builder.add_corner(3.0 * static_cast<double>(facet) + k - 1);
    }
    builder.end_polygon();
  }
  return builder.finish();
}

/// Vertices of these kinds begin with x y z; colours, normals and texture coordinates behind them are left out.
void require_plain_off(const TextLines& lines) {
  const std::string_view kind = lines.words()[0];
  if (kind != "OFF" && kind != "COFF" && kind != "NOFF" && kind != "CNOFF" && kind != "STOFF") {
    lines.fail("names a kind of OFF that is not supported; write plain OFF");
  }
  if (lines.words().size() > 1 && lines.words()[1] == "BINARY") {
    lines.fail("announces binary OFF, which is not supported; write OFF as text, or PLY");
  }
}

/// The next line must begin with `words`.
void expect_line(TextLines& lines, std::initializer_list<std::string_view> words) {
  const bool is_there = lines.next_filled(false) && lines.words().size() >= words.size();
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!is_there || lower_case(lines.words()[i]) != words.begin()[i]) {
      lines.fail(fmt::format("is not '{}' as it should be; the file is cut off or broken", fmt::join(words, " ")));
    }
  }
}

PolygonMesh parse_ascii_stl(std::string_view text, const std::string& location) {
  PolygonMeshBuilder builder(location);
  TextLines lines(text, location);
  double corners = 0;
  bool in_solid = false;
  while (lines.next_filled(false)) {
    const std::string word = lower_case(lines.words()[0]);
    if (word == (in_solid ? "endsolid" : "solid")) {
      in_solid = !in_solid;
      continue;
    }
    if (!in_solid || word != "facet") {
      lines.fail("is not 'facet', 'solid' or 'endsolid' where one belongs; the file is broken");
    }
    expect_line(lines, {"outer", "loop"});
    builder.begin_polygon();
    for (int k = 0; k < 3; ++k) {
      expect_line(lines, {"vertex"});
      builder.add_vertex(lines.vector(1));
      builder.add_corner(corners++);
    }
    builder.end_polygon();
    expect_line(lines, {"endloop"});
    expect_line(lines, {"endfacet"});
  }
  if (in_solid) {
    throw InputError(location, "ends before its 'endsolid'; the file is cut off, copy or export it anew");
  }
  return builder.finish();
}

void require_text(std::string_view text, std::string_view format, const std::string& location) {
  if (text.find('\0') != std::string_view::npos) {
    throw InputError(location, fmt::format("is no text, so it is no {} file; check the file's ending", format));
  }
}

/// `solid` begins a text; its binary sibling tells its own size.
bool begins_as_ascii_stl(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  return lower_case(text.substr(begin, 5)) == "solid" && text.find('\0') == std::string_view::npos;
}

std::uint32_t binary_stl_facets(std::string_view text) {
  std::uint32_t facets = 0;
  if (text.size() >= 84) {
    std::memcpy(&facets, text.data() + 80, sizeof(facets));
  }
  return facets;
}

/// Binary files may begin with "solid", too: only their size tells.
bool is_binary_stl(std::string_view text, std::uintmax_t file_bytes) {
  return text.size() >= 84 && file_bytes == 84 + 50 * static_cast<std::uintmax_t>(binary_stl_facets(text));
}

[[noreturn]] void refuse_stl(std::string_view text, std::uintmax_t file_bytes, const std::string& location) {
  const std::uintmax_t facets = binary_stl_facets(text);
  throw InputError(location,
                   fmt::format("is neither an STL text nor a binary STL file ({} bytes, where the {} facets that its "
                               "header promises take {}); copy or export it anew",
                               file_bytes, facets, 84 + 50 * facets));
}

}  // namespace

void require_obj_head(const FileHead& head, const std::string& location) {
  require_text(head.bytes, "OBJ", location);
  const bool has_vertex = head.bytes.starts_with("v ") || head.bytes.find("\nv ") != std::string::npos ||
                          head.bytes.find("\nv\t") != std::string::npos || head.bytes.find("\rv ") != std::string::npos;
  if (!has_vertex) {
    throw InputError(location, "has no vertex line ('v x y z') within its first megabyte; is it an OBJ file?");
  }
}

void require_off_head(const FileHead& head, const std::string& location) {
  require_text(head.bytes, "OFF", location);
  const std::string counts_only = head.bytes.substr(0, head.bytes.rfind('\n') + 1);
  TextLines lines(counts_only, location);
  if (lines.next_filled(true) && lines.words()[0].find("OFF") == std::string_view::npos) {
    (void)lines.count(0);
  }
}

void require_stl_head(const FileHead& head, const std::string& location) {
  if (!is_binary_stl(head.bytes, head.file_bytes) && !begins_as_ascii_stl(head.bytes)) {
    refuse_stl(head.bytes, head.file_bytes, location);
  }
}

PolygonMesh parse_obj(std::string_view text, const std::string& location) {
  require_text(text, "OBJ", location);
  PolygonMeshBuilder builder(location);
  TextLines lines(text, location);
  std::size_t vertices = 0;
  while (lines.next_filled(true)) {
    if (lines.words().back() == "\\" || lines.words().back().back() == '\\') {
      lines.fail("is continued on the next one, which is not supported; join them");
    }
    if (lines.words()[0] == "v") {
      const bool has_weight = lines.words().size() == 5 && lines.number(4) != 1;
      if (has_weight) {
        lines.fail("has a vertex with a weight other than 1, which is not supported; divide by it");
      }
      builder.add_vertex(lines.vector(1));
      ++vertices;
    } else if (lines.words()[0] == "f") {
      if (lines.words().size() < 4) {
        lines.fail("has a face of fewer than three corners; the file is cut off or broken");
      }
      builder.begin_polygon();
      for (std::size_t i = 1; i < lines.words().size(); ++i) {
        builder.add_corner(obj_index(lines, lines.words()[i], vertices));
      }
      builder.end_polygon();
    }
  }
  return builder.finish();
}

PolygonMesh parse_off(std::string_view text, const std::string& location) {
  TextLines lines(text, location);
  if (!lines.next_filled(true)) {
    throw InputError(location, "holds no text; export the mesh anew");
  }
  std::size_t word = 0;  // where the counts begin: the header's own line may hold them, and may be left out
  if (lines.words()[0].find("OFF") != std::string_view::npos) {
    require_plain_off(lines);
    word = lines.words().size() > 1 ? 1 : 0;
    if (word == 0 && !lines.next_filled(true)) {
      throw InputError(location, "ends within its header; the file is cut off, copy or export it anew");
    }
  }
  const std::size_t vertices = lines.count(word);
  const std::size_t faces = lines.count(word + 1);
  const auto next_line = [&](std::string_view what, std::size_t done, std::size_t promised) {
    if (!lines.next_filled(true)) {
      throw InputError(location, fmt::format("ends after {} of {} {}; the file is cut off, copy or export it anew",
                                             done, promised, what));
    }
  };
  PolygonMeshBuilder builder(location);
  for (std::size_t i = 0; i < vertices; ++i) {
    next_line("vertices", i, vertices);
    builder.add_vertex(lines.vector(0));
  }
  for (std::size_t i = 0; i < faces; ++i) {
    next_line("faces", i, faces);
    const std::size_t corners = lines.count(0);
    builder.begin_polygon();
    for (std::size_t k = 0; k < corners; ++k) {
      builder.add_corner(lines.number(k + 1));
    }
    builder.end_polygon();
  }
  return builder.finish();
}

PolygonMesh parse_stl(std::string_view text, const std::string& location) {
  if (is_binary_stl(text, text.size())) {
    return parse_binary_stl(text, binary_stl_facets(text), location);
  }
  if (begins_as_ascii_stl(text)) {
    return parse_ascii_stl(text, location);
  }
  refuse_stl(text, text.size(), location);
}

}  // namespace musclebench

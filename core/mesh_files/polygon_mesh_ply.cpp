#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "core/mesh_files/polygon_mesh.hpp"

namespace musclebench {

namespace {

enum class Encoding { ascii, little_endian, big_endian };
enum class Scalar { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Scalar type = Scalar::float32;
  bool is_list = false;
  Scalar count_type = Scalar::uint8;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::string_view body;
  std::size_t lines = 0;
};

constexpr std::array<std::pair<std::string_view, Scalar>, 16> scalar_names = {{{"char", Scalar::int8},
                                                                               {"int8", Scalar::int8},
                                                                               {"uchar", Scalar::uint8},
                                                                               {"uint8", Scalar::uint8},
                                                                               {"short", Scalar::int16},
                                                                               {"int16", Scalar::int16},
                                                                               {"ushort", Scalar::uint16},
                                                                               {"uint16", Scalar::uint16},
                                                                               {"int", Scalar::int32},
                                                                               {"int32", Scalar::int32},
                                                                               {"uint", Scalar::uint32},
                                                                               {"uint32", Scalar::uint32},
                                                                               {"float", Scalar::float32},
                                                                               {"float32", Scalar::float32},
                                                                               {"double", Scalar::float64},
                                                                               {"float64", Scalar::float64}}};

std::size_t scalar_bytes(Scalar type) {
  constexpr std::array<std::size_t, 8> bytes = {1, 1, 2, 2, 4, 4, 4, 8};
  return bytes[static_cast<std::size_t>(type)];
}

Scalar parse_scalar(const TextLines& lines, std::size_t word) {
  const auto found = std::find_if(scalar_names.begin(), scalar_names.end(),
                                  [&](const auto& entry) { return entry.first == lines.words()[word]; });
  if (found == scalar_names.end()) {
    lines.fail("names an unknown type of number; the header is broken");
  }
  return found->second;
}

Encoding parse_encoding(const TextLines& lines) {
  const std::string_view name = lines.words().size() > 1 ? lines.words()[1] : "";
  if (name == "ascii") {
    return Encoding::ascii;
  }
  if (name == "binary_little_endian" || name == "binary_big_endian") {
    return name == "binary_big_endian" ? Encoding::big_endian : Encoding::little_endian;
  }
  lines.fail("names no known format (ascii, binary_little_endian or binary_big_endian); the header is broken");
}

Property parse_property(const TextLines& lines) {
  const std::vector<std::string_view>& words = lines.words();
  Property property;
  property.is_list = words.size() == 5 && words[1] == "list";
  if (!property.is_list && words.size() != 3) {
    lines.fail("is no complete property; the header is broken");
  }
  if (property.is_list) {
    property.count_type = parse_scalar(lines, 2);
  }
  property.type = parse_scalar(lines, words.size() - 2);
  property.name = words.back();
  return property;
}

/// The end of the header: where the body begins. 0 where there is none within the first bytes, as in garbage.
std::size_t find_body(std::string_view text) {
  constexpr std::string_view last_word = "\nend_header";
  constexpr std::size_t longest_header = 1 << 19;  // less than what a FileHead holds
  const std::size_t found = text.substr(0, longest_header).find(last_word);
  if (found == std::string_view::npos) {
    return 0;
  }
  const std::size_t line_end = text.find('\n', found + last_word.size());
  return line_end == std::string_view::npos ? text.size() : line_end + 1;
}

Header parse_header(std::string_view text, const std::string& location) {
  const std::size_t body = find_body(text);
  if (text.substr(0, 3) != "ply" || body == 0) {
    throw InputError(location,
                     "has no complete PLY header ('ply' to 'end_header'); check the file's ending or export it anew");
  }
  Header header;
  header.body = text.substr(body);
  TextLines lines(text.substr(0, body), location);
  bool has_format = false;
  while (lines.next(false)) {
    ++header.lines;
    const std::vector<std::string_view>& words = lines.words();
    if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info" ||
        words[0] == "end_header") {
      continue;
    }
    if (words[0] == "format") {
      header.encoding = parse_encoding(lines);
      has_format = true;
    } else if (words[0] == "element" && words.size() == 3) {
      header.elements.push_back({std::string(words[1]), lines.count(2), {}});
    } else if (words[0] == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(parse_property(lines));
    } else {
      lines.fail("is not understood; the header is broken");
    }
  }
  if (!has_format) {
    throw InputError(location, "has no format line in its header; export it anew");
  }
  return header;
}

/// Hands out the numbers of the body one by one.
class Body {
 public:
  Body(const Header& header, const std::string& location)
      : m_encoding(header.encoding),
        m_rest(header.body),
        m_lines(header.body, location, header.lines),
        m_location(location) {}

  void begin_instance(const Element& element, std::size_t index) {
    m_element = &element;
    m_index = index;
    m_word = 0;
    if (m_encoding == Encoding::ascii && !element.properties.empty() && !m_lines.next_filled(false)) {
      fail_cut_off();
    }
  }

  double next(Scalar type) {
    if (m_encoding == Encoding::ascii) {
      if (m_word >= m_lines.words().size()) {
        throw InputError(m_location,
                         fmt::format("{} {} (counted from 0) has too few numbers; the file is cut off or broken",
                                     m_element->name, m_index));
      }
      return m_lines.number(m_word++);
    }
    const std::size_t bytes = scalar_bytes(type);
    if (m_rest.size() < bytes) {
      fail_cut_off();
    }
    std::array<char, 8> raw{};
    std::copy_n(m_rest.begin(), bytes, raw.begin());
    m_rest.remove_prefix(bytes);
    if ((m_encoding == Encoding::big_endian) != (std::endian::native == std::endian::big)) {
      for (std::size_t i = 0; i < bytes / 2; ++i) {
        std::swap(raw[i % raw.size()], raw[(bytes - 1 - i) % raw.size()]);  // % tells GCC 12 that both are in range
      }
    }
    return convert(raw, type);
  }

 private:
  template <typename T>
  static double as(const std::array<char, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof(value));
    return static_cast<double>(value);
  }

  static double convert(const std::array<char, 8>& raw, Scalar type) {
    switch (type) {
      case Scalar::int8:
        return as<std::int8_t>(raw);
      case Scalar::uint8:
        return as<std::uint8_t>(raw);
      case Scalar::int16:
        return as<std::int16_t>(raw);
      case Scalar::uint16:
        return as<std::uint16_t>(raw);
      case Scalar::int32:
        return as<std::int32_t>(raw);
      case Scalar::uint32:
        return as<std::uint32_t>(raw);
      case Scalar::float32:
        return as<float>(raw);
      case Scalar::float64:
        break;
    }
    return as<double>(raw);
  }

  [[noreturn]] void fail_cut_off() const {
    throw InputError(m_location,
                     fmt::format("ends after {} of {} elements '{}'; the file is cut off, copy or export it anew",
                                 m_index, m_element->count, m_element->name));
  }

  Encoding m_encoding;
  std::string_view m_rest;
  TextLines m_lines;
  std::size_t m_word = 0;
  const Element* m_element = nullptr;
  std::size_t m_index = 0;
  const std::string& m_location;
};

/// Where x, y and z stand among the properties.
std::array<std::size_t, 3> find_coordinates(const Element& element, const std::string& location) {
  std::array<std::size_t, 3> columns{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto found =
        std::find_if(element.properties.begin(), element.properties.end(), [&](const Property& property) {
          return !property.is_list && property.name == std::string_view("xyz").substr(axis, 1);
        });
    if (found == element.properties.end()) {
      throw InputError(location, "has vertices without x, y and z; export the mesh anew");
    }
    columns[axis] = static_cast<std::size_t>(found - element.properties.begin());
  }
  return columns;
}

std::size_t list_length(Body& body, const Property& property, const std::string& location) {
  const double length = body.next(property.count_type);
  constexpr double longest_list = 2147483646.0;
  if (!(length >= 0 && length <= longest_list && length == std::floor(length))) {
    throw InputError(location, fmt::format("has a list '{}' of {} entries; the file is broken", property.name, length));
  }
  return static_cast<std::size_t>(length);
}

void read_vertices(Body& body, const Element& element, PolygonMeshBuilder& builder, const std::string& location) {
  const std::array<std::size_t, 3> coordinates = find_coordinates(element, location);
  for (std::size_t i = 0; i < element.count; ++i) {
    body.begin_instance(element, i);
    Vec3 vertex = Vec3::Zero();
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      for (std::size_t n = property.is_list ? list_length(body, property, location) : 1; n > 0; --n) {
        const double value = body.next(property.type);
        for (int axis = 0; axis < 3; ++axis) {
          vertex[axis] = p == coordinates[static_cast<std::size_t>(axis)] ? value : vertex[axis];
        }
      }
    }
    builder.add_vertex(vertex);
  }
}

/// Reads the list of vertex indices of every instance; other elements have none and are passed over.
void read_others(Body& body, const Element& element, PolygonMeshBuilder& builder, const std::string& location) {
  const bool is_face = element.name == "face";
  for (std::size_t i = 0; i < element.count && !element.properties.empty(); ++i) {
    body.begin_instance(element, i);
    if (is_face) {
      builder.begin_polygon();
    }
    for (const Property& property : element.properties) {
      const bool is_corners =
          is_face && property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
      for (std::size_t n = property.is_list ? list_length(body, property, location) : 1; n > 0; --n) {
        const double value = body.next(property.type);
        if (is_corners) {
          builder.add_corner(value);
        }
      }
    }
    if (is_face) {
      builder.end_polygon();
    }
  }
}

}  // namespace

void require_ply_head(const FileHead& head, const std::string& location) { (void)parse_header(head.bytes, location); }

PolygonMesh parse_ply(std::string_view text, const std::string& location) {
  const Header header = parse_header(text, location);
  Body body(header, location);
  PolygonMeshBuilder builder(location);
  for (const Element& element : header.elements) {
    constexpr std::size_t least_bytes = 3;  // of a vertex or a face: no more is believed than the file can hold
    const std::size_t count = std::min(element.count, header.body.size() / least_bytes);
    if (element.name == "vertex") {
      builder.reserve_vertices(count);
      read_vertices(body, element, builder, location);
    } else {
      if (element.name == "face") builder.reserve_triangles(count);
      read_others(body, element, builder, location);
    }
  }
  return builder.finish();
}

}  // namespace musclebench

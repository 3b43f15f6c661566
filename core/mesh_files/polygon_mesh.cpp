#include "core/mesh_files/polygon_mesh.hpp"

#include <algorithm>
#include <charconv>

namespace musclebench {

void PolygonMeshBuilder::end_polygon() {
  if (m_mesh.corners.size() - m_begin < 3) {
    m_mesh.corners.resize(m_begin);
  } else {
    m_mesh.first_corner.push_back(static_cast<int>(m_begin));
    m_face_of_polygon.push_back(m_faces);
  }
  ++m_faces;
}

PolygonMesh PolygonMeshBuilder::finish() {
  const int vertices = static_cast<int>(m_mesh.vertices.size());
  for (int polygon = 0; polygon < m_mesh.polygons(); ++polygon) {
    for (int corner = m_mesh.first_corner[polygon]; corner < m_mesh.end_corner(polygon); ++corner) {
      if (m_mesh.corners[corner] >= vertices) {
        throw InputError(m_location,
                         fmt::format("face {} refers to vertex {} (both counted from 0), but there are only {} "
                                     "vertices; export the mesh anew",
                                     m_face_of_polygon[polygon], m_mesh.corners[corner], vertices));
      }
    }
  }
  return std::move(m_mesh);
}

bool TextLines::next(bool has_comments) {
  m_words.clear();
  if (m_text.empty()) {
    return false;
  }
  ++m_line;
  const std::size_t end = std::min(m_text.find_first_of("\r\n"), m_text.size());
  std::string_view line = m_text.substr(0, end);
  const bool has_two_ends = m_text.substr(end, 2) == "\r\n";
  m_text.remove_prefix(std::min(end + (has_two_ends ? 2 : 1), m_text.size()));
  if (has_comments) {
    line = line.substr(0, line.find('#'));
  }
  constexpr std::string_view blanks = " \t\v\f";
  for (std::size_t from = line.find_first_not_of(blanks); from < line.size();
       from = line.find_first_not_of(blanks, from)) {
    const std::size_t to = std::min(line.find_first_of(blanks, from), line.size());
    m_words.push_back(line.substr(from, to - from));
    from = to;
  }
  return true;
}

bool TextLines::next_filled(bool has_comments) {
  while (next(has_comments)) {
    if (!m_words.empty()) {
      return true;
    }
  }
  return false;
}

double TextLines::number(std::size_t i) const {
  if (i >= m_words.size()) {
    fail("has too few numbers; the file is cut off or broken");
  }
  std::string_view word = m_words[i];
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') {
    word.remove_prefix(1);
  }
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  // Too small for a double is as good as zero, which from_chars leaves in `value`; too large is no coordinate.
  const bool is_tiny = error == std::errc::result_out_of_range && word.find("e-") != std::string_view::npos;
  if ((error != std::errc() && !is_tiny) || end != word.data() + word.size()) {
    fail(fmt::format("holds no number at word {}; the file is broken", i + 1));
  }
  return value;
}

std::size_t TextLines::count(std::size_t i) const {
  constexpr double largest_count = 2147483646.0;
  const double value = number(i);
  if (!(value >= 0 && value <= largest_count && value == std::floor(value))) {
    fail("holds no count of vertices or faces where one belongs; the file is broken");
  }
  return static_cast<std::size_t>(value);
}

void TextLines::fail(std::string_view problem) const {
  throw InputError(m_location, fmt::format("line {} {}", m_line, problem));
}

std::string lower_case(std::string_view word) {
  std::string lower(word);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return lower;
}

}  // namespace musclebench

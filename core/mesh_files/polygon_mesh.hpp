#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "core/base/input_error.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace musclebench {

/// What a mesh file says: vertices and polygons of three corners or more, in the order of the file.
struct PolygonMesh {
  std::vector<Vec3> vertices;
  std::vector<int> corners;       ///< vertex indices, polygon after polygon
  std::vector<int> first_corner;  ///< of each polygon in `corners`

  [[nodiscard]] int polygons() const { return static_cast<int>(first_corner.size()); }
  [[nodiscard]] int end_corner(int polygon) const {
    return polygon + 1 < polygons() ? first_corner[polygon + 1] : static_cast<int>(corners.size());
  }
};

/// Strict readers of the text of a file: what is cut off, out of range or not a number throws InputError that begins
/// with `location`. assimp 5.2.5 is too lenient for measurements: it splits the vertices of OBJ, holds 32-bit floats,
/// bends indices that are out of range to the last vertex and fills what is cut off with zeros (OFF), and never returns
/// from some broken headers (PLY).
PolygonMesh parse_ply(std::string_view text, const std::string& location);  ///< ASCII and binary of both byte orders
PolygonMesh parse_obj(std::string_view text, const std::string& location);  ///< `v` and `f` lines
PolygonMesh parse_off(std::string_view text, const std::string& location);  ///< OFF, COFF, NOFF, STOFF as text
PolygonMesh parse_stl(std::string_view text, const std::string& location);  ///< ASCII and binary; one vertex a corner

/// The beginning of a file that is too large to be read for nothing.
struct FileHead {
  std::string bytes;
  std::uintmax_t file_bytes = 0;
};

/// Throw InputError for what the head already tells to be no file of that format. `parse_...` checks the rest.
void require_ply_head(const FileHead& head, const std::string& location);
void require_obj_head(const FileHead& head, const std::string& location);
void require_off_head(const FileHead& head, const std::string& location);
void require_stl_head(const FileHead& head, const std::string& location);

/// Builds a PolygonMesh and checks what goes in.
class PolygonMeshBuilder {
 public:
  explicit PolygonMeshBuilder(const std::string& location) : m_location(location) {}

  /// Where a file tells its sizes: a list that doubles as it grows touches three times its memory.
  void reserve_vertices(std::size_t vertices) { m_mesh.vertices.reserve(vertices); }
  void reserve_triangles(std::size_t triangles) {
    m_mesh.corners.reserve(3 * triangles);
    m_mesh.first_corner.reserve(triangles);
    m_face_of_polygon.reserve(triangles);
  }

  void add_vertex(const Vec3& vertex) {
    // Beyond the range of floats squares and products overflow, so that is no coordinate either; a NaN fails, too.
    if (!(vertex.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= std::numeric_limits<float>::max())) {
      throw InputError(m_location, fmt::format("vertex {} (counted from 0) is not finite; export the mesh anew",
                                               m_mesh.vertices.size()));
    }
    m_mesh.vertices.push_back(vertex);
  }

  void begin_polygon() { m_begin = m_mesh.corners.size(); }
  void add_corner(double index) {
    constexpr double largest_index = 2147483646.0;
    if (!(index >= 0 && index <= largest_index && index == std::floor(index))) {
      throw InputError(m_location, fmt::format("face {} (counted from 0) has the vertex index {}; export the mesh anew",
                                               m_faces, index));
    }
    m_mesh.corners.push_back(static_cast<int>(index));
    if (m_mesh.corners.size() - m_begin > most_corners) {
      throw InputError(
          m_location, fmt::format("face {} (counted from 0) has more than {} corners; split it into triangles", m_faces,
                                  most_corners));
    }
  }
  /// Faces of one or two corners are points and lines: they count, but bound nothing and are left out.
  void end_polygon();

  /// Checks all indices against the number of vertices.
  PolygonMesh finish();

 private:
  /// Cutting a polygon takes the square of its corners; of a spiral, more.
  static constexpr std::size_t most_corners = 1000;

  const std::string& m_location;
  PolygonMesh m_mesh;
  std::size_t m_begin = 0;
  std::size_t m_faces = 0;
  std::vector<std::size_t> m_face_of_polygon;  ///< its number in the file, for messages
};

/// The triangles of the polygons, in their order; a triangle is taken as it is. Larger ones are cut so that concave
/// ones are right, too; one that can't be cut (no area, or crossing itself) becomes a fan. assimp is not asked: it
/// aborts the program on some polygons.
std::vector<Triangle> split_into_triangles(const PolygonMesh& mesh);

/// Hands out the lines of a text, and each line's words.
class TextLines {
 public:
  /// `lines_before`: how many lines of the file come before `text`, for messages.
  TextLines(std::string_view text, const std::string& location, std::size_t lines_before = 0)
      : m_text(text), m_location(location), m_line(lines_before) {}

  /// The next line without its end, from '#' on cut off where `has_comments`; false at the end of the text.
  bool next(bool has_comments);
  /// The next line that holds a word.
  bool next_filled(bool has_comments);

  [[nodiscard]] const std::vector<std::string_view>& words() const { return m_words; }
  /// Word `i` as a number. Throws where there is no such word or it is no number.
  [[nodiscard]] double number(std::size_t i) const;
  [[nodiscard]] Vec3 vector(std::size_t i) const { return {number(i), number(i + 1), number(i + 2)}; }
  /// Word `i` as a count of things, at most 2^31 - 2.
  [[nodiscard]] std::size_t count(std::size_t i) const;

  /// Throws InputError with the line's number.
  [[noreturn]] void fail(std::string_view problem) const;

 private:
  std::string_view m_text;
  const std::string& m_location;
  std::vector<std::string_view> m_words;
  std::size_t m_line;
};

/// The word in lower case.
std::string lower_case(std::string_view word);

}  // namespace musclebench

#include "backends/sdf/field_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <fmt/format.h>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

/// Rows of the grid that one thread takes at a time, along y and z. Fixed, so that the closest triangles that searches
/// start from, and with them the last bits of the result, do not depend on the number of threads.
constexpr std::size_t chunk_rows = 4;

/// Along one axis; what `cells` allows, too.
constexpr double most_cells = 4096;

/// The seven nodes of a record, in an order of short steps: up along x from its first to its last.
struct RecordNode {
  std::size_t offset;
  std::array<double, 3> thirds;
};
constexpr std::array<RecordNode, 7> path{
    {{4, {0, 0, 2}}, {3, {0, 0, 1}}, {1, {0, 1, 0}}, {2, {0, 2, 0}}, {0, {0, 0, 0}}, {5, {1, 0, 0}}, {6, {2, 0, 0}}}};

/// Walks over the nodes of one chunk and remembers the last one: its closest triangle starts the next search, and a
/// node that is farther from the surface than from a signed node lies on the same side.
class NodeWalk {
 public:
  NodeWalk(const SignedSurface& surface, const GridShape& shape, CubicField& field)
      : m_surface(surface), m_shape(shape), m_field(field) {}

  void visit(std::size_t i, std::size_t j, std::size_t k, const RecordNode& node) {
    const auto exists = [&](std::size_t axis, std::size_t index) {
      return node.thirds[axis] == 0 || index < m_shape.count(axis);
    };
    if (!exists(0, i) || !exists(1, j) || !exists(2, k)) {
      return;
    }
    const Vec3 cells(static_cast<double>(i) + node.thirds[0] / 3, static_cast<double>(j) + node.thirds[1] / 3,
                     static_cast<double>(k) + node.thirds[2] / 3);
    const Vec3 point = m_shape.lower_m + m_shape.cell_size_m.cwiseProduct(cells);
    m_field.store(m_shape.record(i, j, k) + node.offset, signed_distance(point));
  }

 private:
  double signed_distance(const Vec3& point) {
    const bool first = m_closest.triangle < 0;
    const ClosestPoint closest = first ? m_surface.tree().closest_point(point).value()
                                       : m_surface.tree().closest_point_from(point, m_closest.triangle);
    const double step = (point - m_point).norm() * (1 + 1e-9);
    if (first || std::max(closest.distance_m, m_closest.distance_m) <= step) {
      m_inside = m_surface.is_inside(point, closest);
    }
    m_closest = closest;
    m_point = point;
    return m_inside ? -closest.distance_m : closest.distance_m;
  }

  const SignedSurface& m_surface;
  const GridShape& m_shape;
  CubicField& m_field;
  ClosestPoint m_closest;
  Vec3 m_point = Vec3::Zero();
  bool m_inside = false;
};

/// There and back along the rows of one chunk.
void fill_chunk(const SignedSurface& surface, std::size_t first_j, std::size_t first_k, CubicField& field) {
  const GridShape& shape = field.shape();
  const std::size_t end_j = std::min(first_j + chunk_rows, shape.count(1) + 1);
  const std::size_t end_k = std::min(first_k + chunk_rows, shape.count(2) + 1);
  NodeWalk walk(surface, shape, field);
  bool forward = true;
  for (std::size_t k = first_k; k < end_k; ++k) {
    for (std::size_t step = first_j; step < end_j; ++step) {
      const std::size_t j = (k - first_k) % 2 == 0 ? step : first_j + end_j - 1 - step;
      for (std::size_t column = 0; column <= shape.count(0); ++column) {
        const std::size_t i = forward ? column : shape.count(0) - column;
        for (std::size_t n = 0; n < path.size(); ++n) {
          walk.visit(i, j, k, path[forward ? n : path.size() - 1 - n]);
        }
      }
      forward = !forward;
    }
  }
}

void fill(const SignedSurface& surface, CubicField& field, [[maybe_unused]] int threads) {
  const std::size_t across = field.shape().count(1) / chunk_rows + 1;
  const std::size_t chunks = across * (field.shape().count(2) / chunk_rows + 1);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    fill_chunk(surface, chunk_rows * (chunk % across), chunk_rows * (chunk / across), field);
  }
}

/// A face of the domain's border: the cell's place along the face's two axes, and where the cell itself stands.
struct BorderFace {
  std::size_t axis;
  int side;
  std::array<std::size_t, 3> cell;
};

std::vector<BorderFace> border_faces(const GridShape& shape) {
  std::vector<BorderFace> faces;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t p = (axis + 1) % 3;
    const std::size_t q = (axis + 2) % 3;
    for (const int side : {0, 1}) {
      for (std::size_t a = 0; a < shape.count(p); ++a) {
        for (std::size_t b = 0; b < shape.count(q); ++b) {
          std::array<std::size_t, 3> cell{};
          cell[axis] = side == 0 ? 0 : shape.count(axis) - 1;
          cell[p] = a;
          cell[q] = b;
          faces.push_back({axis, side, cell});
        }
      }
    }
  }
  return faces;
}

void straighten_edge(CubicField& field, std::array<std::size_t, 3> vertex, std::size_t axis) {
  static constexpr std::array<std::size_t, 3> first_offset{5, 1, 3};
  const GridShape& shape = field.shape();
  const std::size_t start = shape.record(vertex[0], vertex[1], vertex[2]);
  const double low = field.stored(start);
  ++vertex[axis];
  const double high = field.stored(shape.record(vertex[0], vertex[1], vertex[2]));
  field.store(start + first_offset[axis], low + (high - low) / 3);
  field.store(start + first_offset[axis] + 1, low + (high - low) * 2 / 3);
}

void straighten_face(CubicField& field, const BorderFace& face) {
  for (const std::size_t turn : {1, 2}) {
    const std::size_t along = (face.axis + turn) % 3;
    const std::size_t across = (face.axis + 3 - turn) % 3;
    for (const std::size_t far : {0, 1}) {
      std::array<std::size_t, 3> vertex = face.cell;
      vertex[face.axis] += static_cast<std::size_t>(face.side);
      vertex[across] += far;
      straighten_edge(field, vertex, along);
    }
  }
}

/// A straightened face shares edges with its neighbours, so the faces are looked at until nothing changes. Each is
/// straightened once at most.
void keep_border_positive(CubicField& field) {
  std::vector<BorderFace> curved = border_faces(field.shape());
  for (std::size_t before = curved.size() + 1; before != curved.size();) {
    before = curved.size();
    std::erase_if(curved, [&](const BorderFace& face) {
      const CubicCell cell = field.cell(face.cell[0], face.cell[1], face.cell[2]);
      const bool crosses = cell.lower_bound_on_face(face.axis, face.side) <= 0;
      if (crosses) {
        straighten_face(field, face);
      }
      return crosses;
    });
  }
}

bool may_be_negative(const CubicCell& cell) {
  // The bound is computed in floating point; this covers its rounding and that of the evaluation.
  double size = 0;
  for (const CubicCell::Along& along : cell.axis) {
    for (const CubicCell::Edges& values : {along.low, along.first, along.second, along.high}) {
      size = std::max(size, values.abs().maxCoeff());
    }
  }
  return cell.lower_bound() < 1e-12 * size;
}

void mark_negative_cells(CubicField& field, [[maybe_unused]] int threads) {
  const GridShape& shape = field.shape();
  const std::size_t plane = shape.count(0) * shape.count(1);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (std::size_t word = 0; word < shape.mask_words(); ++word) {
    std::uint64_t bits = 0;
    const std::size_t end = std::min(64 * (word + 1), shape.cell_count());
    for (std::size_t index = 64 * word; index < end; ++index) {
      const std::size_t in_plane = index % plane;
      const CubicCell cell = field.cell(in_plane % shape.count(0), in_plane / shape.count(0), index / plane);
      bits |= static_cast<std::uint64_t>(may_be_negative(cell)) << (index % 64);
    }
    field.mask()[word] = bits;
  }
}

}  // namespace

GridShape grid_over(const TriangleMesh& mesh, const GridSettings& settings, const std::string& bone_name) {
  Vec3 lower = mesh.vertices.front();
  Vec3 upper = lower;
  for (const Vec3& vertex : mesh.vertices) {
    lower = lower.cwiseMin(vertex);
    upper = upper.cwiseMax(vertex);
  }
  const Vec3 size = upper - lower;
  const double grown = settings.margin * size.norm();
  GridShape shape;
  if (settings.cell_size_m <= 0) {
    shape.cells.fill(settings.cells);
    shape.lower_m = lower - Vec3::Constant(grown);
    shape.cell_size_m = (size + Vec3::Constant(2 * grown)) / settings.cells;
    return shape;
  }
  const Vec3 wanted = ((size + Vec3::Constant(2 * grown)) / settings.cell_size_m).array().ceil().cwiseMax(1.0);
  if (settings.cell_size_m > size.maxCoeff() || wanted.maxCoeff() > most_cells) {
    throw InputError(fmt::format("sdf: cell_size_m ({})", bone_name),
                     fmt::format("{} gives {:.0f} cells along a bone of {:.3g} m; {:.2g} to {:.2g} makes sense",
                                 settings.cell_size_m, wanted.maxCoeff(), size.maxCoeff(), size.maxCoeff() / 256,
                                 size.maxCoeff() / 16));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    shape.cells[axis] = static_cast<std::int32_t>(wanted[static_cast<Eigen::Index>(axis)]);
  }
  shape.cell_size_m.setConstant(settings.cell_size_m);
  shape.lower_m = 0.5 * (lower + upper) - 0.5 * settings.cell_size_m * wanted;
  return shape;
}

CubicField build_field(const SignedSurface& surface, const GridShape& shape, FieldPrecision precision, int threads) {
  CubicField field(shape, precision);
  fill(surface, field, threads);
  keep_border_positive(field);
  mark_negative_cells(field, threads);
  return field;
}

FieldError estimate_error(const CubicField& field, const SignedSurface& surface, int samples, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const auto unit = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  const GridShape& shape = field.shape();
  const double reach = 2 * shape.cell_size_m.norm();
  FieldError result;
  std::vector<double> errors;
  // A surface fills enough of its own box for this many tries; the limit only keeps odd shapes from an endless loop.
  for (long tries = 0; std::ssize(errors) < samples && tries < 1000L * samples; ++tries) {
    const Vec3 share(unit(), unit(), unit());
    const Vec3 point = shape.lower_m + share.cwiseProduct(shape.upper_m() - shape.lower_m);
    const std::optional<double> exact = surface.distance(point, reach);
    const std::optional<double> approximate = field.value(point);
    if (!exact || !approximate) {
      continue;
    }
    errors.push_back(std::abs(*exact - *approximate));
    result.mean_m += errors.back();
    if ((*exact < 0) != (*approximate < 0)) {
      ++result.wrong_signs;
      result.deepest_wrong_sign_m = std::max(result.deepest_wrong_sign_m, std::abs(*exact));
    }
  }
  if (errors.empty()) {
    return result;
  }
  std::sort(errors.begin(), errors.end());
  result.samples = static_cast<int>(errors.size());
  result.largest_m = errors.back();
  result.p99_m = errors[static_cast<std::size_t>(0.99 * static_cast<double>(errors.size() - 1))];
  result.mean_m /= static_cast<double>(errors.size());
  return result;
}

}  // namespace musclebench

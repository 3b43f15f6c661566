#include "core/referee/referee_sign.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace musclebench {
namespace {

constexpr double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;

int sign_of(double value) { return (value > 0) - (value < 0); }

/// A sum without rounding: components that do not overlap, the smallest first (Shewchuk 1997, grow-expansion with zero
/// elimination: of points that lie on a plane or nearly so, few components are left at any time).
class ExactSum {
 public:
  void add(double value) {
    double carry = value;
    int kept = 0;
    for (int i = 0; i < m_size; ++i) {
      const double sum = carry + m_parts[i];
      const double virtual_part = sum - carry;
      const double rest = (carry - (sum - virtual_part)) + (m_parts[i] - virtual_part);
      if (rest != 0) m_parts[kept++] = rest;
      carry = sum;
    }
    assert(kept < static_cast<int>(m_parts.size()));
    if (carry != 0) m_parts[kept++] = carry;
    m_size = kept;
  }
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }
  void add_product(double a, double b, double c) {
    const double product = a * b;
    add_product(std::fma(a, b, -product), c);
    add_product(product, c);
  }
  [[nodiscard]] int sign() const { return m_size > 0 ? sign_of(m_parts[m_size - 1]) : 0; }

 private:
  std::array<double, 96> m_parts;  // the largest use: 24 triple products of 4 parts
  int m_size = 0;
};

/// The two coordinates that are left when one looks down an axis.
struct Flat {
  double x, y;
};

int exact_side(const Flat& a, const Flat& b, const Flat& p) {
  ExactSum sum;
  sum.add_product(a.x, b.y);
  sum.add_product(-a.x, p.y);
  sum.add_product(-p.x, b.y);
  sum.add_product(-a.y, b.x);
  sum.add_product(a.y, p.x);
  sum.add_product(p.y, b.x);
  return sum.sign();
}

/// On which side of the directed line a -> b the point p lies (+1 left, -1 right), p moved by (e, e^2) for an
/// infinitesimal e. 0 only where a = b. Swapping a and b swaps the sign exactly, as every step is antisymmetric.
int side(const Flat& a, const Flat& b, const Flat& p) {
  const double left = (a.x - p.x) * (b.y - p.y);
  const double right = (a.y - p.y) * (b.x - p.x);
  const double determinant = left - right;
  const double error = 4 * unit_roundoff * (std::abs(left) + std::abs(right));
  if (std::abs(determinant) > error) return sign_of(determinant);
  const int exact = exact_side(a, b, p);
  if (exact != 0) return exact;
  return b.y != a.y ? sign_of(a.y - b.y) : sign_of(b.x - a.x);
}

/// A vector by its part across a ray and r cot(t / 2), r being the length of that part and t the vector's angle from
/// the direction opposite to the ray. The half-angle formula for the area of a spherical triangle takes no more.
struct AxialView {
  Flat flat;
  double half_cosine;
};

AxialView view_along(const Vec3& vector, AxisRay ray) {
  AxialView view{{vector[(ray.axis + 1) % 3], vector[(ray.axis + 2) % 3]}, 0};
  const double behind = ray.upwards ? -vector[ray.axis] : vector[ray.axis];
  const double squared = view.flat.x * view.flat.x + view.flat.y * view.flat.y;
  const double length = std::sqrt(squared + behind * behind);
  // The sum would cancel where the vector points along the ray.
  view.half_cosine = behind >= 0 ? length + behind : squared / (length - behind);
  // Straight ahead: where the infinitesimal movement of `side` puts it.
  if (squared == 0 && behind < 0) view.flat.x = -1;
  return view;
}

/// A value in two doubles, the second below the rounding of the first (Dekker 1971): relative errors of an operation
/// are a few times 2^-106.
struct DoubleDouble {
  double high = 0;
  double low = 0;
};

DoubleDouble exact_sum(double a, double b) {
  const double sum = a + b;
  const double virtual_part = sum - a;
  return {sum, (a - (sum - virtual_part)) + (b - virtual_part)};
}

DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const double product = a.high * b.high;
  const double rest = std::fma(a.high, b.high, -product) + (a.high * b.low + a.low * b.high);
  return exact_sum(product, rest);
}

DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble high = exact_sum(a.high, -b.high);
  const DoubleDouble low = exact_sum(a.low, -b.low);
  const DoubleDouble sum = exact_sum(high.high, high.low + low.high);
  return exact_sum(sum.high, sum.low + low.low);
}

using DoubleDoubles = std::array<DoubleDouble, 3>;

DoubleDoubles difference(const Vec3& a, const Vec3& b) {
  return {exact_sum(a.x(), -b.x()), exact_sum(a.y(), -b.y()), exact_sum(a.z(), -b.z())};
}

/// Of the determinant of three differences, whose products sum to `magnitude` in size; 0 where two doubles cannot tell.
/// They can for points that rounding has moved off a plane; of points that lie on it the exact sum decides.
int double_double_sign(const DoubleDoubles& u, const DoubleDoubles& v, const DoubleDoubles& w, double magnitude) {
  DoubleDouble determinant;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    const DoubleDouble part = u[i] * (v[j] * w[k] - v[k] * w[j]);
    determinant = determinant - DoubleDouble{-part.high, -part.low};
  }
  // Ten operations, each with less than eight units of rounding, 2^-106.
  return std::abs(determinant.high) > 0x1p-98 * magnitude ? sign_of(determinant.high) : 0;
}

/// Adds the six signed triple products of det(u, v, w), times `factor` (+-1).
void add_determinant(ExactSum& sum, const Vec3& u, const Vec3& v, const Vec3& w, double factor) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    sum.add_product(factor * u[i], v[j], w[k]);
    sum.add_product(-factor * u[i], v[k], w[j]);
  }
}

int exact_plane_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  ExactSum sum;
  add_determinant(sum, a, b, c, -1);
  add_determinant(sum, p, b, c, 1);
  add_determinant(sum, a, p, c, 1);
  add_determinant(sum, a, b, p, 1);
  return sum.sign();
}

/// On which side of the edge a -> b the directed line from -> to passes. Swapping a and b swaps the sign, also where
/// the line meets the edge.
int edge_side(const Vec3& from, const Vec3& to, const Vec3& a, const Vec3& b) {
  const bool swapped = std::lexicographical_compare(b.data(), b.data() + 3, a.data(), a.data() + 3);
  const int side = swapped ? plane_side(from, to, b, a) : plane_side(from, to, a, b);
  return (side >= 0) != swapped ? 1 : -1;
}

/// Where a triangle's corners lie to a plane.
struct CornersByPlane {
  int alone = -1;         ///< that has no other strictly on its side; -1: not both sides have one
  bool in_front = false;  ///< whether it lies in front
};

CornersByPlane by_plane(const TriangleCorners& corners, const TriangleCorners& plane) {
  std::array<int, 3> sides;
  for (std::size_t k = 0; k < 3; ++k) sides[k] = plane_side(plane[0], plane[1], plane[2], corners[k]);
  const auto count = [&](int side) { return std::count(sides.begin(), sides.end(), side); };
  if (count(1) == 0 || count(-1) == 0) return {};
  const int side = count(1) == 1 ? 1 : -1;
  return {static_cast<int>(std::find(sides.begin(), sides.end(), side) - sides.begin()), side > 0};
}

}  // namespace

int plane_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 u = a - p;
  const Vec3 v = b - p;
  const Vec3 w = c - p;
  double determinant = 0;
  double magnitude = 0;
  for (int i = 0; i < 3; ++i) {
    const double first = v[(i + 1) % 3] * w[(i + 2) % 3];
    const double second = v[(i + 2) % 3] * w[(i + 1) % 3];
    determinant += u[i] * (first - second);
    magnitude += std::abs(u[i]) * (std::abs(first) + std::abs(second));
  }
  if (std::abs(determinant) > 16 * unit_roundoff * magnitude) return -sign_of(determinant);
  // Of triangles that share a vertex this is most of what gets here.
  if (a == p || b == p || c == p || a == b || b == c || c == a) return 0;
  const int sign = double_double_sign(difference(a, p), difference(b, p), difference(c, p), magnitude);
  return sign != 0 ? -sign : exact_plane_side(a, b, c, p);
}

int segment_crossing(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& from, const Vec3& to) {
  const bool starts_behind = plane_side(a, b, c, from) < 0;
  if (starts_behind == (plane_side(a, b, c, to) < 0)) return 0;
  const int side = edge_side(from, to, a, b);
  if (edge_side(from, to, b, c) != side || edge_side(from, to, c, a) != side) return 0;
  return starts_behind ? 1 : -1;
}

bool pass_through_each_other(const TriangleCorners& one, const TriangleCorners& other) {
  const CornersByPlane first = by_plane(one, other);
  if (first.alone < 0) return false;
  const CornersByPlane second = by_plane(other, one);
  if (second.alone < 0) return false;
  const auto corner = [](const TriangleCorners& of, int index) -> const Vec3& {
    return of[static_cast<std::size_t>(index % 3)];
  };
  // Each triangle is wound so that the corner that is alone lies in front of the other's plane.
  const auto next = [](const CornersByPlane& own, const CornersByPlane& of_other) {
    return own.alone + (of_other.in_front ? 1 : 2);
  };
  const auto last = [](const CornersByPlane& own, const CornersByPlane& of_other) {
    return own.alone + (of_other.in_front ? 2 : 1);
  };
  const Vec3& p1 = corner(one, first.alone);
  const Vec3& p2 = corner(other, second.alone);
  const Vec3& q1 = corner(one, next(first, second));
  const Vec3& q2 = corner(other, next(second, first));
  // On the line that the planes share, each triangle's part begins before the other's ends.
  if (plane_side(p1, q1, p2, q2) >= 0) return false;
  return plane_side(p1, corner(one, last(first, second)), corner(other, last(second, first)), p2) < 0;
}

int ray_crossing(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& start, AxisRay ray) {
  const int i = (ray.axis + 1) % 3;
  const int j = (ray.axis + 2) % 3;
  const Flat flat_a{a[i], a[j]};
  const Flat flat_b{b[i], b[j]};
  const Flat flat_start{start[i], start[j]};
  const int facing = side(flat_a, flat_b, flat_start);
  if (facing == 0) return 0;
  const Flat flat_c{c[i], c[j]};
  if (side(flat_b, flat_c, flat_start) != facing || side(flat_c, flat_a, flat_start) != facing) return 0;

  const int outwards = ray.upwards ? facing : -facing;
  return plane_side(a, b, c, start) == -outwards ? outwards : 0;
}

double strip_share(const Vec3& a, const Vec3& b, const Vec3& eye, AxisRay ray) {
  const AxialView from = view_along(a - eye, ray);
  const AxialView to = view_along(b - eye, ray);
  const int i = (ray.axis + 1) % 3;
  const int j = (ray.axis + 2) % 3;
  const int facing = side({a[i], a[j]}, {b[i], b[j]}, {eye[i], eye[j]});
  const double sine = std::abs(from.flat.x * to.flat.y - from.flat.y * to.flat.x);
  const double cosine = from.flat.x * to.flat.x + from.flat.y * to.flat.y;
  const double half_excess = std::atan2(sine, from.half_cosine * to.half_cosine + cosine);
  return (ray.upwards ? -facing : facing) * half_excess / (2 * std::numbers::pi);
}

}  // namespace musclebench

#include "core/fibres/mean_value_coordinates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>

namespace musclebench {

namespace {

/// Seen from the point: unit directions of the vertices and their distances.
struct Seen {
  std::vector<Vec3> directions;
  std::vector<double> distances;
};

Seen seen_from(const Vec3& point, const std::vector<Vec3>& vertices) {
  Seen seen;
  seen.directions.reserve(vertices.size());
  seen.distances.reserve(vertices.size());
  for (const Vec3& vertex : vertices) {
    const Vec3 to_vertex = vertex - point;
    const double distance = to_vertex.norm();
    seen.distances.push_back(distance);
    seen.directions.push_back(distance > 0 ? Vec3(to_vertex / distance) : Vec3::Zero());
  }
  return seen;
}

/// `corners` are unit directions. The weights carry the corners to the integral of the unit normal over the spherical
/// triangle, which is that over the three sectors between its sides and the point: the sum over the sides of half the
/// angle times the sector's normal.
void add_weights(const std::array<Vec3, 3>& corners, const std::array<double, 3>& distances, const Triangle& triangle,
                 std::vector<double>& weights) {
  std::array<Vec3, 3> side_normals;  // of the side opposite to each corner; not normalised
  Vec3 integral = Vec3::Zero();      // twice
  double largest_sine = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& from = corners[(i + 1) % 3];
    const Vec3& to = corners[(i + 2) % 3];
    side_normals[i] = from.cross(to);
    const double sine = side_normals[i].norm();
    largest_sine = std::max(largest_sine, sine);
    if (sine > 0) integral += side_normals[i] * (std::atan2(sine, from.dot(to)) / sine);
  }
  // Nearer to edge-on the quotient is mostly rounding; the published algorithm leaves such triangles out, too.
  constexpr double least_volume = 1e-8;
  const double volume = corners[0].dot(side_normals[0]);
  if (!(std::abs(volume) > least_volume * largest_sine)) return;
  for (std::size_t i = 0; i < 3; ++i) {
    const double weight = side_normals[i].dot(integral) / (volume * distances[i]);
    weights[static_cast<std::size_t>(triangle[i])] += weight;
  }
}

/// Makes the weights reproduce affine functions; false where the vertices do not span space.
bool make_affine(const std::vector<Vec3>& vertices, const Vec3& point, std::vector<double>& weights) {
  // In units of the weighted size about the point: the system is then free of scale.
  double squared_size = 0;
  double total = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    squared_size += std::abs(weights[i]) * (vertices[i] - point).squaredNorm();
    total += std::abs(weights[i]);
  }
  const double size = total > 0 ? std::sqrt(squared_size / total) : 0;
  if (!(size > 0)) return false;
  constexpr int passes = 2;  // the second takes what rounding left of the first
  for (int pass = 0; pass < passes; ++pass) {
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
    Eigen::Vector4d missing(1, 0, 0, 0);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      Eigen::Vector4d affine;
      affine << 1, (vertices[i] - point) / size;
      moments += std::abs(weights[i]) * affine * affine.transpose();
      missing -= weights[i] * affine;
    }
    const Eigen::LDLT<Eigen::Matrix4d> solver(moments);
    constexpr double least_share = 1e-12;
    const Eigen::Vector4d pivots = solver.vectorD();
    if (!(pivots.minCoeff() > least_share * pivots.maxCoeff())) return false;
    const Eigen::Vector4d function = solver.solve(missing);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      Eigen::Vector4d affine;
      affine << 1, (vertices[i] - point) / size;
      weights[i] += std::abs(weights[i]) * affine.dot(function);
    }
  }
  return true;
}

}  // namespace

std::vector<double> mean_value_coordinates(const TriangleMesh& surface, const Vec3& point) {
  const Seen seen = seen_from(point, surface.vertices);
  std::vector<double> weights(surface.vertices.size(), 0.0);
  for (const Triangle& triangle : surface.triangles) {
    std::array<Vec3, 3> corners;
    std::array<double, 3> distances{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto vertex = static_cast<std::size_t>(triangle[i]);
      corners[i] = seen.directions[vertex];
      distances[i] = seen.distances[vertex];
    }
    if (distances[0] > 0 && distances[1] > 0 && distances[2] > 0) {
      add_weights(corners, distances, triangle, weights);
    }
  }
  double sum = 0;
  for (const double weight : weights) sum += weight;
  if (!(std::abs(sum) > 0)) return {};
  for (double& weight : weights) weight /= sum;
  if (!make_affine(surface.vertices, point, weights)) return {};
  return weights;
}

}  // namespace musclebench

#include "core/fibres/surface_laplace.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/SparseCholesky>

namespace musclebench {

std::vector<double> solve_on_surface(const TriangleMesh& mesh, std::vector<double> values,
                                     std::span<const double> sources, const CotangentLimits& limits) {
  const std::size_t count = mesh.vertices.size();
  // A vertex without triangles has no equation.
  std::vector<bool> used(count, false);
  for (const Triangle& triangle : mesh.triangles) {
    for (const int corner : triangle) {
      used[corner] = true;
    }
  }
  std::vector<int> unknown(count, -1);
  int unknowns = 0;
  for (std::size_t i = 0; i < count; ++i) {
    unknown[i] = std::isnan(values[i]) && used[i] ? unknowns++ : -1;
  }
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (unknown[i] >= 0) right[unknown[i]] = sources[i];
  }
  const auto join = [&](int i, int j, double weight) {
    if (unknown[i] < 0) {
      return;
    }
    entries.emplace_back(unknown[i], unknown[i], weight);
    if (unknown[j] >= 0) {
      entries.emplace_back(unknown[i], unknown[j], -weight);
    } else {
      right[unknown[i]] += weight * values[j];
    }
  };
  for (const Triangle& triangle : mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      const int i = triangle[corner];
      const int j = triangle[(corner + 1) % 3];
      const Vec3 to_i = mesh.vertices[i] - mesh.vertices[triangle[(corner + 2) % 3]];
      const Vec3 to_j = mesh.vertices[j] - mesh.vertices[triangle[(corner + 2) % 3]];
      const double sine = to_i.cross(to_j).norm();
      const double cotangent = sine > 0 ? std::clamp(to_i.dot(to_j) / sine, limits.least, limits.most) : limits.least;
      join(i, j, cotangent);
      join(j, i, cotangent);
    }
  }
  Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) {
    return {};
  }
  const Eigen::VectorXd solution = solver.solve(right);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = unknown[i] >= 0 ? solution[unknown[i]] : values[i];
  }
  return values;
}

}  // namespace musclebench

#pragma once

#include <array>
#include <cstdint>

#include "backends/sdf/grid/field_block.hpp"

namespace musclebench {

/// The greatest depth of a tree: bits of a point's coordinates in its root.
inline constexpr int octree_most_levels = 24;

/// An adaptive field as its kernels read it (see OctreeField). What it points to is the field's.
struct OctreeView {
  const std::uint32_t* entries;
  const float* coefficients;    ///< any leaf's may be read as if they were a cubic polynomial's
  std::array<double, 3> roots;  ///< along each axis
  double root_edge_m;
  double excess_m;
  double sign_error_distance_m;
};

/// The leaves that the points of a block lie in.
struct LeafBlock {
  template <typename Scalar>
  using Lanes = FieldBlock::Lanes<Scalar>;

  Lanes<std::uint32_t> entry;    ///< see octree_entry
  Lanes<double> x, y, z;         ///< in [-1, 1]^3
  Lanes<double> edges_per_root;  ///< edges of the leaf along one of a root
};

/// Value, gradient and leaves of the points of a block, all of which lie in the field; its cells are the roots.
/// Arithmetic is in double precision, each operation rounded by itself and in the same order everywhere: the same bits
/// on any machine, whatever else is in the block.
void evaluate_block(const OctreeView& field, FieldBlock& block, LeafBlock& leaves);

/// The radii of spheres around the points of an evaluated block in which the field is nowhere negative, in metres; 0
/// where nothing is known.
void clear_block(const OctreeView& field, const FieldBlock& block, const LeafBlock& leaves,
                 FieldBlock::Lanes<double>& clearance_m);

}  // namespace musclebench

#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/mesh/body.hpp"
#include "core/mesh/rigid_motion.hpp"
#include "core/referee/referee.hpp"

namespace musclebench {

/// What makes contact with the bone hard at a place, the first that applies in the order of `contact_difficulties`.
enum class ContactDifficulty {
  attached_border,  ///< the node shares a triangle with an attached one
  thin,             ///< the bone is thinner than 1 % of its diagonal there
  ridge,            ///< the bone is convex with a radius below some 3 % of its diagonal
  concave,          ///< the same, concave
  flat,             ///< none of these
};
inline constexpr std::array<std::string_view, 5> contact_difficulties{"attached_border", "thin", "ridge", "concave",
                                                                      "flat"};

/// A place on a bone's surface where a node truly touched it.
struct ContactSite {
  int bone = 0;
  int muscle = 0;
  int node = 0;
  Vec3 surface_point_m = Vec3::Zero();  ///< rest frame of the bone
  Vec3 outward = Vec3::Zero();          ///< unit, rest frame
  long contacts = 1;                    ///< true contacts that the site stands for
  ContactDifficulty difficulty = ContactDifficulty::flat;
};

/// Samples true contacts evenly over a motion: of each pair of bone and muscle every so many-th contact, so that at
/// most `sites_a_pair` are kept. The sample depends on the contacts alone.
class ContactSiteSampler {
 public:
  static constexpr std::size_t sites_a_pair = 1000;

  ContactSiteSampler(std::size_t bones, std::vector<Body> muscles);

  /// Takes the contacts of one collision step: `truth` is the Referee's (world frame, m).
  void add(std::span<const RigidMotion> bone_poses, std::span<const Vec3> positions, std::span<const Contact> truth);

  /// Bone after bone, each with all muscles, in the order of the contacts. `difficulty` is not told.
  [[nodiscard]] std::vector<ContactSite> sites() const;

 private:
  struct Pair {
    std::vector<ContactSite> sites;
    long seen = 0;
    long stride = 1;
  };
  std::vector<Body> m_muscles;
  std::vector<Pair> m_pairs;  ///< by bone, then muscle
};

/// Sets the difficulty of each site, from the exact distance around it, so that it does not depend on how the bone is
/// meshed. `bone_diagonals_m` are those of the bones' bounding boxes; `muscle` is the mesh of all muscles and
/// `free_nodes` its nodes that are not attached, ascending.
void classify_sites(const Referee& referee, std::span<const double> bone_diagonals_m, const TriangleMesh& muscle,
                    std::span<const int> free_nodes, std::vector<ContactSite>& sites);

}  // namespace musclebench

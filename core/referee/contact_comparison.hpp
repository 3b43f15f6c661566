#pragma once

#include <span>

#include "core/contact/contact.hpp"

namespace musclebench {

/// How an answer departs from the truth, in contacts (pairs of a bone and a node).
struct ContactDifference {
  int missed = 0;          ///< true contacts that the answer lacks
  int false_contacts = 0;  ///< answered contacts that are not true
};

/// Compares two contact lists, each ordered by bone, then by node, without repetitions. Depths and normals do not
/// count.
ContactDifference compare_contacts(std::span<const Contact> answered, std::span<const Contact> truth);

/// How deep the muscle is in the bones. A node in several bones counts once, with its largest depth. All 0 when no node
/// is inside.
struct DepthStatistics {
  int nodes_inside = 0;
  double max_depth_m = 0;
  double p99_depth_m = 0;  ///< 99th percentile over the nodes inside, see percentile_index
  double mean_depth_m = 0;
};

/// Statistics over contacts in any order.
DepthStatistics depth_statistics(std::span<const Contact> truth);

}  // namespace musclebench

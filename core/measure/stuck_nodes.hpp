#pragma once

#include <span>

#include "core/contact/contact.hpp"
#include "core/pbd/simulation.hpp"

namespace musclebench {

/// Counts the nodes that the response holds back although they are free by the truth.
///
/// A node is stuck in a frame when, in the frame's last detection,
/// - the backend reported it in a bone, and it was in no bone;
/// - the loop moved it by |p - c| > `floor_m`, where p is the position of the detection and c the substep's start
///   carried along with the bone that the node was reported in;
/// - the response took back at least 90 % of that: |x - c| <= 0.1 |p - c| for the node's position x after the frame.
/// It counts once however many bones it was reported in.
///
/// `detection.contacts` and `truth` (the true contacts at `detection.positions`) are ordered by bone, then by node;
/// `after` holds x. All in metres, world frame.
int count_stuck_nodes(const LastDetection& detection, std::span<const Contact> truth, std::span<const Vec3> after,
                      double floor_m);

}  // namespace musclebench

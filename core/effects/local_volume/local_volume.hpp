#pragma once

#include <memory>
#include <vector>

#include "core/effects/effect_registry.hpp"

namespace musclebench {

/// Keeps the volume of each of several regions of a muscle, so that an end that is squeezed does not inflate the other
/// (regional instead of global volume preservation: Takamatsu and Kanai 2009, "Volume-preserving LSM deformations").
/// Regions are bands of equal surface area along the muscle's longest principal axis at rest; their volumes add up to
/// the muscle's (VolumeConstraints), so that the effect `volume` is not needed beside it. A muscle whose surface is
/// open is one region.
EffectEntry local_volume_entry();

/// By triangle: its band, from 0 on without a gap; at most `count` in each body.
std::vector<int> bands_along_bodies(const TriangleMesh& mesh, const std::vector<Body>& bodies, int count);

}  // namespace musclebench

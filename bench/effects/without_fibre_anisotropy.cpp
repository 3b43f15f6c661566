// Of a program that is built without anisotropy: linked in the place of core/fibres/fibre_alignment.cpp. Who calls it
// after all ends the program.
#include <cstdlib>

#include "core/fibres/fibre_alignment.hpp"

namespace musclebench {

double alignment_with_nearest_fibre(const std::vector<FibreSegment>& /*fibres*/, const Vec3& /*point*/,
                                    const Vec3& /*direction*/) {
  std::abort();
}

}  // namespace musclebench

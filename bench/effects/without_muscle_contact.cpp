// Of a program that is built without contact between muscles: linked in the place of core/scene/muscle_contact.cpp. Who
// calls it after all ends the program.
#include <cstdlib>

#include "core/scene/muscle_contact.hpp"

namespace musclebench {

std::unique_ptr<ContactStage> make_muscle_contact_stage(const Scene& /*scene*/,
                                                        std::span<const double> /*inverse_masses*/,
                                                        const ContactProperties& /*properties*/,
                                                        MuscleContactDetectors /*detectors*/) {
  std::abort();
}

}  // namespace musclebench

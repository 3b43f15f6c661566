#include "core/effects/multi_bone.hpp"

namespace musclebench {

void set_multi_bone(Response& response, const Parameters& parameters) {
  response.project_out_of_all(static_cast<int>(parameters.integer("steps")));
}

std::vector<ParameterSpec> multi_bone_parameters() {
  return {
      parameter::integer({.name = "steps",
                          .default_value = 8,
                          .minimum = 1,
                          .maximum = 1000,
                          .help = "detections of one response, at most: a node between curved bones needs several"})};
}

}  // namespace musclebench

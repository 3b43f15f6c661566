#include "bench/results/verification_json.hpp"

namespace musclebench {

Json json_of(const SurfaceVerification& verification, const std::string& bone, const std::string& surface) {
  Json json = {{"bone", bone},
               {"surface", surface},
               {"diagonal_m", verification.diagonal_m},
               {"agreed_m", verification.agreed_m},
               {"seconds", verification.seconds},
               {"held", verification.held()}};
  json["pairs"] = Json::array();
  for (const Agreement& pair : verification.pairs) {
    const Vec3& worst = pair.worst_point_m;
    json["pairs"].push_back({{"first", pair.first},
                             {"second", pair.second},
                             {"points", pair.points},
                             {"inside", pair.inside},
                             {"largest_difference_m", pair.largest_difference_m},
                             {"worst_point_m", {worst.x(), worst.y(), worst.z()}},
                             {"sign_differences", pair.sign_differences},
                             {"held", verification.holds(pair)}});
  }
  return json;
}

}  // namespace musclebench

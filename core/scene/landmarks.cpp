#include "core/scene/landmarks.hpp"

#include <algorithm>
#include <map>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/base/input_error.hpp"
#include "core/base/input_file.hpp"

namespace musclebench {

namespace {

nlohmann::json read_json(const std::filesystem::path& path) {
  constexpr std::uintmax_t most_bytes = 64 << 20;
  const std::string text = InputFile(path).text(most_bytes);
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path.string(), fmt::format("is not valid JSON ({})", error.what()));
  }
}

std::string not_a_landmark_file(std::string_view wanted, const nlohmann::json::exception& error) {
  return fmt::format(
      "is not a landmark file: it has to be a JSON object with a list of {}; see datasets/README.md ({})", wanted,
      error.what());
}

Vec3 point_of(const nlohmann::json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

std::vector<Vec3> placed_points(const nlohmann::json& values, const MeshPlacement& placement,
                                const std::filesystem::path& path) {
  std::vector<Vec3> points;
  for (const auto& value : values) {
    points.push_back(point_of(value));
  }
  placement.apply_to_metres(points);
  if (std::ranges::all_of(points, [](const Vec3& point) { return point.allFinite(); })) return points;
  throw InputError(path.string(), "has coordinates that are too large once they are placed as their mesh; check scale");
}

}  // namespace

std::vector<Vec3> read_landmark_outline(const std::filesystem::path& path, const std::string& selector,
                                        const MeshPlacement& placement) {
  const nlohmann::json file = read_json(path);
  try {
    std::vector<std::string> known;
    std::vector<std::string> matching;
    std::vector<Vec3> points;
    std::map<std::string, int> count_of_name;
    for (const auto& attachment : file.at("attachments")) {
      const std::string site =
          fmt::format("{}/{}", attachment.at("muscle").get<std::string>(), attachment.at("role").get<std::string>());
      const bool has_part = attachment.contains("part") && attachment.at("part").is_string();
      std::string name = has_part ? fmt::format("{}/{}", site, attachment.at("part").get<std::string>()) : site;
      const std::string numbered = fmt::format("{}/{}", name, ++count_of_name[name]);
      known.push_back(name);
      if (selector != site && selector != name && selector != numbered) continue;
      matching.push_back(has_part && selector == site ? name : numbered);
      const std::vector<Vec3> own = placed_points(attachment.at("points_m"), placement, path);
      points.insert(points.end(), own.begin(), own.end());
    }
    if (matching.size() > 1) {
      throw InputError(path.string(), fmt::format("has {} attachments '{}'; name one of them, {}", matching.size(),
                                                  selector, fmt::join(matching, " or ")));
    }
    if (matching.empty()) {
      throw InputError(path.string(), fmt::format("has no attachment '{}'; did you mean '{}'?", selector,
                                                  nearest_word(selector, known)));
    }
    return points;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path.string(), not_a_landmark_file("attachments (muscle, role, points_m)", error));
  }
}

std::vector<FibreSegment> read_landmark_fibres(const std::filesystem::path& path, const std::string& muscle,
                                               const MeshPlacement& placement) {
  const nlohmann::json file = read_json(path);
  try {
    std::vector<std::string> known;
    for (const auto& fibres : file.at("fibres")) {
      known.push_back(fibres.at("muscle").get<std::string>());
      if (known.back() != muscle) {
        continue;
      }
      std::vector<FibreSegment> segments;
      for (const auto& polyline : fibres.at("polylines_m")) {
        const std::vector<Vec3> points = placed_points(polyline, placement, path);
        for (std::size_t i = 1; i < points.size(); ++i) {
          segments.push_back({points[i - 1], points[i]});
        }
      }
      if (segments.empty()) {
        throw InputError(path.string(), fmt::format("has no fibre of two points for '{}'; leave fibres out", muscle));
      }
      return segments;
    }
    throw InputError(path.string(), known.empty() ? std::string("has no fibres; leave fibres out")
                                                  : fmt::format("has no fibres of '{}'; did you mean '{}'?", muscle,
                                                                nearest_word(muscle, known)));
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path.string(), not_a_landmark_file("fibres (muscle, polylines_m)", error));
  }
}

}  // namespace musclebench

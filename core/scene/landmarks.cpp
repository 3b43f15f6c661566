#include "core/scene/landmarks.hpp"

#include <string_view>

#include <fmt/format.h>
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

}  // namespace

std::vector<Vec3> read_landmark_outline(const std::filesystem::path& path, const std::string& selector) {
  const nlohmann::json file = read_json(path);
  try {
    std::vector<std::string> known;
    for (const auto& attachment : file.at("attachments")) {
      std::string name =
          fmt::format("{}/{}", attachment.at("muscle").get<std::string>(), attachment.at("role").get<std::string>());
      const bool wanted_without_part = name == selector;
      if (attachment.contains("part") && attachment.at("part").is_string()) {
        name += fmt::format("/{}", attachment.at("part").get<std::string>());
      }
      known.push_back(name);
      if (wanted_without_part || name == selector) {
        std::vector<Vec3> points;
        for (const auto& point : attachment.at("points_m")) {
          points.push_back(point_of(point));
        }
        return points;
      }
    }
    throw InputError(path.string(), fmt::format("has no attachment '{}'; did you mean '{}'?", selector,
                                                nearest_word(selector, known)));
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path.string(), not_a_landmark_file("attachments (muscle, role, points_m)", error));
  }
}

std::vector<FibreSegment> read_landmark_fibres(const std::filesystem::path& path, const std::string& muscle) {
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
        for (std::size_t i = 1; i < polyline.size(); ++i) {
          segments.push_back({point_of(polyline.at(i - 1)), point_of(polyline.at(i))});
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

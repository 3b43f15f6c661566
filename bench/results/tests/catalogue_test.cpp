// `list --json` against its schema: what tools and reports read of a build.
#include "bench/results/catalogue.hpp"

#include <set>

#include <gtest/gtest.h>

namespace musclebench {
namespace {

std::set<std::string> keys_of(const Json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) {
    keys.insert(key);
  }
  return keys;
}

using Keys = std::set<std::string>;

void expect_parameter(const Json& parameter) {
  SCOPED_TRACE(parameter.dump());
  Keys expected{"name", "kind", "unit", "default", "minimum", "maximum", "help", "role"};
  const std::string kind = parameter["kind"];
  if (kind == "choice") {
    expected.insert("choices");
    EXPECT_GE(parameter["choices"].size(), 2U);
    const Json& choices = parameter["choices"];
    EXPECT_NE(std::find(choices.begin(), choices.end(), parameter["default"]), choices.end());
  }
  EXPECT_EQ(keys_of(parameter), expected);
  EXPECT_TRUE((Keys{"flag", "integer", "number", "choice", "path"}.contains(kind)));
  EXPECT_TRUE((Keys{"", "resolution", "wanted_error", "storage", "clearance_cache"}.contains(parameter["role"])));
  EXPECT_EQ(parameter["default"].is_boolean(), kind == "flag");
  EXPECT_EQ(parameter["default"].is_string(), kind == "choice" || kind == "path");
  EXPECT_EQ(parameter["default"].is_number_integer(), kind == "integer");
  const bool has_range = kind == "integer" || kind == "number";
  EXPECT_EQ(parameter["minimum"].is_number(), has_range);
  EXPECT_EQ(parameter["minimum"].is_null(), !has_range);
  EXPECT_EQ(parameter["maximum"].is_number(), has_range);
  if (has_range) {
    EXPECT_LE(parameter["minimum"], parameter["default"]);
    EXPECT_LE(parameter["default"], parameter["maximum"]);
  }
  EXPECT_FALSE(parameter["help"].get<std::string>().empty());
}

void expect_parameters(const Json& parameters) {
  ASSERT_TRUE(parameters.is_array());
  for (const Json& parameter : parameters) {
    expect_parameter(parameter);
  }
}

TEST(Catalogue, HasTheKeysOfItsSchema) {
  // Parts of what a scene asks about: no search adds them.
  const Keys loads{"damping", "gravity", "attachment", "activation", "margin", "friction", "retinaculum"};
  const Json json = catalogue();
  EXPECT_EQ(keys_of(json), (Keys{"schema", "version", "git", "backends", "responses", "effects", "loop", "meshes",
                                 "wanted", "presets", "scenes", "results"}));
  EXPECT_EQ(json["schema"], 1);
  for (const char* key : {"backends", "responses", "effects", "presets", "scenes"}) {
    EXPECT_FALSE(json[key].empty()) << key;
  }
  expect_parameters(json["loop"]);
  expect_parameters(json["meshes"]);
  expect_parameters(json["wanted"]);
  for (const Json& effect : json["effects"]) {
    EXPECT_EQ(keys_of(effect), (Keys{"name", "help", "parameters", "remedies", "colour"}));
    // multi_bone has no time of its own to show.
    EXPECT_EQ(std::string(effect["colour"]).size(), effect["name"] == "multi_bone" ? 0U : 7U) << effect["name"];
    EXPECT_EQ(effect["remedies"].empty(), loads.contains(effect["name"])) << effect["name"];
    expect_parameters(effect["parameters"]);
  }
  for (const Json& response : json["responses"]) {
    EXPECT_EQ(keys_of(response), (Keys{"name", "help"}));
  }
  for (const Json& preset : json["presets"]) {
    EXPECT_EQ(keys_of(preset), (Keys{"name", "title"}));
  }
  for (const Json& scene : json["scenes"]) {
    EXPECT_EQ(keys_of(scene), (Keys{"name", "title", "muscles", "bones"}));
    EXPECT_FALSE(scene["bones"].empty());
  }
}

TEST(Catalogue, EachBackendHasTheKeysOfTheSchema) {
  const Json json = catalogue();
  Keys responses;
  for (const Json& response : json["responses"]) {
    responses.insert(response["name"].get<std::string>());
  }
  int exact = 0;
  for (const Json& backend : json["backends"]) {
    SCOPED_TRACE(backend["name"]);
    EXPECT_EQ(keys_of(backend),
              (Keys{"name", "label", "help", "implementation", "colour", "dash", "default_response", "exact",
                    "muscle_contact", "face_contact", "parameters", "capabilities", "study"}));
    EXPECT_EQ(keys_of(backend["capabilities"]),
              (Keys{"depth", "point_queries", "has_cache", "has_step", "steady_memory", "times_pairs"}));
    EXPECT_FALSE(backend["implementation"].get<std::string>().empty()) << "whose is it?";
    EXPECT_TRUE(responses.contains(backend["default_response"]));
    EXPECT_TRUE(backend["study"].is_null() || backend["study"].is_object());
    expect_parameters(backend["parameters"]);
    exact += backend["exact"].get<bool>() ? 1 : 0;
  }
  EXPECT_GE(exact, 1) << "something has to drive recordings";
}

TEST(Catalogue, AStudyIsPrintedWithTheStructureOfItsFile) {
  const Json listed = catalogue();
  for (const Json& backend : listed["backends"]) {
    const Json& study = backend["study"];
    if (study.is_null()) {
      continue;  // one that has none is in no study
    }
    EXPECT_EQ(backend["colour"], study["colour"]);
    EXPECT_EQ(backend["label"], study["label"]);
    ASSERT_TRUE(study["series"].is_array());
    for (const Json& series : study["series"]) {
      EXPECT_TRUE(!series.contains("sweep") || series["sweep"].begin()->is_array());
    }
  }
}

}  // namespace
}  // namespace musclebench

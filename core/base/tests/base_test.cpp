#include <limits>

#include <gtest/gtest.h>

#include "core/base/input_error.hpp"
#include "core/base/parameters.hpp"
#include "core/base/sha256.hpp"
#include "core/base/system_memory.hpp"

namespace musclebench {
namespace {

const std::vector<ParameterSpec> specs = {
    parameter::integer(
        {.name = "cells", .default_value = 64, .minimum = 1, .maximum = 100, .help = "cells along an axis"}),
    parameter::number(
        {.name = "size_m", .unit = "m", .default_value = 0.5, .minimum = 0, .maximum = 1, .help = "edge"}),
    parameter::choice({.name = "mode", .choices = {"fast", "slow"}}), parameter::flag({.name = "open"}),
    parameter::path({.name = "folder", .role = ParameterRole::storage})};

std::string error_of(const std::map<std::string, ParameterValue>& given) {
  try {
    const Parameters parameters(specs, given, "here");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Parameters, DefaultsAndGivenValues) {
  const Parameters parameters(specs, {{"size_m", std::int64_t{1}}, {"open", true}}, "here");
  EXPECT_EQ(parameters.integer("cells"), 64);
  EXPECT_EQ(parameters.number("size_m"), 1.0);
  EXPECT_EQ(parameters.word("mode"), "fast");
  EXPECT_TRUE(parameters.flag("open"));
  EXPECT_TRUE(parameters.given("size_m"));
  EXPECT_FALSE(parameters.given("cells"));
}

TEST(Parameters, AreFoundByNameAndByRole) {
  EXPECT_EQ(find_parameter(specs, "mode")->kind, ParameterKind::choice);
  EXPECT_EQ(find_parameter(specs, ParameterRole::storage)->name, "folder");
  EXPECT_EQ(find_parameter(specs, ParameterRole::resolution), nullptr);
  EXPECT_EQ(find_parameter(specs, "cels"), nullptr);
  EXPECT_EQ(name_of(ParameterKind::path), "path");
  EXPECT_EQ(name_of(ParameterRole::clearance_cache), "clearance_cache");
}

TEST(Parameters, RefusalsNamePlaceKeyAndCure) {
  EXPECT_EQ(error_of({{"cels", std::int64_t{1}}}), "here: cels: is unknown; did you mean 'cells'?");
  EXPECT_EQ(error_of({{"cells", std::int64_t{0}}}),
            "here: cells: 0 is out of range; allowed is 1 to 100 (cells along an axis)");
  EXPECT_EQ(error_of({{"cells", 1.5}}), "here: cells: is a whole number, not 1.5");
  EXPECT_EQ(error_of({{"size_m", std::numeric_limits<double>::quiet_NaN()}}),
            "here: size_m: nan is out of range; allowed is 0 to 1 (edge)");
  EXPECT_EQ(error_of({{"mode", true}}), "here: mode: is one of fast, slow, not true");
  EXPECT_EQ(error_of({{"mode", std::string("slwo")}}),
            "here: mode: 'slwo' is not one of fast, slow; did you mean 'slow'?");
}

TEST(Parameters, ValuesReadBackToTheSameBits) {
  for (const ParameterValue& value : {ParameterValue(true), ParameterValue(std::int64_t{-7}), ParameterValue(0.1),
                                      ParameterValue(1e-300), ParameterValue(std::string("word"))}) {
    EXPECT_EQ(parse_parameter_value(format_parameter_value(value)), value);
  }
}

TEST(NearestWord, FindsTheTypo) {
  EXPECT_EQ(nearest_word("bendin", {"volume", "bending", "gravity"}), "bending");
  EXPECT_EQ(nearest_word("x", {}), "");
}

TEST(Sha256, GivesThePublishedDigest) {  // FIPS 180-4, example "abc"
  Sha256 hash;
  hash.add("a");
  hash.add("bc");
  EXPECT_EQ(hash.hex_digest(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(SystemMemory, KnowsTheProcessAndRefusesTooMuch) {
  EXPECT_GT(resident_memory_bytes(), 1000000U);
  EXPECT_GE(peak_resident_memory_bytes(), resident_memory_bytes() / 2);
  EXPECT_NO_THROW(require_memory(1000, "cells", "choose fewer"));
  EXPECT_THROW(require_memory(std::size_t{1} << 60, "cells", "choose fewer"), InputError);
}

TEST(InputError, StaysReadableWhereItQuotesMegabytes) {
  const std::string message =
      InputError("file.mot:3", "'" + std::string(1 << 20, '7') + "' is no number; mend it").what();
  EXPECT_LT(message.size(), 3000U);
  EXPECT_TRUE(message.starts_with("file.mot:3: '777"));
  EXPECT_TRUE(message.ends_with("777' is no number; mend it"));
  EXPECT_LT(std::string(InputError(std::string(1 << 20, 'k'), "is unknown").what()).size(), 3000U) << "a key";
}

/// Comparing letter by letter would take the product of the lengths: hours.
TEST(InputError, NearestWordPassesOverWhatNobodyTypes) {
  const std::string endless(1 << 24, 'x');
  EXPECT_EQ(nearest_word(endless, {"axis", "outline"}), "axis");
  EXPECT_EQ(nearest_word("axes", {endless, "axis"}), "axis");
  EXPECT_EQ(nearest_word(endless, {endless + "y", "axis"}), "axis");
}

}  // namespace
}  // namespace musclebench

// The study.toml of every backend of the build: what it sweeps and fixes are parameters that the backend takes.
#include <gtest/gtest.h>

#include "backends/registry.hpp"
#include "bench/cases/advise_plan.hpp"
#include "core/scene/toml_table.hpp"

namespace musclebench {
namespace {

std::vector<std::string> names_of_backends() {
  std::vector<std::string> names;
  for (const BackendEntry& entry : backend_registry()) {
    names.push_back(entry.name);
  }
  return names;
}

class Study : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (entry().study.empty()) {
      GTEST_SKIP() << entry().name << " has no study.toml";
    }
  }
  [[nodiscard]] const BackendEntry& entry() const { return find_backend(GetParam()); }
  [[nodiscard]] TomlTable study() const { return {m_text, entry().name + "/study.toml", ""}; }

  void expect_taken(const Settings& settings, const std::string& location) const {
    EXPECT_NO_THROW((void)entry().make(Parameters(entry().parameters, settings, location)));
  }

 private:
  toml::table m_text = parse_toml(find_backend(GetParam()).study, GetParam());
};

/// The values of a sweep, which names one parameter.
std::vector<Settings> swept(const toml::table* sweep, const Settings& fixed) {
  if (sweep == nullptr) {
    return {fixed};
  }
  std::vector<Settings> all;
  EXPECT_EQ(sweep->size(), 1U);
  for (const auto& [key, values] : *sweep) {
    for (const toml::node& value : *values.as_array()) {
      toml::table one;
      one.insert(key, value);
      all.push_back(fixed);
      all.back().merge(TomlTable(one, "sweep", "").values());
    }
  }
  return all;
}

TEST_P(Study, EverySeriesIsTaken) {
  const toml::table text = parse_toml(entry().study, GetParam());
  const toml::array* all = text["series"].as_array();
  ASSERT_NE(all, nullptr);
  for (const toml::node& series : *all) {
    const toml::table& table = *series.as_table();
    const toml::table* fixed = table["fixed"].as_table();
    const Settings settings = fixed == nullptr ? Settings{} : TomlTable(*fixed, GetParam(), "fixed").values();
    for (const Settings& configuration : swept(table["sweep"].as_table(), settings)) {
      expect_taken(configuration, GetParam());
    }
  }
}

TEST_P(Study, TheAdviceAndTheRacesAreTaken) {
  EXPECT_NO_THROW((void)read_advise_plan(entry()));
  for (const TomlTable& race : study().tables("race")) {
    expect_taken(race.table("parameters")->values(), race.location());
  }
}

TEST(Studies, OneUnitOfPriceInAll) {
  int units = 0;
  for (const AdvisePlan& plan : advise_plans()) {
    units += plan.unit_of_price ? 1 : 0;
  }
  EXPECT_EQ(units, 1);
}

INSTANTIATE_TEST_SUITE_P(Backends, Study, testing::ValuesIn(names_of_backends()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace musclebench

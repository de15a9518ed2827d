// mle_correct on the filters of the outputs' disturbances, from file to files.

#include <cmath>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/state_space_json.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

// Outputs that drift, which the plain bias update follows too fast.
const std::vector<std::string> kDrift = {"--drift_variance=1e-5"};

// Of each output there is a filter, better than the plain bias update.
void ExpectFilters(const nlohmann::json& result, const std::string& out) {
  ASSERT_TRUE(result.contains("filter"));
  ASSERT_EQ(result["filter"].size(), 2u);
  Eigen::Index states = 0;
  for (const nlohmann::json& filter : result["filter"]) {
    ASSERT_FALSE(filter.contains("missing")) << filter;
    EXPECT_EQ(filter["gain_in_use"], 1.0);
    EXPECT_EQ(filter["control_period"], 0.25);
    for (const char* const form : {"bias", "kalman"}) {
      EXPECT_TRUE(filter[form]["better"]) << filter;
      EXPECT_LT(filter[form]["error"], filter["error_in_use"]);
    }
    const double gain = filter["bias"]["gain"];
    EXPECT_NEAR(gain,
                1.0 - std::exp(-0.25 / double{filter["bias"]["time_constant"]}),
                1e-12);
    EXPECT_LT(filter["kalman"]["riccati_residual"], 1e-9);
    states += static_cast<Eigen::Index>(filter["kalman"]["gain"].size());
  }
  const auto system = ReadStateSpace(out + "/state_space.json");
  ASSERT_TRUE(system.ok()) << system.status();
  ASSERT_TRUE(system->disturbance_model.has_value());
  const DisturbanceForm& form = *system->disturbance_model;
  EXPECT_EQ(form.A.rows(), states);
  EXPECT_EQ(form.K(0, 0), result["filter"][0]["kalman"]["gain"][0]);
  EXPECT_EQ(form.R(1), result["filter"][1]["measurement_variance"]);
  const std::string html = Content(out + "/report.html");
  EXPECT_THAT(html, HasSubstr("The filter of disturbances</h2>"));
  EXPECT_THAT(html, HasSubstr("Filters of the outputs&#39; disturbances"));
  EXPECT_THAT(result["advice"].dump(), HasSubstr("K of state_space.json"));
}

TEST(MleCorrectFilter, OfACorrectedModelAndOfOneThatIsRight) {
  const HeaterExample aged(WithHalvedGain(), kDrift);
  nlohmann::json result = aged.Run();
  EXPECT_EQ(result["decision"], "corrected");
  ExpectFilters(result, aged.out);
  const HeaterExample right(Heater(), {"--drift_variance=1e-6", "--seed=4"});
  result = right.Run();
  EXPECT_EQ(result["decision"], "no_change");
  ExpectFilters(result, right.out);
}

// Nothing but regulation: the model cannot be judged, but the filter is found.
TEST(MleCorrectFilter, OfRegulationThatCannotTell) {
  const HeaterExample example(
      Heater(), {"--setpoints=", "--drift_variance=1e-4", "--duration=400"});
  const nlohmann::json result = example.Run({}, 1);
  EXPECT_EQ(result["decision"], "cannot_tell");
  ExpectFilters(result, example.out);
}

TEST(MleCorrectFilter, IsNotEstimatedWhereItIsNotAskedFor) {
  const HeaterExample example(WithHalvedGain(), kDrift);
  const nlohmann::json result = example.Run({"--filter=false"});
  EXPECT_EQ(result["decision"], "corrected");
  EXPECT_FALSE(result.contains("filter"));
  EXPECT_EQ(
      Content(example.out + "/state_space.json").find("disturbance_model"),
      std::string::npos);
  EXPECT_EQ(Content(example.out + "/report.html").find("filter of dist"),
            std::string::npos);
}

// Period, horizon and filter are those of the controller where it is told:
// ρ = 0.1 is a gain of (√41 − 1)/20.
TEST(MleCorrectFilter, IsComparedWithThatOfTheController) {
  const HeaterExample example(WithHalvedGain(), kDrift);
  const nlohmann::json result =
      example.Run({"--control_period=0.5", "--prediction_horizon=30",
                   "--disturbance_variance_ratio=0.1"});
  ASSERT_EQ(result["filter"].size(), 2u);
  for (const nlohmann::json& filter : result["filter"]) {
    EXPECT_NEAR(filter["gain_in_use"], (std::sqrt(41.0) - 1.0) / 20.0, 1e-12);
    EXPECT_EQ(filter["control_period"], 0.5);
    EXPECT_EQ(filter["horizon"], 15.0);
    EXPECT_NEAR(filter["bias"]["gain"],
                1.0 - std::exp(-0.5 / double{filter["bias"]["time_constant"]}),
                1e-12);
  }
  const std::string html = Content(example.out + "/report.html");
  EXPECT_THAT(html, HasSubstr("What it means for control</h2>"));
  EXPECT_THAT(html, HasSubstr("The filter of disturbances"));
  EXPECT_EQ(html.find("The controller&#39;s own filter was not given"),
            std::string::npos);
}

TEST(MleCorrectFilter, DoesNotDependOnTheThreads) {
  const HeaterExample example(WithHalvedGain(), kDrift);
  const nlohmann::json one = example.Run({"--threads=1"});
  const std::string system = Content(example.out + "/state_space.json");
  const nlohmann::json four = example.Run({"--threads=4"});
  EXPECT_EQ(one["filter"].dump(), four["filter"].dump());
  EXPECT_EQ(system, Content(example.out + "/state_space.json"));
}

// A level has no filter, and says so; the page keeps what is in use.
TEST(MleCorrectFilter, OfAnIntegratingOutputThereIsNone) {
  const std::string configs = MLE_SOURCE_FOLDER "/configs/";
  const ScratchFolder scratch;
  const std::string data = SimulateHeater(
      scratch, "run.csv", configs + "level.json", configs + "level.json",
      {"--setpoints=level:60:5,level:150:0",
       "--disturbances=inflow:100:2,inflow:200:0", "--noise_variance=0.01"});
  const std::string out = scratch / "out";
  const nlohmann::json result =
      Correct(CorrectionFlags(configs + "level.json", data, out), out);
  ASSERT_EQ(result["filter"].size(), 1u);
  EXPECT_EQ(result["filter"][0]["missing"], "the output integrates");
  EXPECT_FALSE(result["filter"][0].contains("bias"));
  EXPECT_EQ(Content(out + "/state_space.json").find("disturbance_model"),
            std::string::npos);
  EXPECT_THAT(Content(out + "/report.html"),
              HasSubstr("The filter of disturbances: keep the one in use"));
  EXPECT_THAT(Content(out + "/report.html"),
              HasSubstr("keep: the output integrates"));
}

}  // namespace
}  // namespace mle

#include <limits>
#include <vector>

#include "apps/reproduce/report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/apps/reproduce/example_case.h"

namespace mle::reproduce {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

CaseResult SummarisedCase() {
  CaseResult result = ExampleCase();
  EXPECT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  return result;
}

TEST(FormatResults, RowsAreOutputsAndColumnsInputs) {
  const json results = json::parse(FormatResults({SummarisedCase()}));
  EXPECT_EQ(results["version"], 1);
  const json& one = results["cases"][0];
  EXPECT_EQ(one["name"], "gain");
  EXPECT_EQ(one["E_initial"], 100.0);
  ASSERT_EQ(one["runs"].size(), 2u);
  const json& run = one["runs"][1];
  EXPECT_EQ(run["seed"], 6);
  EXPECT_EQ(run["lambda_star"], 4e-4);
  EXPECT_EQ(run["E_star"], 4.0);
  EXPECT_EQ(run["E_zero"], 10.0);
  EXPECT_EQ(run["E_oracle"], 2.0);
  EXPECT_EQ(run["max_relative_duality_gap"], 3e-11);
  for (const char* key : {"static_gain_error", "delay_impulse_peak", "fopdt"}) {
    ASSERT_EQ(run[key].size(), 2u) << key;
    EXPECT_EQ(run[key][0].size(), 3u) << key;
    EXPECT_EQ(run[key][1].size(), 3u) << key;
  }
  EXPECT_EQ(run["fopdt"][0][2]["gain"], 13.0 + 0.8);
  EXPECT_EQ(run["fopdt"][1][1]["delay"], 2.5);
  EXPECT_EQ(one["summary"]["E_star"]["mean"], 3.5);
  EXPECT_EQ(one["summary"]["fopdt_delay_error_rms"][1][2], 0.5);
}

TEST(FormatResults, KeepsEveryDigit) {
  CaseResult result = SummarisedCase();
  result.E_initial = 0.1 + 0.2;
  EXPECT_EQ(json::parse(FormatResults({result}))["cases"][0]["E_initial"],
            0.1 + 0.2);
}

TEST(FormatResults, StaysJsonWhereAnEIsTooLargeForANumber) {
  CaseResult result = ExampleCase();
  result.runs[0].E_zero = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(SummariseCase(ExampleModel(0.0, 0.0), result).ok());
  const json results = json::parse(FormatResults({result}));
  EXPECT_TRUE(results["cases"][0]["runs"][0]["E_zero"].is_null());
  EXPECT_EQ(results["cases"][0]["runs"][1]["E_zero"], 10.0);
  EXPECT_TRUE(results["cases"][0]["summary"]["E_zero"]["mean"].is_null());
  EXPECT_EQ(results["cases"][0]["summary"]["E_zero"]["best"], 10.0);
}

TEST(FormatCurves, ALineForEachPenalty) {
  CaseResult result = SummarisedCase();
  const Eigen::VectorXd lambdas = Eigen::Vector3d(0.0, 1e-6, 2e-6);
  result.runs[0].squared_distance = Eigen::Vector3d(30.0, 20.0, 25.0);
  const std::vector<File> files = FormatCurves({result}, lambdas);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].first, "curve_gain.csv");
  EXPECT_THAT(files[0].second, StartsWith("lambda,E,"));
  EXPECT_THAT(files[0].second, HasSubstr("\n0,30,"));
  EXPECT_THAT(files[0].second, HasSubstr("\n1e-06,20,"));
  EXPECT_THAT(files[0].second, HasSubstr("\n2e-06,25,"));
}

TEST(FormatCurves, QuotesNamesThatNeedIt) {
  CaseResult result = SummarisedCase();
  result.runs[0].squared_distance = Eigen::VectorXd::Ones(1);
  const std::vector<File> files =
      FormatCurves({result}, Eigen::VectorXd::Zero(1));
  EXPECT_EQ(files[1].first, "step_response_gain.csv");
  EXPECT_THAT(files[1].second,
              StartsWith("time,\"y/u, 1 initial\",\"y/u \"\"2\"\" initial\","
                         "y/ü initial,\"z/u, 1 initial\","));
}

}  // namespace
}  // namespace mle::reproduce

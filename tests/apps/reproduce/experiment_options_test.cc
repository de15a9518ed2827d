#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "apps/reproduce/experiment.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/reproduce/example_case.h"

namespace mle::reproduce {
namespace {

using ::testing::HasSubstr;
using Rule = SelectionOptions::Rule;

// The example has two outputs and three inputs.
ExperimentOptions GoodOptions() {
  ExperimentOptions options;
  options.output_weight = Eigen::VectorXd::Constant(2, 0.2);
  options.move_weight = Eigen::VectorXd::Constant(3, 0.1);
  options.correction.lambdas = Eigen::Vector2d(0.0, 1e-3);
  return options;
}

TEST(ExperimentOptions, ThePapersAreGood) {
  const absl::Status status = GoodOptions().Validate(ExampleModel(0.0, 0.0));
  EXPECT_TRUE(status.ok()) << status;
}

TEST(ExperimentOptions, CountSamplesAndRows) {
  ExperimentOptions options = GoodOptions();
  EXPECT_EQ(options.response_samples(), 501);
  EXPECT_EQ(options.window_rows(), 2001 - 150);
  options.sample_time = 0.1;  // no binary fraction
  options.response_horizon = 0.3;
  EXPECT_EQ(options.response_samples(), 4);
}

TEST(ExperimentOptions, ErrorsNameTheFlag) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Options = ExperimentOptions;
  const struct {
    const char* named;
    std::function<void(Options&)> spoil;
  } cases[] = {
      {"--sample_time", [](Options& o) { o.sample_time = -0.2; }},
      {"--control_period", [](Options& o) { o.control_period = 0.3; }},
      {"--duration", [&](Options& o) { o.duration = nan; }},
      {"--duration", [](Options& o) { o.duration = 1e9; }},
      {"--step_time", [](Options& o) { o.step_time = -1.0; }},
      {"--window", [](Options& o) { o.window = 501.0; }},
      {"--setpoint_step", [](Options& o) { o.setpoint_step = 0.0; }},
      {"--noise_variance", [&](Options& o) { o.noise_variance = nan; }},
      {"--control_horizon", [](Options& o) { o.control_horizon = 0; }},
      {"--prediction_horizon", [](Options& o) { o.prediction_horizon = 4; }},
      {"--output_weight", [](Options& o) { o.output_weight(1) = -1.0; }},
      {"--output_weight", [&](Options& o) { o.output_weight(1) = nan; }},
      {"--move_weight", [](Options& o) { o.move_weight.resize(2); }},
      {"--order", [](Options& o) { o.conversion.order = 0; }},
      {"--order", [](Options& o) { o.conversion.order = 2000; }},
      {"--conversion_penalty", [](Options& o) { o.conversion.penalty = -1; }},
      {"--conversion_duration",
       [](Options& o) { o.conversion_duration = 100.0; }},
      {"--response_horizon", [](Options& o) { o.response_horizon = 0.6; }},
      {"--selection_folds",
       [](Options& o) { o.correction.selection.folds = 1; }},
  };
  for (const auto& [named, spoil] : cases) {
    ExperimentOptions options = GoodOptions();
    options.correction.selection.rule = Rule::kBlocks;
    spoil(options);
    const absl::Status status = options.Validate(ExampleModel(0.0, 0.0));
    EXPECT_FALSE(status.ok()) << named;
    EXPECT_THAT(std::string(status.message()), HasSubstr(named));
  }
}

TEST(ExperimentOptions, OneOutputAllowsNoChangeToBeLeftOut) {
  ProcessModel model("heater", "min", {{"power", ""}}, {{"temperature", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 1.0);
  ExperimentOptions options = GoodOptions();
  options.output_weight = Eigen::VectorXd::Ones(1);
  options.move_weight = Eigen::VectorXd::Ones(1);
  options.correction.selection.rule = Rule::kLeaveChangeOut;
  EXPECT_THAT(std::string(options.Validate(model).message()),
              HasSubstr("--selection=blocks"));
  options.correction.selection.rule = Rule::kBlocks;
  const absl::Status status = options.Validate(model);
  EXPECT_TRUE(status.ok()) << status;
}

TEST(ExperimentOptions, InputsNobodyMovesAreRefused) {
  const ProcessModel column(
      "column", "min", {{"reflux", ""}, {"feed", "", InputRole::kDisturbance}},
      {{"top", ""}});
  ExperimentOptions options = GoodOptions();
  options.output_weight = Eigen::VectorXd::Ones(1);
  options.move_weight = Eigen::VectorXd::Ones(2);
  EXPECT_THAT(std::string(options.Validate(column).message()),
              HasSubstr("'feed' is a disturbance"));
}

}  // namespace
}  // namespace mle::reproduce

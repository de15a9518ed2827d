#include "apps/experiment/options.h"

#include <functional>
#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"

namespace mle::experiment {
namespace {

using ::testing::HasSubstr;
using Rule = SelectionOptions::Rule;

// Two outputs and three inputs.
ProcessModel ExampleModel() {
  ProcessModel model("example", "s", {{"u", ""}, {"v", ""}, {"w", ""}},
                     {{"y", ""}, {"z", ""}});
  for (int i = 0; i < 2; ++i) {
    for (int j = i; j < 3; j += 2) {
      model.element(i, j) =
          TransferFunction::FirstOrder(10.0 * (i + 1) + j + 1, 5.0, 2.0);
    }
  }
  return model;
}

ExperimentOptions GoodOptions() {
  ExperimentOptions options;
  options.controller.output_weight = 0.2 * Eigen::MatrixXd::Identity(2, 2);
  options.controller.move_weight = 0.1 * Eigen::MatrixXd::Identity(3, 3);
  options.correction.lambdas = Eigen::Vector2d(0.0, 1e-3);
  return options;
}

TEST(ExperimentOptions, ThePapersAreGood) {
  const absl::Status status = GoodOptions().Validate(ExampleModel());
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
      {"--control_period",
       [](Options& o) { o.controller.control_period = 0.3; }},
      {"--duration", [](Options& o) { o.windows.duration = 1e9; }},
      {"--step_time", [](Options& o) { o.windows.step_time = -1.0; }},
      {"--window", [](Options& o) { o.windows.window = 501.0; }},
      {"--setpoint_step", [](Options& o) { o.windows.setpoint_step = 0.0; }},
      {"--prediction_horizon",
       [](Options& o) { o.controller.prediction_horizon = 4; }},
      {"output_weight",
       [](Options& o) { o.controller.output_weight(1, 1) = -1.0; }},
      {"output_weight",
       [&](Options& o) { o.controller.output_weight(1, 1) = nan; }},
      {"move_weight",
       [](Options& o) { o.controller.move_weight.resize(2, 2); }},
      {"--order", [](Options& o) { o.conversion.order = 2000; }},
      {"--conversion_duration",
       [](Options& o) { o.conversion_duration = 100.0; }},
      {"--response_horizon", [](Options& o) { o.response_horizon = 0.6; }},
      {"folds", [](Options& o) { o.correction.selection.folds = 1; }},
  };
  for (const auto& [named, spoil] : cases) {
    ExperimentOptions options = GoodOptions();
    options.correction.selection.rule = Rule::kBlocks;
    spoil(options);
    const absl::Status status = options.Validate(ExampleModel());
    EXPECT_FALSE(status.ok()) << named;
    EXPECT_THAT(std::string(status.message()), HasSubstr(named));
  }
}

TEST(ExperimentOptions, OneOutputAllowsNoChangeToBeLeftOut) {
  ProcessModel model("heater", "min", {{"power", ""}}, {{"temperature", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 1.0);
  ExperimentOptions options = GoodOptions();
  options.controller.output_weight = Eigen::MatrixXd::Ones(1, 1);
  options.controller.move_weight = Eigen::MatrixXd::Ones(1, 1);
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
  options.controller.output_weight = Eigen::MatrixXd::Ones(1, 1);
  options.controller.move_weight = Eigen::MatrixXd::Identity(2, 2);
  EXPECT_THAT(std::string(options.Validate(column).message()),
              HasSubstr("'feed' is a disturbance"));
}

}  // namespace
}  // namespace mle::experiment

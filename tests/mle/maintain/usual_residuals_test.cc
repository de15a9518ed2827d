#include "mle/maintain/usual_residuals.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/maintain/prediction.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using testing::Tank;
using testing::TankRecord;

// A record of which the window is samples 150 to 400.
RecordData DataAround(const Record& record) {
  RecordData data;
  data.records = {record};
  data.report.sample_time = record.sample_time;
  SetPointWindow window;
  window.source = 0;
  window.first_sample = 150;
  window.record = PartOf(record, 150, 250);
  data.windows = {window};
  return data;
}

std::vector<MatrixXd> ResidualsOf(const ProcessModel& model,
                                  const RecordData& data,
                                  const std::vector<Record>& rest) {
  absl::StatusOr<std::vector<MatrixXd>> residuals =
      UsualResiduals(model, data, rest);
  EXPECT_TRUE(residuals.ok()) << residuals.status();
  return residuals.ok() ? *std::move(residuals) : std::vector<MatrixXd>();
}

int ForgettingOf(const ProcessModel& model) {
  return ResponseOf(model, 0.5)->forgetting;
}

TEST(UsualResidualsTest, AreOfWindowsAndOfTheRestAlone) {
  const Record record = TankRecord(Tank(1.0), 0.01, 1);
  const RecordData data = DataAround(record);
  const std::vector<MatrixXd> windows = ResidualsOf(Tank(1.0), data, {});
  ASSERT_EQ(windows.size(), 1);
  ASSERT_EQ(windows[0].cols(), record.samples());
  const std::vector<MatrixXd> both =
      ResidualsOf(Tank(1.0), data, {PartOf(record, 600, 100)});
  ASSERT_EQ(both.size(), 1);
  for (int k = 0; k < record.samples(); ++k) {
    const bool in_window = k >= 150 && k < 400;
    const bool in_rest = k >= 600 && k < 700;
    EXPECT_EQ(std::isfinite(windows[0](0, k)), in_window) << k;
    EXPECT_EQ(std::isfinite(both[0](0, k)), in_window || in_rest) << k;
  }
}

// Of a record that is a window as a whole.
RecordData AsOneWindow(const Record& record) {
  RecordData data = DataAround(record);
  data.windows[0].first_sample = 0;
  data.windows[0].record = record;
  return data;
}

TEST(UsualResidualsTest, BeginWhereInputsBeforeAreForgotten) {
  const Record record = TankRecord(Tank(1.0), 0.01, 1);
  const std::vector<MatrixXd> residuals =
      ResidualsOf(Tank(1.0), AsOneWindow(record), {});
  const int forgetting = ForgettingOf(Tank(1.0));
  ASSERT_GT(forgetting, 3);  // the dead time
  ASSERT_EQ(residuals.size(), 1);
  for (int k = 0; k < record.samples(); ++k) {
    EXPECT_EQ(std::isfinite(residuals[0](0, k)), k >= forgetting) << k;
  }
}

TEST(UsualResidualsTest, AGapInAnInputDividesRuns) {
  Record record = TankRecord(Tank(1.0), 0.01, 1);
  record.inputs.middleCols(500, 3).setConstant(kNaN);
  record.outputs(0, 50) = kNaN;
  const int forgetting = ForgettingOf(Tank(1.0));
  // A run that is too short to say anything.
  record.inputs(0, 503 + forgetting) = kNaN;
  const std::vector<MatrixXd> residuals =
      ResidualsOf(Tank(1.0), AsOneWindow(record), {});
  ASSERT_EQ(residuals.size(), 2);
  EXPECT_EQ(residuals[0].cols(), 500);
  EXPECT_EQ(residuals[1].cols(), record.samples() - 504 - forgetting);
  EXPECT_EQ(residuals[0].array().isFinite().count(), 500 - forgetting - 1);
  EXPECT_TRUE(std::isnan(residuals[0](0, 50)));
  EXPECT_EQ(residuals[1].array().isFinite().count(),
            residuals[1].cols() - forgetting);
}

// What is unknown of an input that moves no output is no gap.
TEST(UsualResidualsTest, InputsThatMoveNothingMayBeMissing) {
  ProcessModel model("tank", "min", {{"valve", "%"}, {"idle", "%"}},
                     {{"level", "m"}});
  model.element(0, 0) = Tank(1.0).element(0, 0);
  Record record = TankRecord(Tank(1.0), 0.01, 1);
  record.inputs.conservativeResize(2, Eigen::NoChange);
  record.inputs.row(1).setConstant(kNaN);
  const std::vector<MatrixXd> residuals =
      ResidualsOf(model, AsOneWindow(record), {});
  ASSERT_EQ(residuals.size(), 1);
  EXPECT_EQ(residuals[0].array().isFinite().count(),
            record.samples() - ForgettingOf(model));
}

// To rounding, once the first inputs are forgotten: the tank begins at rest.
TEST(UsualResidualsTest, ARightModelLeavesTheDisturbance) {
  Record record = TankRecord(Tank(1.0), 0.0, 1);
  const MatrixXd disturbance = GaussianNoise(3, 0, kDriftDisturbance)
                                   .DrawMatrix(1, record.samples(), 0.1);
  record.outputs += disturbance;
  const std::vector<MatrixXd> residuals =
      ResidualsOf(Tank(1.0), AsOneWindow(record), {});
  ASSERT_EQ(residuals.size(), 1);
  for (int k = ForgettingOf(Tank(1.0)); k < record.samples(); ++k) {
    EXPECT_NEAR(residuals[0](0, k), disturbance(0, k), 1e-12) << k;
  }
}

}  // namespace
}  // namespace mle

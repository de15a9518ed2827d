#include "mle/maintain/outlier_search.h"

#include <cmath>
#include <vector>

#include "Eigen/Core"
#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

constexpr int kOutlierSamples = 240;
constexpr double kOutlierNoise = 0.01;

// One output, which answers within two samples.
ProcessModel FastTank() {
  ProcessModel model("tank", "min", {{"valve", ""}}, {{"level", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 1.5, 2.0);
  return model;
}

// Two windows in which the input is moved and, four samples later, moved back:
// the output has a peak narrower than what neighbours look at.
RecordData WithPeaks(const ProcessModel& plant) {
  RecordData data;
  data.report.sample_time = 1.0;
  for (int w = 0; w < 2; ++w) {
    SetPointWindow& window = data.windows.emplace_back();
    window.source = w;
    Record& record = window.record;
    record.start_time = 1000.0 * w;
    record.sample_time = 1.0;
    record.inputs = Eigen::MatrixXd::Zero(1, kOutlierSamples);
    record.inputs.middleCols(100, 4).setConstant(1.0);
    record.outputs = *SimulateResponse(plant, 1.0, record.inputs);
    // Small, and the same at every run.
    for (int k = 0; k < kOutlierSamples; ++k) {
      record.outputs(0, k) += kOutlierNoise * std::sin(2.39996 * k * (k + w));
    }
    data.records.push_back(record);
  }
  return data;
}

OutputErrorOptions OneThread() {
  OutputErrorOptions options;
  options.threads = 1;
  return options;
}

TEST(OutlierSearch, DoesNotTakeAPeakOfTheModelForOutliers) {
  const ProcessModel model = FastTank();
  RecordData data = WithPeaks(model);
  ASSERT_TRUE(
      SearchOutliers(model, RecordOptions(), OneThread(), {}, data).ok());
  EXPECT_TRUE(data.outliers_by_model.empty());
  EXPECT_TRUE(data.notes.empty());
}

TEST(OutlierSearch, AsksTheModelWhereASampleStandsOutOfWhatItLeaves) {
  const ProcessModel model = FastTank();
  RecordData data = WithPeaks(model);
  data.windows[1].record.outputs(0, 180) += 1.0;
  data.windows[1].record.outputs(0, 140) -= 1.0;
  ASSERT_TRUE(
      SearchOutliers(model, RecordOptions(), OneThread(), {}, data).ok());
  EXPECT_EQ(data.outliers_by_model, std::vector<int>{2});
  EXPECT_TRUE(std::isnan(data.windows[1].record.outputs(0, 180)));
  EXPECT_TRUE(std::isnan(data.windows[1].record.outputs(0, 140)));
  EXPECT_FALSE(std::isnan(data.windows[0].record.outputs(0, 140)));
}

// One sample in twenty: it is the model that does not fit.
TEST(OutlierSearch, ManyAreNoOutliers) {
  const ProcessModel model = FastTank();
  RecordData data = WithPeaks(model);
  for (SetPointWindow& window : data.windows) {
    for (int k = 7; k < kOutlierSamples; k += 20) {
      window.record.outputs(0, k) += k % 40 == 7 ? 1.0 : -1.0;
    }
  }
  ASSERT_TRUE(
      SearchOutliers(model, RecordOptions(), OneThread(), {}, data).ok());
  EXPECT_EQ(data.outliers_by_model, std::vector<int>{0});
  for (const SetPointWindow& window : data.windows) {
    EXPECT_TRUE(window.record.outputs.allFinite());
  }
  ASSERT_EQ(data.warnings.size(), 1u);
  EXPECT_EQ(data.warnings[0].code, MessageCode::kUnmeasured);
  EXPECT_EQ(data.warnings[0].place, "level");
}

}  // namespace
}  // namespace mle

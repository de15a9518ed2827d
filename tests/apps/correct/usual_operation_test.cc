#include "apps/correct/usual_operation.h"

#include <memory>
#include <vector>

#include "gtest/gtest.h"

namespace mle::correct {
namespace {

// The level alternates by 1 about its set point, and the valve by 0.5; from
// sample 200 to 300 the plant is shut down.
Record WithShutdown() {
  Record record;
  record.sample_time = 1.0;
  record.outputs.resize(1, 500);
  record.inputs.resize(1, 500);
  record.set_points = Eigen::MatrixXd::Constant(1, 500, 50.0);
  for (int k = 0; k < 500; ++k) {
    const double side = k % 2 == 0 ? 1.0 : -1.0;
    const bool down = k >= 200 && k < 300;
    record.outputs(0, k) = down ? 0.0 : 50.0 + side;
    record.inputs(0, k) = down ? -20.0 : 30.0 + 0.5 * side;
  }
  return record;
}

Result Examined() {
  Result result;
  result.initial =
      ProcessModel("tank", "min", {{"valve", ""}}, {{"level", ""}});
  result.data.lead = 10;
  result.data.records = {WithShutdown()};
  // A window is at the end; before it FindSteadyRecords() leaves the shutdown
  // out.
  const Record& record = result.data.records.front();
  result.data.windows = {
      {.record = PartOf(record, 400, 100), .first_sample = 400}};
  result.options.estimation.output_error.at_rest =
      std::make_shared<const std::vector<Record>>(
          std::vector<Record>{PartOf(record, 0, 150), PartOf(record, 350, 50)});
  return result;
}

TEST(UsualOperationTest, ShutdownsDoNotCount) {
  const Operation operation = OperationIn(Examined());
  EXPECT_NEAR(Deviations(operation.outputs)(0), 1.0, 1e-12);
  EXPECT_NEAR(Deviations(operation.inputs)(0), 0.5, 1e-12);
  EXPECT_EQ(operation.outputs[0].low, 49.0);
  EXPECT_EQ(operation.outputs[0].high, 51.0);
  EXPECT_EQ(operation.inputs[0].low, 29.5);
  EXPECT_EQ(operation.inputs[0].high, 30.5);
}

// A plan begins where the plant stands, wherever that is.
TEST(UsualOperationTest, LastValuesAreThoseOfTheRecords) {
  Result result = Examined();
  result.data.records.front().inputs(0, 499) = 90.0;
  const Operation operation = OperationIn(result);
  EXPECT_EQ(operation.inputs[0].last, 90.0);
  EXPECT_EQ(operation.set_points[0].last, 50.0);
}

}  // namespace
}  // namespace mle::correct

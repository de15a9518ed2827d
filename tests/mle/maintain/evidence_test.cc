#include "mle/maintain/evidence.h"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/mle.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using testing::Tank;
using testing::TankRecord;

// Two tanks side by side, of which only the second one's gain has aged.
CorrectionResult Corrected() {
  ProcessModel model("tanks", "min", {{"valve", "%"}},
                     {{"first", "m"}, {"second", "m"}});
  model.element(0, 0) = model.element(1, 0) = Tank(1.0).element(0, 0);
  std::vector<Record> records;
  for (const int place : {0, 2}) {
    const Record first = TankRecord(Tank(1.0), 0.02, place);
    const Record second = TankRecord(Tank(1.4), 0.02, place + 1);
    Record& both = records.emplace_back(first);
    both.outputs.resize(2, first.samples());
    both.outputs << first.outputs, second.outputs;
    both.set_points.resize(2, first.samples());
    both.set_points << first.set_points, second.set_points;
  }
  CorrectOptions options;
  options.estimation.estimator = Estimator::kOutputError;
  options.make_arx = false;
  options.threads = 1;
  auto result = CorrectFromRecords(model, records, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

// The second tank's gain has changed; its other parameters are set.
TEST(GatherEvidenceTest, WhatNoAgeingDoesIsDoubted) {
  CorrectionResult result = Corrected();
  ASSERT_TRUE(result.estimate.fit.output_error.aged(1, 0));
  ElementEstimate& element =
      result.estimate.fit.output_error.corrected.elements[1];
  const auto code = [&]() -> std::optional<MessageCode> {
    const auto doubt =
        GatherEvidence(result, {false, false}, nullptr).outputs[1].not_ageing;
    if (!doubt.has_value()) return std::nullopt;
    return doubt->code;
  };
  EXPECT_EQ(code(), std::nullopt);
  const ParameterEstimate lag = element.time_scale;
  const ParameterEstimate delay = element.delay;
  element.time_scale.value = 3.0 * lag.initial;
  EXPECT_EQ(code(), std::nullopt);
  // 36.5 min in place of 6.5; and 6.5 of 305, in another unit.
  element.time_scale.value = 7.0 * lag.initial;
  EXPECT_EQ(code(), MessageCode::kBeyondAgeing);
  element.time_scale = lag;
  element.delay.initial = 300.0;
  EXPECT_EQ(code(), MessageCode::kBeyondAgeing);
  // As far as the search goes, though not beyond what ageing does.
  element.delay = delay;
  element.delay.value = 2.0 * delay.initial + lag.initial;
  EXPECT_EQ(code(), MessageCode::kAtBound);
  element.delay.value = 0.0;
  EXPECT_EQ(code(), std::nullopt);
  element.delay = delay;
  ASSERT_FALSE(result.information.pairs.empty());
  result.information.pairs[1].state = PairState::kNotInformed;
  EXPECT_EQ(code(), MessageCode::kNotExcited);
}

// An output that is measured now and then, whose samples may be averages.
TEST(GatherEvidenceTest, StampsMayBeWhatADeadTimeSeems) {
  CorrectionResult result = Corrected();
  ASSERT_TRUE(result.estimate.fit.output_error.aged(1, 0));
  ParameterEstimate& delay =
      result.estimate.fit.output_error.corrected.elements[1].delay;
  delay.value = delay.initial + 2.0;
  delay.standard_error = 0.1;
  const auto is_clock = [&] {
    const auto doubt =
        GatherEvidence(result, {false, false}, nullptr).outputs[1].not_ageing;
    return doubt.has_value() && doubt->code == MessageCode::kClock;
  };
  EXPECT_FALSE(is_clock());
  for (Record& record : result.data.records) {
    for (int k = 0; k < record.samples(); ++k) {
      if (k % 10 != 0) record.outputs(1, k) = std::nan("");
    }
  }
  EXPECT_TRUE(is_clock());
  delay.standard_error = 1.5;
  EXPECT_FALSE(is_clock());
  delay.standard_error = 0.1;
  delay.value = delay.initial + 5.5;  // 5 min are between samples
  EXPECT_FALSE(is_clock());
  delay.value = delay.initial + 2.0;
  result.options.decision.clock_error = 0.0;
  EXPECT_FALSE(is_clock());
  result.options.decision.clock_error = 120.0;
  result.data.sampling = {{}, {.period = 5.0}};
  EXPECT_FALSE(is_clock());
}

}  // namespace
}  // namespace mle

#include "mle/nonlinear/line_search.h"

#include <cmath>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_error_setup.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

// Two records of 1,500 samples every 0.5 min, a tenth of the second one's
// outputs lost.
std::vector<Record> LineRecords(const RecordNoise& noise, unsigned seed) {
  auto records = MakeRecords(TwoElements(), 1500, seed, noise);
  for (int k = 400; k < 1400; k += 10) {
    records[1].outputs(0, k) = std::numeric_limits<double>::quiet_NaN();
  }
  return records;
}

TEST(LineSearchTest, FindsASine) {
  const RecordNoise noise = {
      .variance = 0.01, .amplitude = 0.15, .period = 25.3};
  const auto correction = CorrectByOutputError(
      TwoElements(), LineRecords(noise, 1), OutputErrorOptions());
  ASSERT_TRUE(correction.ok()) << correction.status();
  const NoiseEstimate& found = correction->full.noise[0];
  ASSERT_EQ(found.lines.size(), 1U);
  // A frequency is known to √6 σ/(π A N^1.5), here 1e-5 a sample; five of it.
  EXPECT_NEAR(1.0 / (found.lines[0].period / 0.5), 1.0 / 25.3, 5e-5);
  // σ√(2/N) = 0.004 for each amplitude of two records.
  EXPECT_NEAR(found.lines[0].amplitude, 0.15, 0.015);
  EXPECT_NEAR(found.variance, 0.01, 0.0015);
  EXPECT_FALSE(correction->change_proposed);
  EXPECT_NE(correction->FullReport().find("periodic"), std::string::npos);
}

// Half a period is lost in the middle of each record: counted without it, the
// halves would take each other off.
TEST(LineSearchTest, GapsKeepTheirPlaceInAPeriod) {
  const RecordNoise noise = {
      .variance = 0.01, .amplitude = 0.05, .period = 26.0};
  auto records = MakeRecords(TwoElements(), 1500, 1, noise);
  for (Record& record : records) {
    record.outputs.middleCols(744, 13).setConstant(
        std::numeric_limits<double>::quiet_NaN());
  }
  const auto correction =
      CorrectByOutputError(TwoElements(), records, OutputErrorOptions());
  ASSERT_TRUE(correction.ok()) << correction.status();
  const NoiseEstimate& found = correction->full.noise[0];
  ASSERT_EQ(found.lines.size(), 1U);
  EXPECT_NEAR(found.lines[0].period / 0.5, 26.0, 0.1);
  EXPECT_NEAR(found.lines[0].amplitude, 0.05, 0.01);
}

TEST(LineSearchTest, OtherNoiseHasNoLines) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    RecordNoise noise = {.variance = 0.01};
    if (seed % 3 == 1) noise.increment = 1e-4;
    if (seed % 3 == 2) noise.shock = 0.01;
    noise.pole = 0.9;
    const auto correction = CorrectByOutputError(
        TwoElements(), LineRecords(noise, seed), OutputErrorOptions());
    ASSERT_TRUE(correction.ok()) << correction.status();
    EXPECT_TRUE(correction->full.noise[0].lines.empty()) << seed;
  }
}

// What a wrong gain leaves of the response to an input that is a square wave
// has a period too, but the input explains it. The same residuals beside inputs
// that stand still show a line.
TEST(LineSearchTest, AResponseToTheInputsIsNoLine) {
  const ProcessModel model = TwoElements();
  auto records = LineRecords({.variance = 0.01}, 3);
  for (Record& record : records) {
    auto plant = sim::Plant::Create(model, {.sample_time = 0.5});
    ASSERT_TRUE(plant.ok());
    for (int k = 0; k < record.samples(); ++k) {
      record.outputs(0, k) -= plant->outputs()(0);
      plant->Advance(record.inputs.col(k));
    }
    // A quarter more gain than the model has, in the first input.
    auto wave = sim::Plant::Create(model, {.sample_time = 0.5});
    for (int k = 0; k < record.samples(); ++k) {
      record.inputs.col(k) << (k / 30 % 2 == 0 ? 0.3 : -0.3), 0.0;
      record.outputs(0, k) += 1.25 * wave->outputs()(0);
      wave->Advance(record.inputs.col(k));
    }
  }
  const auto period = [](const std::vector<Record>& of) {
    const auto setups = SetUpOutputs(TwoElements(), of, {});
    EXPECT_TRUE(setups.ok()) << setups.status();
    const OutputSetup& setup = setups->front();
    const OutputFit fit = FitOutput(*setup.problem, setup.start, {false, false},
                                    setup.bounds, {});
    return FindPeriod(
        ExtendedFit(*setup.problem, fit, /*estimate_drift=*/true));
  };
  EXPECT_FALSE(period(records).has_value());
  for (Record& record : records) record.inputs.setZero();
  const auto found = period(records);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->period, 60.0, 0.5);
}

}  // namespace
}  // namespace mle

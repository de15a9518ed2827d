#include "mle/nonlinear/step_search.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_error_setup.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

// Two records of 800 samples every 0.5 min that begin at 50 min, a tenth of the
// first one's outputs lost.
std::vector<Record> StepRecords(const RecordNoise& noise, unsigned seed) {
  auto records = MakeRecords(TwoElements(), 800, seed, noise);
  for (int k = 200; k < 700; k += 10) {
    records[0].outputs(0, k) = std::numeric_limits<double>::quiet_NaN();
  }
  return records;
}

void AddStep(const LevelStep& step, std::vector<Record>& records) {
  Record& record = records[step.record];
  for (int k = 0; k < record.samples(); ++k) {
    record.outputs(0, k) +=
        step.At(record.start_time + k * record.sample_time, record.sample_time);
  }
}

OutputErrorCorrection Correct(const std::vector<Record>& records) {
  auto correction =
      CorrectByOutputError(TwoElements(), records, OutputErrorOptions());
  EXPECT_TRUE(correction.ok()) << correction.status();
  return *std::move(correction);
}

TEST(StepSearchTest, ALevelStep) {
  const LevelStep level = {.record = 1, .time = 200.0, .size = 2.0};
  EXPECT_EQ(level.At(199.5, 0.5), 0.0);
  EXPECT_EQ(level.At(200.0, 0.5), 2.0);
  const LevelStep lagged = {.time = 200.0, .lag = 4.0, .size = 2.0};
  EXPECT_EQ(lagged.At(199.5, 0.5), 0.0);
  EXPECT_NEAR(lagged.At(203.5, 0.5), 2.0 * (1.0 - std::exp(-1.0)), 1e-12);
}

// The level jumps by three standard deviations of the noise; its size is known
// to σ√(4/800), its place to a few samples.
TEST(StepSearchTest, FindsStepsOfTheLevel) {
  const std::vector<LevelStep> steps = {
      {.record = 0, .time = 250.0, .size = 0.3},
      {.record = 1, .time = 310.5, .size = -0.3}};
  for (const double increment : {0.0, 1e-5}) {
    auto records = StepRecords({.variance = 0.01, .increment = increment}, 2);
    for (const LevelStep& step : steps) AddStep(step, records);
    const OutputErrorCorrection correction = Correct(records);
    const NoiseEstimate& noise = correction.full.noise[0];
    ASSERT_EQ(noise.steps.size(), 2U);
    for (const LevelStep& found : noise.steps) {
      const LevelStep& step = steps[found.record];
      EXPECT_NEAR(found.time, step.time, 4.0);
      EXPECT_NEAR(found.size, step.size, increment > 0.0 ? 0.15 : 0.05);
    }
    EXPECT_TRUE(noise.lines.empty());
    EXPECT_NEAR(noise.variance, 0.01, 0.0015);
    EXPECT_FALSE(correction.change_proposed);
    EXPECT_NE(correction.FullReport().find("step "), std::string::npos);
  }
}

TEST(StepSearchTest, FindsTheStepOfALoad) {
  auto records = StepRecords({.variance = 0.01}, 3);
  AddStep({.record = 0, .time = 300.0, .lag = 6.0, .size = 0.8}, records);
  const OutputErrorCorrection correction = Correct(records);
  const NoiseEstimate& noise = correction.full.noise[0];
  ASSERT_EQ(noise.steps.size(), 1U);
  EXPECT_EQ(noise.steps[0].record, 0);
  EXPECT_NEAR(noise.steps[0].time, 300.0, 2.0);
  EXPECT_NEAR(noise.steps[0].lag, 6.0, 3.0);
  EXPECT_NEAR(noise.steps[0].size, 0.8, 0.1);
}

TEST(StepSearchTest, OtherNoiseHasNoSteps) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    RecordNoise noise = {.variance = 0.01, .pole = 0.97, .period = 30.0};
    if (seed % 5 == 1) noise.increment = 1e-4;
    if (seed % 5 == 2) noise.shock = 0.01;
    if (seed % 5 == 3) noise.amplitude = 0.1;
    if (seed % 5 == 4) {
      noise.shock = 0.01;
      noise.lag = 0.9;
    }
    EXPECT_TRUE(Correct(StepRecords(noise, seed)).full.noise[0].steps.empty())
        << seed;
  }
}

// What a wrong gain leaves where an input steps is a step behind the element's
// lag, but the input explains it. The same residuals beside inputs that stand
// still show a step.
TEST(StepSearchTest, AResponseToTheInputsIsNoStep) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(2.6, 4.0, 1.0);
  auto records = StepRecords({.variance = 0.01}, 3);
  for (Record& record : records) {
    auto model = sim::Plant::Create(TwoElements(), {.sample_time = 0.5});
    auto aged = sim::Plant::Create(plant, {.sample_time = 0.5});
    ASSERT_TRUE(model.ok() && aged.ok());
    for (int k = 0; k < record.samples(); ++k) {
      record.outputs(0, k) -= model->outputs()(0);
      model->Advance(record.inputs.col(k));
    }
    for (int k = 0; k < record.samples(); ++k) {
      record.inputs.col(k) << (k < 400 ? 0.0 : 0.5), 0.0;
      record.outputs(0, k) += aged->outputs()(0);
      aged->Advance(record.inputs.col(k));
    }
  }
  const auto step = [](const std::vector<Record>& of) {
    const auto setups = SetUpOutputs(TwoElements(), of, {});
    EXPECT_TRUE(setups.ok()) << setups.status();
    const OutputSetup& setup = setups->front();
    const OutputFit fit = FitOutput(*setup.problem, setup.start, {false, false},
                                    setup.bounds, {});
    return FindStep(ExtendedFit(*setup.problem, fit, /*estimate_drift=*/true));
  };
  EXPECT_FALSE(step(records).has_value());
  for (Record& record : records) {
    auto model = sim::Plant::Create(TwoElements(), {.sample_time = 0.5});
    for (int k = 0; k < record.samples(); ++k) {
      record.outputs(0, k) -= model->outputs()(0);
      model->Advance(record.inputs.col(k));
    }
    record.inputs.setZero();
  }
  const auto found = step(records);
  ASSERT_TRUE(found.has_value());
  // The dead time is two samples.
  EXPECT_NEAR(found->step.sample, 402, 6);
}

// What a fit of first order leaves of an element of second order is a step
// behind a lag, not far from where the input moved; few moves show that it is
// none.
TEST(StepSearchTest, AnElementOfSecondOrderHasNoSteps) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) =
      TransferFunction({2.0}, {2.0 * 3.0, 2.0 + 3.0, 1.0}, 1.0);
  for (unsigned seed = 1; seed <= 4; ++seed) {
    auto records = StepRecords({.variance = 1e-4}, seed);
    for (std::size_t r = 0; r < records.size(); ++r) {
      Record& record = records[r];
      auto second = sim::Plant::Create(plant, {.sample_time = 0.5});
      ASSERT_TRUE(second.ok());
      std::mt19937_64 engine(seed + 10 * r);
      std::normal_distribution<double> normal;
      for (int k = 0; k < 800; ++k) {
        record.inputs.col(k) << (r == 0 && k >= 200 ? 1.0 : 0.0),
            (r == 1 && k >= 300 ? 1.0 : 0.0);
        record.outputs(0, k) = second->outputs()(0) + 0.01 * normal(engine);
        second->Advance(record.inputs.col(k));
      }
    }
    EXPECT_TRUE(Correct(records).full.noise[0].steps.empty()) << seed;
  }
}

}  // namespace
}  // namespace mle

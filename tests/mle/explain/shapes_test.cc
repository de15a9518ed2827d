// What gains, time constants and dead times of single elements do not describe:
// other shapes, new paths, and models that are wrong in everything.

#include <cmath>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/explain/competition.h"
#include "mle/explain/explained_output.h"
#include "mle/explain/instruments.h"
#include "mle/explain/several_steps.h"
#include "mle/model/element_response.h"
#include "mle/model/process_simulator.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

// The record of two loops, with what a plant does beyond them.
Record RecordOf(const ProcessModel& plant, unsigned seed) {
  Happening quiet;
  quiet.noise = 0.005;
  quiet.drift = 0.003;
  Record record = CloseLoops(TwoLoops(), seed, quiet);
  record.outputs +=
      *SimulateResponse(plant, record.sample_time, record.inputs) -
      *SimulateResponse(TwoLoops(), record.sample_time, record.inputs);
  return record;
}

Competition CompeteFor(const ProcessModel& model, const Record& record) {
  auto competition = Competition::Run(model, {record}, {});
  EXPECT_TRUE(competition.ok()) << competition.status();
  return *std::move(competition);
}

double Distance(const TransferFunction& a, const TransferFunction& b) {
  return (a.StepResponse(1.0, 100) - b.StepResponse(1.0, 100)).norm();
}

TEST(ShapesTest, ALeadAndASecondLagAreFound) {
  const std::vector<TransferFunction> shapes = {
      TransferFunction({34.0, 2.0}, {40.0, 14.0, 1.0}, 2.0),
      TransferFunction({-16.0, 2.0}, {40.0, 14.0, 1.0}, 2.0),
      TransferFunction({2.0}, {36.0, 12.0, 1.0}, 2.0)};
  for (const TransferFunction& shape : shapes) {
    ProcessModel plant = TwoLoops();
    plant.element(0, 0) = shape;
    const Competition competition = CompeteFor(TwoLoops(), RecordOf(plant, 5));
    bool shaped = false;
    for (const TakenExplanation& one : competition.outputs()[0].taken) {
      shaped = shaped ||
               (IsShape(one.explanation.kind) && one.explanation.index == 0);
    }
    EXPECT_TRUE(shaped);
    const auto element =
        competition.ElementOf(0, 0, competition.Explained(0, 0));
    ASSERT_TRUE(element.ok()) << element.status();
    EXPECT_LT(Distance(*element, shape),
              0.3 * Distance(TwoLoops().element(0, 0), shape));
    EXPECT_TRUE(competition.outputs()[1].taken.empty());
  }
}

TEST(ShapesTest, APathThatTheModelDoesNotHaveIsFound) {
  ProcessModel model = TwoLoops();
  model.element(1, 0) = TransferFunction();
  const Competition competition = CompeteFor(model, CloseLoops(TwoLoops(), 4));
  const OutputExplanation& output = competition.outputs()[1];
  ASSERT_FALSE(output.taken.empty());
  EXPECT_EQ(output.taken[0].explanation.kind, ExplanationKind::kNewPath);
  EXPECT_EQ(output.taken[0].explanation.index, 0);
  const auto element = competition.ElementOf(1, 0, competition.Explained(1, 0));
  ASSERT_TRUE(element.ok()) << element.status();
  const TransferFunction truth = TwoLoops().element(1, 0);
  EXPECT_LT(Distance(*element, truth),
            0.2 * truth.StepResponse(1.0, 100).norm());
  const double error = std::sqrt(competition.Covariance(1, 0)(0, 0));
  EXPECT_GT(error, 0.0);
  EXPECT_LT(std::abs(element->StaticGain() - truth.StaticGain()),
            4.0 * error + 0.02);
  EXPECT_TRUE(competition.outputs()[0].taken.empty());
}

// No path is found from what there is one.
TEST(ShapesTest, WhatIsThereIsNoNewPath) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    ProcessModel model = TwoLoops();
    model.element(1, 0) = TransferFunction();
    const Competition competition = CompeteFor(model, RecordOf(model, seed));
    EXPECT_TRUE(competition.outputs()[0].taken.empty()) << seed;
    EXPECT_TRUE(competition.outputs()[1].taken.empty()) << seed;
  }
}

// Everything in a row is wrong: a single explanation hides the others, a fit of
// all at once does not.
TEST(SeveralStepsTest, AModelThatIsWrongInEverythingIsFitted) {
  ProcessModel model = TwoLoops();
  model.element(0, 0) = TransferFunction::FirstOrder(1.2, 17.0, 0.5);
  model.element(0, 1) = TransferFunction::FirstOrder(1.1, 9.0, 5.0);
  const std::vector<Record> records = {CloseLoops(TwoLoops(), 6)};
  const auto output = ExplainedOutput::Create(model, records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  const auto instruments = Instruments::Create(model, *output);
  ASSERT_TRUE(instruments.ok()) << instruments.status();
  const SeveralStepsFit fit = SeveralSteps(*output, *instruments)
                                  .Best(/*second_lags=*/false, /*most=*/3.0);
  ASSERT_GE(fit.explanations.size(), 4u);
  ASSERT_EQ(fit.covariance.rows(),
            static_cast<Eigen::Index>(fit.explanations.size()));
  for (int j = 0; j < 2; ++j) {
    const ElementValues values = output->Aged(j, fit.explanations);
    const TransferFunction truth = TwoLoops().element(0, j);
    EXPECT_LT(Distance(TransferFunction::FirstOrder(
                           values.gain, values.time_scale, values.delay),
                       truth),
              0.35 * Distance(model.element(0, j), truth));
  }
  for (std::size_t i = 0; i < fit.explanations.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_GT(std::abs(fit.explanations[i].value),
              1.9 * std::sqrt(fit.covariance(k, k)));
  }
  ASSERT_FALSE(fit.held_out.empty());
  for (const HorizonErrors& error : fit.held_out) {
    EXPECT_LT(error.explained, 0.7 * error.initial);
  }
}

// A model that is right stays.
TEST(SeveralStepsTest, NothingIsSignificantWhereNothingHappened) {
  int changed = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Competition competition =
        CompeteFor(TwoLoops(), CloseLoops(TwoLoops(), seed));
    for (const OutputExplanation& output : competition.outputs()) {
      changed += output.together ? 1 : 0;
    }
  }
  EXPECT_EQ(changed, 0);
}

}  // namespace
}  // namespace mle

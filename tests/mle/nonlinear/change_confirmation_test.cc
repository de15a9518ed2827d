#include "mle/nonlinear/change_confirmation.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "gtest/gtest.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

constexpr double kLevel = 1e-3;

// The output of `model` set up for records of `plant`, all elements fitted.
struct FittedSetup {
  std::vector<OutputSetup> setups;
  OutputFit fit;

  const OutputSetup& setup() const { return setups[0]; }
  ConfirmedChanges Confirm(const std::vector<bool>& named) const {
    return Confirm(named, std::vector<bool>(named.size(), false));
  }
  ConfirmedChanges Confirm(const std::vector<bool>& named,
                           const std::vector<bool>& certain) const {
    return ConfirmChanges(setup(), {{.weight = 1.0, .fit = &fit}}, named,
                          certain, kLevel, {});
  }
  double Squares(const OutputPoint& point) const {
    const OutputErrorProblem& problem = *setup().problem;
    const NoiseShape shape = ShapeOf(fit.noise);
    return problem.Whiten(problem.Linearise(point, shape, {}), shape)
        .residuals.squaredNorm();
  }
};

FittedSetup FitTo(const ProcessModel& model,
                  const std::vector<Record>& records) {
  auto setups = SetUpOutputs(model, records, {});
  EXPECT_TRUE(setups.ok()) << setups.status();
  FittedSetup fitted{*std::move(setups), {}};
  const OutputSetup& setup = fitted.setup();
  fitted.fit =
      FitOutput(*setup.problem, setup.start,
                std::vector<bool>(model.num_inputs(), true), setup.bounds, {});
  return fitted;
}

// Both elements by a gain.
ProcessModel BothAged() {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(2.6, 4.0, 1.0);
  plant.element(0, 1) = TransferFunction::FirstOrder(-3.6, 6.0, 2.3);
  return plant;
}

TEST(ChangeConfirmationTest, NoiseConfirmsNothing) {
  const ProcessModel model = TwoElements();
  int confirmed = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const FittedSetup fitted =
        FitTo(model, MakeRecords(model, 400, seed, {.variance = 0.01}));
    const ConfirmedChanges changes = fitted.Confirm({true, true});
    for (int j = 0; j < 2; ++j) {
      confirmed += changes.changed[j] ? 1 : 0;
      EXPECT_EQ(changes.changed[j], changes.p_values[j] < kLevel);
      if (changes.changed[j]) continue;
      EXPECT_EQ(changes.point.values[j].gain,
                fitted.setup().start.values[j].gain);
    }
  }
  // 20 tests at 0.001.
  EXPECT_LE(confirmed, 1);
}

// One that is named in place of another, as Wald's test does where inputs move
// together, is not what has changed.
TEST(ChangeConfirmationTest, TheChangeOfOneElementThatExplainsMoreIsNamed) {
  const ProcessModel model = TwoElements();
  for (const int aged : {0, 1}) {
    ProcessModel plant = model;
    plant.element(0, aged) = aged == 0
                                 ? TransferFunction::FirstOrder(2.6, 4.0, 1.0)
                                 : TransferFunction::FirstOrder(-3.6, 6.0, 2.3);
    const FittedSetup fitted =
        FitTo(model, MakeRecords(plant, 400, 3, {.variance = 0.01}));
    const ConfirmedChanges changes = fitted.Confirm({aged == 1, aged == 0});
    EXPECT_TRUE(changes.changed[aged]);
    EXPECT_FALSE(changes.changed[1 - aged]);
    EXPECT_LT(changes.p_values[aged], 1e-10);
    EXPECT_GT(changes.statistics[aged], 100.0);
    EXPECT_TRUE(changes.restarted);
    EXPECT_NEAR(changes.point.values[aged].gain, aged == 0 ? 2.6 : -3.6, 0.05);
    EXPECT_EQ(changes.point.values[1 - aged].gain,
              fitted.setup().start.values[1 - aged].gain);
  }
}

// What is certain is not tested, and a rival has it too.
TEST(ChangeConfirmationTest, CertainElementsStay) {
  const ProcessModel model = TwoElements();
  ProcessModel plant = model;
  plant.element(0, 1) = TransferFunction::FirstOrder(-3.6, 6.0, 2.3);
  const FittedSetup fitted =
      FitTo(model, MakeRecords(plant, 400, 3, {.variance = 0.01}));
  const ConfirmedChanges asked = fitted.Confirm({true, true});
  EXPECT_FALSE(asked.changed[0]);
  const ConfirmedChanges changes = fitted.Confirm({true, true}, {true, false});
  EXPECT_TRUE(changes.changed[0]);
  EXPECT_EQ(changes.p_values[0], 0.0);
  EXPECT_EQ(changes.statistics[0], 0.0);
  EXPECT_TRUE(changes.changed[1]);
  EXPECT_GT(changes.statistics[1], 100.0);
  // Named alone, it is joined by what has changed.
  const ConfirmedChanges added = fitted.Confirm({true, false}, {true, false});
  EXPECT_TRUE(added.changed[0]);
  EXPECT_TRUE(added.changed[1]);
  // All certain: nothing is left to test.
  const ConfirmedChanges all = fitted.Confirm({true, true}, {true, true});
  EXPECT_EQ(all.changed, std::vector<bool>({true, true}));
  EXPECT_EQ(all.p_values, std::vector<double>({0.0, 0.0}));
}

// Two changes that nothing names are both found, and account for the records.
TEST(ChangeConfirmationTest, WhatIsNotNamedIsFound) {
  const ProcessModel model = TwoElements();
  const FittedSetup fitted =
      FitTo(model, MakeRecords(BothAged(), 400, 3, {.variance = 0.01}));
  const ConfirmedChanges changes = fitted.Confirm({false, false});
  EXPECT_EQ(changes.changed, (std::vector<bool>{true, true}));
  EXPECT_TRUE(changes.restarted);
  EXPECT_NEAR(changes.point.values[0].gain, 2.6, 0.05);
  EXPECT_NEAR(changes.point.values[1].gain, -3.6, 0.05);
  EXPECT_EQ(fitted.Confirm({true, false}).changed, changes.changed);
}

// Where nothing has changed nothing is missing, as often as the level says.
TEST(ChangeConfirmationTest, OfNoChangeNothingIsMissing) {
  const ProcessModel model = TwoElements();
  int found = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const FittedSetup fitted =
        FitTo(model, MakeRecords(model, 400, seed, {.variance = 0.01}));
    const ConfirmedChanges changes = fitted.Confirm({false, false});
    for (const bool changed : changes.changed) found += changed ? 1 : 0;
  }
  EXPECT_EQ(found, 0);
}

// Two inputs that are nearly the same: either element explains the records, and
// the one whose gain need not change its sign and its size is named.
TEST(ChangeConfirmationTest, ChangesThatArePlausibleAreNamed) {
  ProcessModel model = MakeModel(1, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(3.0, 5.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(0.2, 5.0, 1.0);
  ProcessModel plant = model;
  plant.element(0, 0) = TransferFunction::FirstOrder(2.2, 5.0, 1.0);
  std::vector<Record> records = MakeRecords(plant, 400, 3, {.variance = 0.01});
  std::mt19937_64 source(4);
  std::normal_distribution<double> normal;
  for (Record& record : records) {
    record.inputs.row(1) = record.inputs.row(0) + 0.01 * record.inputs.row(1);
    record.outputs =
        *SimulateResponse(plant, record.sample_time, record.inputs);
    for (double& y : record.outputs.reshaped()) y += 0.1 * normal(source);
  }
  const FittedSetup fitted = FitTo(model, records);
  for (const bool wrong : {false, true}) {
    const ConfirmedChanges changes = fitted.Confirm({false, wrong});
    EXPECT_EQ(changes.changed, (std::vector<bool>{true, false}));
    EXPECT_NEAR(changes.point.values[0].gain, 2.2, 0.1);
  }
}

// Two that are named share the change of a third, whose input is nearly the sum
// of theirs: neither may leave, and nothing is missing.
TEST(ChangeConfirmationTest, OneChangeStandsInPlaceOfTwoThatShareIt) {
  ProcessModel model = MakeModel(1, 3);
  for (int j = 0; j < 3; ++j) {
    model.element(0, j) = TransferFunction::FirstOrder(1.0, 5.0, 1.0);
  }
  ProcessModel plant = model;
  plant.element(0, 2) = TransferFunction::FirstOrder(0.7, 5.0, 1.0);
  std::mt19937_64 source(4);
  std::normal_distribution<double> normal;
  std::vector<Record> records = MakeRecords(plant, 600, 3, {.variance = 0.01});
  for (Record& record : records) {
    record.inputs.row(2) = record.inputs.row(0) + record.inputs.row(1) +
                           0.02 * record.inputs.row(2);
    record.outputs =
        *SimulateResponse(plant, record.sample_time, record.inputs);
    for (double& y : record.outputs.reshaped()) y += 0.1 * normal(source);
  }
  const FittedSetup fitted = FitTo(model, records);
  const ConfirmedChanges changes = fitted.Confirm({true, true, false});
  EXPECT_EQ(changes.changed, (std::vector<bool>{false, false, true}));
  EXPECT_TRUE(changes.restarted);
  EXPECT_NEAR(changes.point.values[2].gain, 0.7, 0.05);
  EXPECT_EQ(changes.point.values[0].gain, 1.0);
}

// A small change that is named beside a large one stays as soon as it counts,
// although without it nothing is missing of six elements: one change fewer is
// no better account.
TEST(ChangeConfirmationTest, FewerChangesMustNotCostMore) {
  ProcessModel model = MakeModel(1, 6);
  for (int j = 0; j < 6; ++j) {
    model.element(0, j) =
        TransferFunction::FirstOrder(1.0 + 0.2 * j, 4.0 + j, 1.0 + 0.3 * j);
  }
  double p_value = 1.0;
  for (int step = 1; step < 40 && p_value == 1.0; ++step) {
    ProcessModel plant = model;
    plant.element(0, 0) = TransferFunction::FirstOrder(1.4, 4.0, 1.0);
    plant.element(0, 1) =
        TransferFunction::FirstOrder(1.2 + 0.002 * step, 5.0, 1.3);
    const FittedSetup fitted =
        FitTo(model, MakeRecords(plant, 400, 3, {.variance = 0.01}));
    const ConfirmedChanges changes =
        fitted.Confirm({true, true, false, false, false, false});
    EXPECT_TRUE(changes.changed[0]);
    if (changes.changed[1]) p_value = changes.p_values[1];
  }
  EXPECT_LT(p_value, kLevel);
  EXPECT_GT(p_value, 0.1 * kLevel);
}

// Of two that have changed none is a rival of both.
TEST(ChangeConfirmationTest, TwoChangesHaveNoRival) {
  const ProcessModel model = TwoElements();
  const FittedSetup fitted =
      FitTo(model, MakeRecords(BothAged(), 400, 3, {.variance = 0.01}));
  EXPECT_EQ(fitted.Confirm({true, true}).changed,
            (std::vector<bool>{true, true}));
}

TEST(ChangeConfirmationTest, WhatHasChangedStays) {
  const ProcessModel model = TwoElements();
  ProcessModel plant = model;
  plant.element(0, 0) = TransferFunction::FirstOrder(2.2, 4.0, 1.0);
  const FittedSetup fitted =
      FitTo(model, MakeRecords(plant, 400, 3, {.variance = 0.01}));
  const ConfirmedChanges changes = fitted.Confirm({true, true});
  EXPECT_TRUE(changes.changed[0]);
  EXPECT_FALSE(changes.changed[1]);
  EXPECT_NEAR(changes.point.values[0].gain, 2.2, 0.05);
  EXPECT_EQ(changes.point.values[1].gain, -3.0);
  // The likelihood ratio against the initial model.
  const double r = fitted.fit.noise.variance * fitted.fit.inflation.statistic;
  const double ratio =
      (fitted.Squares(fitted.setup().start) - fitted.Squares(changes.point)) /
      r;
  EXPECT_NEAR(changes.statistics[0], ratio, 1e-9 * ratio);
}

// What is not named is asked nothing.
TEST(ChangeConfirmationTest, OthersStayAsTheyWere) {
  const ProcessModel model = TwoElements();
  ProcessModel plant = model;
  plant.element(0, 0) = TransferFunction::FirstOrder(2.2, 4.0, 1.0);
  const FittedSetup fitted =
      FitTo(model, MakeRecords(plant, 400, 3, {.variance = 0.01}));
  const ConfirmedChanges changes = fitted.Confirm({true, false});
  EXPECT_EQ(changes.changed, (std::vector<bool>{true, false}));
  EXPECT_EQ(changes.statistics[1], 0.0);
  EXPECT_EQ(changes.p_values[1], 1.0);
}

// A fit that has ended beside the minimum, with an error that calls it a
// change: from the initial values a better one is found, and nothing is gained.
TEST(ChangeConfirmationTest, AnEstimateBesideTheMinimumIsNoChange) {
  const ProcessModel model = TwoElements();
  FittedSetup fitted =
      FitTo(model, MakeRecords(model, 400, 5, {.variance = 0.01}));
  ElementValues& values = fitted.fit.point.values[1];
  values.delay += 0.9 * values.time_scale;
  values.time_scale *= 0.1;
  fitted.fit.point.SetCells(fitted.setup().problem->sample_time());
  const ConfirmedChanges changes = fitted.Confirm({false, true});
  EXPECT_FALSE(changes.changed[1]);
  EXPECT_GT(changes.p_values[1], kLevel);
}

// The same beside an element that has changed: the better fit is found.
TEST(ChangeConfirmationTest, ABetterFitIsFoundFromTheInitialValues) {
  const ProcessModel model = TwoElements();
  ProcessModel plant = model;
  plant.element(0, 1) = TransferFunction::FirstOrder(-3.6, 6.0, 2.3);
  FittedSetup fitted =
      FitTo(model, MakeRecords(plant, 400, 5, {.variance = 0.01}));
  EXPECT_FALSE(fitted.Confirm({false, true}).restarted);
  const OutputSetup& setup = fitted.setup();
  ElementValues& values = fitted.fit.point.values[1];
  values = {.gain = -0.5,
            .time_scale = setup.bounds.min_time_scales[1],
            .delay = 0.0};
  fitted.fit.point.SetCells(setup.problem->sample_time());
  const ConfirmedChanges changes = fitted.Confirm({false, true});
  EXPECT_TRUE(changes.changed[1]);
  EXPECT_NEAR(changes.point.values[1].gain, -3.6, 0.1);
  EXPECT_NEAR(changes.point.values[1].time_scale, 6.0, 0.5);
}

// Equal time constants have one free response between them in each record. A
// fit that moves them apart has one more in each, which explains noise.
TEST(ChangeConfirmationTest, FreeResponsesOfManyRecordsAreNoChange) {
  ProcessModel model = MakeModel(1, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 4.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-3.0, 4.0, 1.5);
  std::vector<Record> records;
  for (unsigned r = 0; r < 40; ++r) {
    records.push_back(MakeRecord(model, 120, 700 + r, {.variance = 0.01}));
  }
  const FittedSetup fitted = FitTo(model, records);
  const ConfirmedChanges changes = fitted.Confirm({true, true});
  EXPECT_EQ(changes.changed, (std::vector<bool>{false, false}));
  // The ratio is one that three degrees of freedom would not have explained.
  double largest = 0.0;
  for (const double statistic : changes.statistics) {
    largest = std::max(largest, statistic);
  }
  EXPECT_LT(ChiSquareTail(largest, 3.0), kLevel);
}

// Of two assumptions that are the same the ratio is that of either.
TEST(ChangeConfirmationTest, AssumptionsAreAveraged) {
  const ProcessModel model = TwoElements();
  ProcessModel plant = model;
  plant.element(0, 1) = TransferFunction::FirstOrder(-3.1, 6.0, 2.3);
  const FittedSetup fitted =
      FitTo(model, MakeRecords(plant, 400, 4, {.variance = 0.01}));
  const ConfirmedChanges one = fitted.Confirm({false, true});
  const ConfirmedChanges two =
      ConfirmChanges(fitted.setup(),
                     {{.weight = 0.3, .fit = &fitted.fit},
                      {.weight = 0.7, .fit = &fitted.fit}},
                     {false, true}, {false, false}, kLevel, {});
  EXPECT_NEAR(two.statistics[1], one.statistics[1], 1e-9 * one.statistics[1]);
  // Under ten times the noise a tenth of it is left, which bounds the average.
  OutputFit noisy = fitted.fit;
  noisy.noise.variance *= 10.0;
  const ConfirmedChanges mixed = ConfirmChanges(
      fitted.setup(),
      {{.weight = 0.5, .fit = &fitted.fit}, {.weight = 0.5, .fit = &noisy}},
      {false, true}, {false, false}, kLevel, {});
  EXPECT_NEAR(mixed.statistics[1],
              0.1 * one.statistics[1] + 2.0 * std::log(2.0),
              1e-3 * one.statistics[1]);
}

}  // namespace
}  // namespace mle

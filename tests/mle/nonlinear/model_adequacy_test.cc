#include "mle/nonlinear/model_adequacy.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_problem.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

ModelAdequacy Check(const ProcessModel& model,
                    const std::vector<Record>& records,
                    const AdequacyOptions& options = {}) {
  const auto adequacy = TestAdequacy(model, records, options);
  EXPECT_TRUE(adequacy.ok()) << adequacy.status();
  return *adequacy;
}

// Alarms come at the rate asked for, white noise, offsets or drift: 60 records
// at 5 % give 3, and more than 9 once in a thousand.
TEST(ModelAdequacyTest, KeepsTheRateOfFalseAlarms) {
  AdequacyOptions options;
  options.false_alarm_probability = 0.05;
  for (const RecordNoise& noise :
       {RecordNoise{.variance = 1e-2},
        RecordNoise{.variance = 1e-2, .offset = 0.7},
        RecordNoise{.variance = 1e-2, .increment = 1e-3}}) {
    int alarms = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
      const auto records = MakeRecords(TwoElements(), 400, 300 + seed, noise);
      alarms += Check(TwoElements(), records, options).adequate ? 0 : 1;
    }
    EXPECT_LE(alarms, 9) << "increment " << noise.increment << ", offset "
                         << noise.offset;
  }
}

// Whatever is wrong, of one element of two.
TEST(ModelAdequacyTest, FindsWhatIsWrong) {
  std::vector<ProcessModel> plants(5, TwoElements());
  plants[0].element(0, 0) = TransferFunction::FirstOrder(1.6, 4.0, 1.0);
  plants[1].element(0, 0) = TransferFunction::FirstOrder(2.0, 4.0, 2.5);
  plants[2].element(0, 0) = TransferFunction::FirstOrder(2.0, 6.0, 1.0);
  // 2 (3s + 1) / ((4s + 1)(1.5s + 1))
  plants[3].element(0, 0) = TransferFunction({6.0, 2.0}, {6.0, 5.5, 1.0}, 1.0);
  plants[4].element(0, 0) = TransferFunction();
  for (std::size_t i = 0; i < plants.size(); ++i) {
    const auto records = MakeRecords(plants[i], 400, 7, {.variance = 1e-3});
    const ModelAdequacy adequacy = Check(TwoElements(), records);
    EXPECT_FALSE(adequacy.adequate) << "plant " << i;
    EXPECT_LT(adequacy.p_value, 1e-6);
  }
}

// An element that the model has not.
TEST(ModelAdequacyTest, FindsAMissingElement) {
  ProcessModel plant = MakeModel(2, 2);
  plant.element(0, 0) = TransferFunction::FirstOrder(2.0, 4.0, 1.0);
  plant.element(0, 1) = TransferFunction::FirstOrder(-3.0, 6.0, 2.3);
  plant.element(1, 1) = TransferFunction::FirstOrder(1.0, 5.0, 0.7);
  ProcessModel aged = plant;
  aged.element(1, 0) = TransferFunction::FirstOrder(0.5, 3.0, 1.5);
  const auto records = MakeRecords(aged, 400, 11, {.variance = 1e-3});
  const ModelAdequacy adequacy = Check(plant, records);
  EXPECT_FALSE(adequacy.adequate);
  EXPECT_TRUE(Check(aged, records).adequate);
}

// In other units of the outputs nothing changes.
TEST(ModelAdequacyTest, DoesNotDependOnUnits) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.9, 4.0, 1.0);
  auto records = MakeRecords(plant, 400, 3, {.variance = 1e-2});
  const ModelAdequacy before = Check(TwoElements(), records);
  ProcessModel scaled = TwoElements();
  scaled.element(0, 0) = TransferFunction::FirstOrder(2000.0, 4.0, 1.0);
  scaled.element(0, 1) = TransferFunction::FirstOrder(-3000.0, 6.0, 2.3);
  for (Record& record : records) record.outputs *= 1000.0;
  const ModelAdequacy after = Check(scaled, records);
  EXPECT_EQ(before.degrees_of_freedom, after.degrees_of_freedom);
  EXPECT_NEAR(before.statistic, after.statistic, 1e-6 * before.statistic);
}

// An input that does not move, or is not known, says nothing.
TEST(ModelAdequacyTest, PassesOverInputsThatSayNothing) {
  ProcessModel model = MakeModel(1, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 4.0, 1.0);
  const auto whole = MakeRecords(model, 400, 9, {.variance = 1e-2});
  const int degrees = Check(model, whole).degrees_of_freedom;
  for (const double value : {3.0, std::numeric_limits<double>::quiet_NaN()}) {
    auto records = whole;
    for (Record& record : records) record.inputs.row(1).setConstant(value);
    const ModelAdequacy adequacy = Check(model, records);
    EXPECT_EQ(adequacy.degrees_of_freedom, degrees / 2);
    EXPECT_TRUE(adequacy.adequate);
  }
}

TEST(ModelAdequacyTest, NamesWhatIsInvalid) {
  const auto records = MakeRecords(TwoElements(), 400, 1, {.variance = 1e-2});
  AdequacyOptions alarms;
  alarms.false_alarm_probability = 1.0;
  EXPECT_THAT(TestAdequacy(TwoElements(), records, alarms).status().message(),
              HasSubstr("false_alarm_probability is 1, must be between"));
  EXPECT_FALSE(TestAdequacy(TwoElements(), {}, {}).ok());
}

// Against sums written out.
TEST(OutputErrorProblemTest, LagSumsAreSumsOverLags) {
  const ProcessModel model = TwoElements();
  const Record record = MakeRecord(model, 60, 1, {});
  OutputErrorProblem::Elements elements(2);
  for (int j = 0; j < 2; ++j) {
    elements[j] = *ElementResponse::Create(model.element(0, j));
  }
  const OutputErrorProblem problem(std::move(elements), {record}, 0, 5, 10);
  const auto sums = problem.LagSums({0, 1, 3, 9});
  ASSERT_EQ(sums.size(), 1U);
  ASSERT_EQ(sums[0].rows(), 55);
  ASSERT_EQ(sums[0].cols(), 6);
  const int bounds[] = {0, 1, 3, 9};
  for (int row = 0; row < 55; ++row) {
    for (int j = 0; j < 2; ++j) {
      for (int b = 0; b < 3; ++b) {
        double expected = 0.0;
        for (int lag = bounds[b]; lag < bounds[b + 1]; ++lag) {
          expected += record.inputs(j, std::max(row + 5 - lag, 0)) -
                      record.inputs(j, 0);
        }
        EXPECT_NEAR(sums[0](row, 3 * j + b), expected, 1e-12);
      }
    }
  }
}

}  // namespace
}  // namespace mle

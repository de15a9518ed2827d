#include "mle/nonlinear/level_dependence.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/distributions.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using FittedElements = Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>;

constexpr double kRange = 3.0;

// The first input is a valve: v = u + c u²/3 moves the plant, u is recorded.
std::vector<Record> ValveRecords(double curvature, unsigned seed,
                                 double variance = 0.01) {
  std::vector<Record> records =
      MakeRecords(TwoElements(), 400, seed, {.variance = variance});
  for (Record& record : records) {
    if (curvature == 0.0) continue;
    for (double& u : record.inputs.row(0)) {
      const double c = curvature / kRange;
      u = (std::sqrt(1.0 + 4.0 * c * u) - 1.0) / (2.0 * c);
    }
  }
  return records;
}

std::vector<LevelDependence> Tested(const std::vector<Record>& records) {
  FittedElements fitted = FittedElements::Constant(1, 2, true);
  auto tested = TestLevelDependence(TwoElements(), records, fitted, {},
                                    std::vector<NoiseEstimate>(1));
  EXPECT_TRUE(tested.ok()) << tested.status();
  return *std::move(tested);
}

TEST(LevelDependence, OfAValveIsFoundWithItsCurvature) {
  const std::vector<LevelDependence> inputs = Tested(ValveRecords(0.2, 1));
  ASSERT_EQ(inputs.size(), 2);
  EXPECT_LT(inputs[0].p_value, 1e-6);
  EXPECT_EQ(inputs[0].variation(), 2.0 * inputs[0].curvature);
  // χ² of one parameter, for one output.
  EXPECT_NEAR(
      ChiSquareTail(std::pow(inputs[1].curvature / inputs[1].error, 2), 1),
      inputs[1].p_value, 1e-6);
  EXPECT_NEAR(inputs[1].LargestVariation() - inputs[1].variation(),
              4.0 * inputs[1].error, 1e-12);
  EXPECT_GT(inputs[1].p_value, 1e-4);
}

// c of (u − ū)²/h, h the largest distance of the records' own inputs from ū.
TEST(LevelDependence, IsTheCurvatureOverTheRangeOfTheInput) {
  const std::vector<Record> records = ValveRecords(0.2, 1, 1e-5);
  double mean = 0.0;
  for (const Record& record : records) {
    mean += record.inputs.row(0).mean() / static_cast<double>(records.size());
  }
  double range = 0.0;
  for (const Record& record : records) {
    range =
        std::max(range, (record.inputs.row(0).array() - mean).abs().maxCoeff());
  }
  const double curvature = 0.2 / kRange * range;
  const LevelDependence input = Tested(records)[0];
  EXPECT_GT(curvature, 10.0 * input.error);
  EXPECT_NEAR(input.curvature, curvature, 0.02 * curvature);
}

TEST(LevelDependence, OfNothingIsRare) {
  int alarms = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const LevelDependence& input : Tested(ValveRecords(0.0, seed))) {
      alarms += input.p_value < 0.05 ? 1 : 0;
    }
  }
  // Of 40 tests; more than 6 have a probability of 1.4 %.
  EXPECT_LE(alarms, 6);
}

TEST(LevelDependence, IsAskedOfInputsWithAChangeOnly) {
  FittedElements fitted = FittedElements::Constant(1, 2, false);
  fitted(0, 1) = true;
  const auto tested =
      TestLevelDependence(TwoElements(), ValveRecords(0.15, 1), fitted, {},
                          std::vector<NoiseEstimate>(1));
  ASSERT_TRUE(tested.ok()) << tested.status();
  EXPECT_EQ((*tested)[0].p_value, 1.0);
  EXPECT_EQ((*tested)[0].curvature, 0.0);
  EXPECT_NE((*tested)[1].p_value, 1.0);
}

}  // namespace
}  // namespace mle

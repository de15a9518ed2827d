// The output-error correction of records with outliers.

#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_correction.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

constexpr double kDeviation = 0.1;

struct Spoiling {
  const char* name;
  int shortest;
  int longest;
  double drift;  // increment variance
};

// Two per cent of the samples off by 10 to 50 σ, in bursts to one side.
std::vector<Record> Spoil(std::vector<Record> records, const Spoiling& how,
                          unsigned seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> size(10.0, 50.0);
  for (Record& record : records) {
    for (int spoilt = 0; spoilt < 0.02 * record.samples();) {
      const int length =
          how.shortest +
          static_cast<int>(engine() % (how.longest - how.shortest + 1));
      const int first =
          static_cast<int>(engine() % (record.samples() - length));
      const double side = engine() % 2 == 0 ? kDeviation : -kDeviation;
      for (int k = first; k < first + length; ++k) {
        record.outputs(0, k) += side * size(engine);
      }
      spoilt += length;
    }
  }
  return records;
}

std::vector<ParameterEstimate> Parameters(const OutputErrorFit& fit) {
  std::vector<ParameterEstimate> all;
  for (const ElementEstimate& e : fit.elements) {
    all.insert(all.end(), {e.gain, e.time_scale, e.delay});
  }
  return all;
}

struct Outcome {
  double E = 0.0;  // Σ of the squared distances of the responses
  int covered = 0;
};

Outcome FitAll(const std::vector<std::vector<Record>>& runs, RobustLoss loss) {
  const ProcessModel plant = AgedPlant();
  const StepResponse truth = plant.ComputeStepResponse(0.5, 100);
  Outcome outcome;
  for (const auto& records : runs) {
    const auto fit =
        CorrectByOutputError(TwoElements(), records, {.robust_loss = loss});
    EXPECT_TRUE(fit.ok()) << fit.status();
    outcome.E +=
        SquaredDistance(truth, fit->full.model.ComputeStepResponse(0.5, 100));
    std::vector<double> values;
    for (int j = 0; j < 2; ++j) {
      const TransferFunction& e = plant.element(0, j);
      values.insert(values.end(),
                    {e.StaticGain(), e.TimeConstant(), e.delay()});
    }
    const auto found = Parameters(fit->full);
    for (std::size_t k = 0; k < values.size(); ++k) {
      outcome.covered +=
          found[k].lower <= values[k] && values[k] <= found[k].upper;
    }
    if (loss != RobustLoss::kNone) {
      EXPECT_LT(fit->full.certificates[0].gradient, 1e-2);
      EXPECT_LE(fit->full.certificates[0].weight_change, 1e-3);
      EXPECT_GT(fit->full.down_weighted_samples[0], 5);
    }
  }
  return outcome;
}

class OutputErrorRobustTest : public ::testing::TestWithParam<Spoiling> {};

TEST_P(OutputErrorRobustTest, OutliersCostLittle) {
  std::vector<std::vector<Record>> clean;
  std::vector<std::vector<Record>> spoilt;
  for (unsigned seed = 0; seed < 8; ++seed) {
    clean.push_back(MakeRecords(
        AgedPlant(), 400, 700 + seed,
        {.variance = kDeviation * kDeviation, .increment = GetParam().drift}));
    spoilt.push_back(Spoil(clean.back(), GetParam(), seed));
  }
  const Outcome best = FitAll(clean, RobustLoss::kNone);
  const Outcome ruined = FitAll(spoilt, RobustLoss::kNone);
  EXPECT_GT(ruined.E, 3.0 * best.E);
  for (const RobustLoss loss : {RobustLoss::kHuber, RobustLoss::kCauchy}) {
    const Outcome robust = FitAll(spoilt, loss);
    EXPECT_LT(robust.E, 2.0 * best.E);
    // 48 intervals of 95 %: 45.6, deviation 1.5 if independent, up to √6 times
    // that; three of them.
    EXPECT_GE(robust.covered, 34);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Outliers, OutputErrorRobustTest,
    ::testing::Values(Spoiling{"Single", 1, 1, 0.0},
                      Spoiling{"Bursts", 3, 10, 0.0},
                      Spoiling{"SingleWithDrift", 1, 1, 1e-4}),
    [](const auto& test) { return std::string(test.param.name); });

// On clean records robust estimates are those of least squares, but for their
// efficiency, and without noise they are exact.
TEST(OutputErrorRobustTest, AnExactPlantIsRecoveredThroughOutliers) {
  const auto records =
      Spoil(MakeRecords(AgedPlant(), 400, 1, {}), {"", 1, 1, 0.0}, 5);
  const auto fit = CorrectByOutputError(TwoElements(), records,
                                        {.robust_loss = RobustLoss::kCauchy});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_NEAR(fit->full.element(0, 0).gain.value, 1.2, 1e-4);
  EXPECT_NEAR(fit->full.element(0, 0).delay.value, 4.21, 1e-3);
  EXPECT_NEAR(fit->full.element(0, 1).gain.value, -3.0, 1e-4);
}

}  // namespace
}  // namespace mle

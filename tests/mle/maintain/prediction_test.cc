#include "mle/maintain/prediction.h"

#include <cmath>
#include <vector>

#include "Eigen/QR"
#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

ProcessModel PredictedTank() {
  ProcessModel model("tank", "min", {InputChannel{"u", ""}},
                     {OutputChannel{"y", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 1.3);
  return model;
}

// The tank from rest at input 3, with a step to 4 at sample 40.
Record Step(double noise, double drift) {
  Record record;
  record.sample_time = 0.5;
  record.inputs = Eigen::MatrixXd::Constant(1, 400, 3.0);
  record.inputs.rightCols(360).setConstant(4.0);
  record.outputs =
      *SimulateResponse(PredictedTank(), record.sample_time, record.inputs);
  GaussianNoise generator(1, 0);
  double level = 0.0;
  for (int k = 0; k < 400; ++k) {
    record.outputs(0, k) += level + generator.Draw(noise);
    level += generator.Draw(drift);
  }
  return record;
}

Eigen::VectorXd Ratio(double ratio) {
  return Eigen::VectorXd::Constant(1, ratio);
}

double MeanSquare(const Eigen::MatrixXd& errors) {
  double sum = 0.0;
  int count = 0;
  for (const double error : errors.row(0)) {
    if (!std::isfinite(error)) continue;
    sum += error * error;
    ++count;
  }
  return sum / count;
}

TEST(PredictionTest, TheResponseStartsSettledAndIsThatOfTheElement) {
  const Record record = Step(0.0, 0.0);
  const Eigen::VectorXd step =
      PredictedTank().element(0, 0).StepResponse(0.5, 360);
  for (int k = 0; k < 40; ++k) EXPECT_NEAR(record.outputs(0, k), 6.0, 1e-9);
  for (int k = 0; k < 360; ++k) {
    EXPECT_NEAR(record.outputs(0, 40 + k), 6.0 + step(k), 1e-6);
  }
}

TEST(PredictionTest, WithoutNoiseNothingIsLeft) {
  const Record record = Step(0.0, 0.0);
  const Predictor predictor =
      PredictWithLevel(*ResponseOf(PredictedTank(), 0.5), Ratio(0.0));
  for (const int horizon : {1, 7, 0}) {
    EXPECT_LT(MeanSquare(predictor(record, horizon)), 1e-12) << horizon;
  }
}

ProcessModel Sump() {
  ProcessModel model = PredictedTank();
  model.element(0, 0) = TransferFunction::Integrator(0.2, 3.0, 1.3);
  return model;
}

Record SumpRecord(double noise) {
  Record record = Step(0.0, 0.0);
  record.outputs = *SimulateResponse(Sump(), record.sample_time, record.inputs);
  GaussianNoise generator(2, 0);
  for (double& y : record.outputs.row(0)) y += generator.Draw(noise);
  return record;
}

// What balances a level is not known, nor where it begins.
TEST(PredictionTest, RampsOfALevelAreNoErrors) {
  const InputResponse response = *ResponseOf(Sump(), 0.5);
  ASSERT_EQ(response.integrating, std::vector<bool>{true});
  const Predictor predictor = PredictWithLevel(response, Ratio(0.01));
  const Record record = SumpRecord(0.1);
  Record ramped = record;
  for (int k = 0; k < 400; ++k) ramped.outputs(0, k) += 5.0 - 0.3 * k;
  for (const int horizon : {1, 7, 0}) {
    const Eigen::MatrixXd errors = predictor(record, horizon);
    const Eigen::MatrixXd others = predictor(ramped, horizon);
    int known = 0;
    for (int k = 0; k < 400; ++k) {
      ASSERT_EQ(std::isfinite(errors(0, k)), std::isfinite(others(0, k)));
      if (!std::isfinite(errors(0, k))) continue;
      // Ramps of hundreds lose digits.
      EXPECT_NEAR(errors(0, k), others(0, k), 1e-9) << horizon;
      ++known;
    }
    EXPECT_GT(known, 300);
  }
  EXPECT_NEAR((*FitLevelRatios(response, {record}))(0),
              (*FitLevelRatios(response, {ramped}))(0), 1e-9);
}

// Without a walk the level is the line through all errors so far.
TEST(PredictionTest, WithoutAWalkALevelFollowsTheLineOfLeastSquares) {
  const InputResponse response = *ResponseOf(Sump(), 0.5);
  const Record record = SumpRecord(0.1);
  const Eigen::RowVectorXd e =
      record.outputs.row(0) -
      SimulateResponse(Sump(), 0.5, record.inputs)->row(0);
  const Eigen::MatrixXd errors =
      PredictWithLevel(response, Ratio(0.0))(record, 1);
  const int first = response.forgetting;
  for (int k = first + 2; k < 60; ++k) {
    const int n = k - first;
    Eigen::MatrixXd line(n, 2);
    line << Eigen::VectorXd::Ones(n), Eigen::VectorXd::LinSpaced(n, 0.0, n - 1);
    const Eigen::Vector2d fit =
        line.colPivHouseholderQr().solve(e.segment(first, n).transpose());
    EXPECT_NEAR(errors(0, k), e(k) - fit(0) - n * fit(1), 1e-10) << k;
  }
  EXPECT_TRUE(std::isnan(errors(0, first + 1)));
}

TEST(PredictionTest, OneStepAheadIsTheStationaryKalmanFilter) {
  const double ratio = 0.04;
  const Record record = Step(0.1, 0.1 * std::sqrt(ratio));
  const Predictor predictor =
      PredictWithLevel(*ResponseOf(PredictedTank(), 0.5), Ratio(ratio));
  // Innovation variance r (1 + P), P = (ρ + √(ρ² + 4ρ))/2.
  const double P = 0.5 * (ratio + std::sqrt(ratio * ratio + 4.0 * ratio));
  // Standard error of a variance of 380 samples: 7 %.
  EXPECT_NEAR(MeanSquare(predictor(record, 1)), 0.01 * (1.0 + P), 0.003);
  EXPECT_GT(MeanSquare(predictor(record, 50)),
            MeanSquare(predictor(record, 1)));
}

// ρ = 1/2: P = 1 before each measurement, so that the stationary gain is 1/2
// and the error after a jump of the output halves from sample to sample.
TEST(PredictionTest, TheLevelFollowsAJumpWithTheStationaryGain) {
  Record record = Step(0.0, 0.0);
  record.outputs.rightCols(200).array() += 1.0;
  const Predictor predictor =
      PredictWithLevel(*ResponseOf(PredictedTank(), 0.5), Ratio(0.5));
  const Eigen::MatrixXd errors = predictor(record, 1);
  for (int k = 0; k < 10; ++k) {
    EXPECT_NEAR(errors(0, 200 + k), std::pow(0.5, k), 1e-9) << k;
  }
}

TEST(PredictionTest, TheLevelRatioIsThatOfTheDrift) {
  const auto ratio_of = [](double drift) {
    return (*FitLevelRatios(*ResponseOf(PredictedTank(), 0.5),
                            {Step(0.1, drift)}))(0);
  };
  // 380 samples know ln q/r within about 0.4.
  EXPECT_NEAR(std::log(ratio_of(0.02)), std::log(0.04), 1.2);
  EXPECT_NEAR(std::log(ratio_of(0.1)), 0.0, 1.2);
  EXPECT_LT(ratio_of(0.0), 1e-3);
}

TEST(PredictionTest, AWrongModelPredictsWorse) {
  ProcessModel wrong = PredictedTank();
  wrong.element(0, 0) = TransferFunction::FirstOrder(1.4, 5.0, 1.3);
  const Record record = Step(0.05, 0.0);
  const Predictor good =
      PredictWithLevel(*ResponseOf(PredictedTank(), 0.5), Ratio(0.0));
  const Predictor bad = PredictWithLevel(*ResponseOf(wrong, 0.5), Ratio(0.0));
  for (const int horizon : {1, 20, 0}) {
    EXPECT_LT(MeanSquare(good(record, horizon)),
              0.5 * MeanSquare(bad(record, horizon)));
  }
}

TEST(PredictionTest, ConstantsDoNotMatter) {
  const Record record = Step(0.05, 0.01);
  Record lifted = record;
  lifted.outputs.array() += 350.0;
  const Predictor predictor =
      PredictWithLevel(*ResponseOf(PredictedTank(), 0.5), Ratio(0.01));
  for (const int horizon : {1, 20, 0}) {
    EXPECT_NEAR(MeanSquare(predictor(record, horizon)),
                MeanSquare(predictor(lifted, horizon)), 1e-9);
  }
}

TEST(PredictionTest, LostSamplesHaveNoError) {
  Record record = Step(0.05, 0.0);
  record.outputs(0, 200) = std::nan("");
  const Predictor process =
      PredictWithLevel(*ResponseOf(PredictedTank(), 0.5), Ratio(0.0));
  const Eigen::MatrixXd errors = process(record, 1);
  EXPECT_TRUE(std::isnan(errors(0, 200)));
  EXPECT_TRUE(std::isfinite(errors(0, 201)));
}

// First order: φ_{k+1} = a φ_k + b, of which a process model has the same.
TEST(PredictionTest, AnArxModelRunsFreely) {
  ArxModel arx;
  arx.sample_time = 0.5;
  arx.order = 2;
  arx.num_outputs = arx.num_inputs = 1;
  arx.R = Eigen::MatrixXd::Zero(1, 4);
  arx.R(0, 0) = 0.9;
  arx.R(0, 3) = 0.2;  // of the input two samples ago
  const Record record = Step(0.0, 0.0);
  const Eigen::MatrixXd response = *ResponseOf(arx).response(record);
  const StepResponse step = arx.ComputeStepResponse(360);
  for (int k = 0; k < 40; ++k) EXPECT_EQ(response(0, k), 0.0);
  for (int k = 0; k < 360; ++k) {
    EXPECT_NEAR(response(0, 40 + k), step.element(0, 0)(k), 1e-9);
  }
}

}  // namespace
}  // namespace mle

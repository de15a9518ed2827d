#include "mle/maintain/exact_arx.h"

#include <cmath>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/correction/correction.h"
#include "mle/maintain/corrected_model.h"
#include "mle/maintain/unfitted.h"

namespace mle {
namespace {

// Dead times of whole samples and of parts of them, one pair absent, elements
// of second order, one with an inverse response and one that oscillates.
ProcessModel Column() {
  ProcessModel model("column", "min", {{"u1", ""}, {"u2", ""}, {"u3", ""}},
                     {{"y1", ""}, {"y2", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(12.8, 16.7, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-18.9, 21.0, 3.13);
  model.element(1, 0) = TransferFunction({-8.0, 1.0}, {40.0, 14.0, 1.0}, 7.0);
  model.element(1, 1) = TransferFunction::FirstOrder(-19.4, 14.4, 3.0);
  model.element(1, 2) = TransferFunction({0.02}, {100.0, 4.0, 1.0}, 0.77);
  return model;
}

Eigen::RowVectorXd PastOutputs(const ArxModel& model, int output) {
  Eigen::RowVectorXd a(model.order);
  for (int lag = 0; lag < model.order; ++lag) {
    a(lag) = model.R(output, lag * model.num_channels() + output);
  }
  return a;
}

TEST(ExactArxTest, FreeRunsAndStaticGainsAreThoseOfTheModel) {
  for (const double sample_time : {0.05, 0.2, 1.0, 4.0}) {
    const ExactArx exact = ArxOfModel(Column(), sample_time, {});
    EXPECT_LT(exact.errors.maxCoeff(), 1e-8) << sample_time;
    // Far beyond the horizon of the check: nothing grows.
    const int samples = 10 * exact.model.order + 2000;
    const StepResponse run = exact.model.ComputeStepResponse(samples);
    const StepResponse wanted =
        Column().ComputeStepResponse(sample_time, samples);
    EXPECT_LT((run.values - wanted.values).cwiseAbs().maxCoeff(), 1e-6)
        << sample_time;
    // The absent pair is zero, and outputs do not enter each other.
    EXPECT_TRUE(run.element(0, 2).isZero(0.0));
    EXPECT_EQ(exact.model.R(0, 1), 0.0);
  }
}

// Levels: an integrator without lag, one with lag, one that settles beside
// them; and an output that settles.
TEST(ExactArxTest, LevelsKeepAnExactIntegrator) {
  ProcessModel model = Column();
  model.element(0, 0) = TransferFunction::Integrator(-0.4, 0.0, 0.6);
  model.element(0, 1) = TransferFunction::Integrator(0.3, 4.0, 1.33);
  model.element(0, 2) = TransferFunction::FirstOrder(2.0, 6.0, 1.0);
  for (const double sample_time : {0.2, 1.0}) {
    const ExactArx exact = ArxOfModel(model, sample_time, {});
    EXPECT_LT(exact.errors.maxCoeff(), 1e-8) << sample_time;
    // The pole at 1 is exact but for the rounding of the sum.
    EXPECT_NEAR(PastOutputs(exact.model, 0).sum(), 1.0, 1e-14);
    EXPECT_LT(PastOutputs(exact.model, 1).sum(), 1.0 - 1e-6);
    const int samples = 10 * exact.model.order + 2000;
    const StepResponse run = exact.model.ComputeStepResponse(samples);
    const StepResponse wanted = model.ComputeStepResponse(sample_time, samples);
    // Relative to a level of hundreds.
    EXPECT_LT((run.values - wanted.values).cwiseAbs().maxCoeff(), 1e-6)
        << sample_time;
  }
}

TEST(ExactArxTest, OneModeHasTheShortestCoefficients) {
  ProcessModel tank("tank", "min", {{"u", ""}}, {{"y", ""}});
  tank.element(0, 0) = TransferFunction::FirstOrder(2.0, 5.0, 1.0);
  ConversionSettings settings;
  settings.order = 12;
  const ExactArx exact = ArxOfModel(tank, 0.5, settings);
  // a_l ∝ λ^−l with Σ a_l λ^−l = 1 over L = 12 − 3 lags: the first sample that
  // answers is the third.
  const double pole = std::exp(-0.1);
  double squares = 0.0;
  for (int l = 1; l <= 9; ++l) squares += std::pow(pole, -2.0 * l);
  const Eigen::RowVectorXd a = PastOutputs(exact.model, 0);
  for (int l = 1; l <= 9; ++l) {
    EXPECT_NEAR(a(l - 1), std::pow(pole, -l) / squares, 1e-12) << l;
  }
  EXPECT_EQ(a.tail(3).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LT(exact.errors(0), 1e-12);
}

TEST(ExactArxTest, AnOrderThatIsTooShortIsSeen) {
  ConversionSettings settings;
  settings.order = 10;
  const ExactArx exact = ArxOfModel(Column(), 0.2, settings);
  EXPECT_EQ(exact.model.order, 10);
  EXPECT_GT(exact.errors(1), 0.01);
  // Unless asked for, it holds dead times beyond the memory of a regression.
  ProcessModel late = Column();
  late.element(0, 1) = TransferFunction::FirstOrder(-18.9, 21.0, 160.0);
  EXPECT_LT(ArxOfModel(late, 0.2, {}).errors.maxCoeff(), 1e-6);
}

TEST(ExactArxTest, EveryRatioOfDriftToNoiseHasTheSameArxModel) {
  Record record;
  record.sample_time = 0.2;
  record.inputs = Eigen::MatrixXd::Random(3, 40);
  record.outputs = Eigen::MatrixXd::Random(2, 40);
  Estimate estimate = UnfittedEstimate(Column(), {record}, {});
  for (int exponent = -6; exponent <= 6; exponent += 2) {
    for (NoiseEstimate& noise : estimate.setting.noise) {
      noise.variance = 1e-3;
      noise.ratio = std::pow(10.0, exponent);
    }
    const auto model = MakeCorrectedModel(estimate, false, 0.2, 200);
    ASSERT_TRUE(model.ok()) << model.status();
    EXPECT_TRUE(model->has_arx()) << exponent;
    const StepResponse run = model->arx.ComputeStepResponse(2000);
    const StepResponse wanted = Column().ComputeStepResponse(0.2, 2000);
    EXPECT_LT(std::sqrt(SquaredDistance(run, wanted)),
              1e-6 * wanted.values.norm())
        << exponent;
  }
}

// Outputs that are not ΔR's run as the process model, whatever R was.
TEST(ExactArxTest, RowsBesideThoseOfDeltaAreExact) {
  Record record;
  record.sample_time = 0.2;
  record.inputs = Eigen::MatrixXd::Random(3, 40);
  record.outputs = Eigen::MatrixXd::Random(2, 40);
  Estimate estimate = UnfittedEstimate(Column(), {record}, {});
  ConversionSummary conversion;
  conversion.model = ArxOfModel(Column(), 0.2, {}).model;
  conversion.model.R *= 0.5;
  estimate.setting.scales = {Eigen::VectorXd::Ones(2),
                             Eigen::VectorXd::Ones(3)};
  estimate.fit.arx_model = conversion.model;
  estimate.setting.conversion = conversion;
  estimate.setting.arx_outputs = {true, false};
  estimate.fit.arx = std::make_shared<const Correction>();
  const auto model = MakeCorrectedModel(estimate, true, 0.2, 400);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_TRUE(model->arx.R.row(0) == conversion.model.R.row(0));
  const StepResponse run = model->arx.ComputeStepResponse(400);
  const StepResponse wanted = Column().ComputeStepResponse(0.2, 400);
  EXPECT_LT((run.element(1, 1) - wanted.element(1, 1)).norm(),
            1e-6 * wanted.element(1, 1).norm());
  EXPECT_GT((run.element(0, 0) - wanted.element(0, 0)).norm(),
            0.1 * wanted.element(0, 0).norm());
}

}  // namespace
}  // namespace mle

// What a change of units, of the order of channels, of the clock, a split of a
// record or a channel that has nothing to do with the rest must do to the
// answers: change them in a known way, or not at all.

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "glog/logging.h"
#include "gtest/gtest.h"
#include "mle/correction/correction.h"
#include "mle/nonlinear/output_error_correction.h"
#include "tests/mle/correction/arx_data.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

// The ΔR of records of SparseArx(), whose first gain the model has wrong.

ArxModel BelievedPlant() {
  ArxModel model = SparseArx();
  model.R(0, 2) = 0.6;
  return model;
}

std::vector<Record> PlantWindows() {
  return {SimulateArx(SparseArx(), 400, 0.1, 1, 3.0, 5.0),
          SimulateArx(SparseArx(), 400, 0.1, 2, 3.0, 5.0)};
}

CorrectionOptions PlantOptions(double scale = 1.0) {
  CorrectionOptions options;
  options.lambdas = scale * *MakeLambdaGrid(2e-2, 1e-4);
  options.selection.on_grid = true;
  return options;
}

Correction CorrectedPlant(const ArxModel& model,
                          const std::vector<Record>& windows,
                          const CorrectionOptions& options) {
  auto correction = CorrectModel(model, windows, options);
  CHECK(correction.ok()) << correction.status();
  CHECK_LE(correction->MaxRelativeGap(), 1e-7);
  return *std::move(correction);
}

// Largest difference over the largest coefficient.
double RelativeDifference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff() / a.cwiseAbs().maxCoeff();
}

constexpr double kRounding = 1e-8;

TEST(MetamorphicCorrectionTest, UnitsChangeTheCoefficientsAlike) {
  const double output = 1000.0;
  const Eigen::Vector4d scale(output, output, -0.01, 60.0);
  ArxModel model = BelievedPlant();
  const auto in_new_units = [&](Eigen::MatrixXd R) {
    for (Eigen::Index i = 0; i < R.rows(); ++i) {
      for (Eigen::Index j = 0; j < R.cols(); ++j) {
        R(i, j) *= scale(i) / scale(j % 4);
      }
    }
    return R;
  };
  const Correction before =
      CorrectedPlant(model, PlantWindows(), PlantOptions());
  model.R = in_new_units(model.R);
  std::vector<Record> windows = PlantWindows();
  for (Record& window : windows) {
    window.outputs = scale.head(2).asDiagonal() * window.outputs;
    window.inputs = scale.tail(2).asDiagonal() * window.inputs;
  }
  // λ has the unit of the outputs.
  const Correction after = CorrectedPlant(model, windows, PlantOptions(output));
  EXPECT_NEAR(after.selection().lambda_star(0),
              output * before.selection().lambda_star(0), 1e-9);
  EXPECT_LE(RelativeDifference(in_new_units(before.Model().R), after.Model().R),
            kRounding);
}

TEST(MetamorphicCorrectionTest, TheOrderOfChannelsDoesNotMatter) {
  const auto exchanged = [](const Eigen::MatrixXd& R) {
    Eigen::MatrixXd other(R.rows(), R.cols());
    const int partner[] = {1, 0, 3, 2};
    for (Eigen::Index j = 0; j < R.cols(); ++j) {
      other.col(j / 4 * 4 + partner[j % 4]) = R.col(j).reverse();
    }
    return other;
  };
  const Correction before =
      CorrectedPlant(BelievedPlant(), PlantWindows(), PlantOptions());
  ArxModel model = BelievedPlant();
  model.R = exchanged(model.R);
  std::vector<Record> windows = PlantWindows();
  for (Record& window : windows) {
    window.outputs = window.outputs.colwise().reverse().eval();
    window.inputs = window.inputs.colwise().reverse().eval();
  }
  const Correction after = CorrectedPlant(model, windows, PlantOptions());
  EXPECT_EQ(after.selection().lambda_star(0),
            before.selection().lambda_star(0));
  EXPECT_LE(RelativeDifference(exchanged(before.Model().R), after.Model().R),
            kRounding);
}

TEST(MetamorphicCorrectionTest, TheClockDoesNotMatter) {
  const Correction before =
      CorrectedPlant(BelievedPlant(), PlantWindows(), PlantOptions());
  std::vector<Record> windows = PlantWindows();
  for (Record& window : windows) window.start_time += 1e7;
  const Correction after =
      CorrectedPlant(BelievedPlant(), windows, PlantOptions());
  EXPECT_EQ(before.Model().R, after.Model().R);
}

TEST(MetamorphicCorrectionTest, TheOperatingPointDoesNotMatter) {
  const Correction before =
      CorrectedPlant(BelievedPlant(), PlantWindows(), PlantOptions());
  std::vector<Record> windows = PlantWindows();
  for (Record& window : windows) {
    window.outputs.colwise() += Eigen::Vector2d(400.0, -7.0);
    window.inputs.colwise() += Eigen::Vector2d(0.5, 80.0);
  }
  const Correction after =
      CorrectedPlant(BelievedPlant(), windows, PlantOptions());
  EXPECT_EQ(after.selection().lambda_star(0),
            before.selection().lambda_star(0));
  EXPECT_LE(RelativeDifference(before.Model().R, after.Model().R), kRounding);
}

// The parts overlap by the model's memory, so that no row is lost.
TEST(MetamorphicCorrectionTest, ASplitRecordSaysTheSame) {
  const Correction before =
      CorrectedPlant(BelievedPlant(), PlantWindows(), PlantOptions());
  std::vector<Record> parts;
  for (const Record& window : PlantWindows()) {
    const int cut = 150;
    Record first = window;
    first.outputs = window.outputs.leftCols(cut);
    first.inputs = window.inputs.leftCols(cut);
    const int rest = window.samples() - cut + BelievedPlant().order;
    Record second = window;
    second.start_time = window.time(window.samples() - rest);
    second.outputs = window.outputs.rightCols(rest);
    second.inputs = window.inputs.rightCols(rest);
    parts.push_back(first);
    parts.push_back(second);
  }
  const Correction after =
      CorrectedPlant(BelievedPlant(), parts, PlantOptions());
  for (const double lambda : {0.0, 1e-3, 1e-2}) {
    EXPECT_LE(RelativeDifference(before.Model(lambda).R, after.Model(lambda).R),
              kRounding)
        << lambda;
  }
}

TEST(MetamorphicCorrectionTest, TheSameRecordsTwiceSayTheSame) {
  const Correction before =
      CorrectedPlant(BelievedPlant(), PlantWindows(), PlantOptions());
  std::vector<Record> windows = PlantWindows();
  windows.push_back(windows[0]);
  windows.push_back(windows[1]);
  const Correction after =
      CorrectedPlant(BelievedPlant(), windows, PlantOptions());
  for (const double lambda : {0.0, 1e-3, 1e-2}) {
    EXPECT_LE(RelativeDifference(before.Model(lambda).R, after.Model(lambda).R),
              kRounding)
        << lambda;
  }
}

// A model of the same process that knows a third input without effect.
ArxModel WithAnotherInput(const ArxModel& model) {
  ArxModel wider = model;
  wider.num_inputs = 3;
  wider.R.setZero(2, 5 * model.order);
  for (int a = 0; a < model.order; ++a) {
    wider.R.middleCols(5 * a, 4) = model.R.middleCols(4 * a, 4);
  }
  return wider;
}

std::vector<Record> WithAnotherInput(std::vector<Record> windows,
                                     bool constant) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  for (Record& window : windows) {
    window.inputs.conservativeResize(3, Eigen::NoChange);
    for (double& value : window.inputs.row(2)) {
      value = constant ? 42.0 : normal(random);
    }
  }
  return windows;
}

TEST(MetamorphicCorrectionTest, AChannelThatDoesNotMoveChangesNothing) {
  const Correction before =
      CorrectedPlant(BelievedPlant(), PlantWindows(), PlantOptions());
  const Correction after = CorrectedPlant(
      WithAnotherInput(BelievedPlant()),
      WithAnotherInput(PlantWindows(), /*constant=*/true), PlantOptions());
  EXPECT_EQ(after.selection().lambda_star(0),
            before.selection().lambda_star(0));
  EXPECT_LE(
      RelativeDifference(WithAnotherInput(before.Model()).R, after.Model().R),
      kRounding);
}

// It enters the path only where λ is below its chance correlation with the
// residuals, about σ/√N = 0.1/√790.
TEST(MetamorphicCorrectionTest, AnUnrelatedChannelStaysOut) {
  const double lambda = 0.02;  // five of these deviations
  const Correction before =
      CorrectedPlant(BelievedPlant(), PlantWindows(), PlantOptions());
  const Correction after = CorrectedPlant(
      WithAnotherInput(BelievedPlant()),
      WithAnotherInput(PlantWindows(), /*constant=*/false), PlantOptions());
  EXPECT_LE(RelativeDifference(WithAnotherInput(before.Model(lambda)).R,
                               after.Model(lambda).R),
            kRounding);
}

// The output-error correction: gain and dead time of one element have changed.

ProcessModel Aged() {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 4.0, 2.0);
  return plant;
}

std::vector<Record> AgedRecords() {
  return MakeRecords(Aged(), 500, 3, {.variance = 1e-2, .offset = 2.0});
}

OutputErrorCorrection ByOutputError(const ProcessModel& model,
                                    const std::vector<Record>& records) {
  auto correction = CorrectByOutputError(model, records, OutputErrorOptions());
  CHECK(correction.ok()) << correction.status();
  return *std::move(correction);
}

// Estimates up to the optimiser's stop, in standard errors.
constexpr double kOptimiser = 1e-3;

void ExpectSame(const ParameterEstimate& a, const ParameterEstimate& b,
                double factor) {
  EXPECT_NEAR(b.value, factor * a.value,
              std::abs(factor) * (kOptimiser * a.standard_error + 1e-12));
  EXPECT_NEAR(b.standard_error, std::abs(factor) * a.standard_error,
              1e-2 * std::abs(factor) * a.standard_error);
}

TEST(MetamorphicOutputErrorTest, UnitsScaleTheGainsAlone) {
  const OutputErrorCorrection before =
      ByOutputError(TwoElements(), AgedRecords());
  ASSERT_TRUE(before.aged(0, 0));
  const double output = 250.0;
  const Eigen::Vector2d input(0.1, -30.0);
  ProcessModel model = TwoElements();
  std::vector<Record> records = AgedRecords();
  for (int j = 0; j < 2; ++j) {
    const TransferFunction& g = model.element(0, j);
    model.element(0, j) = TransferFunction::FirstOrder(
        g.StaticGain() * output / input(j), g.TimeConstant(), g.delay());
  }
  for (Record& record : records) {
    record.outputs *= output;
    record.inputs = input.asDiagonal() * record.inputs;
  }
  const OutputErrorCorrection after = ByOutputError(model, records);
  EXPECT_EQ(after.aged, before.aged);
  for (int j = 0; j < 2; ++j) {
    const ElementEstimate& a = before.corrected.element(0, j);
    const ElementEstimate& b = after.corrected.element(0, j);
    ExpectSame(a.gain, b.gain, output / input(j));
    ExpectSame(a.time_scale, b.time_scale, 1.0);
    ExpectSame(a.delay, b.delay, 1.0);
  }
}

TEST(MetamorphicOutputErrorTest, TheUnitOfTimeScalesTimesAlone) {
  const OutputErrorCorrection before =
      ByOutputError(TwoElements(), AgedRecords());
  const double unit = 60.0;
  ProcessModel model = TwoElements();
  for (int j = 0; j < 2; ++j) {
    const TransferFunction& g = model.element(0, j);
    model.element(0, j) = TransferFunction::FirstOrder(
        g.StaticGain(), unit * g.TimeConstant(), unit * g.delay());
  }
  std::vector<Record> records = AgedRecords();
  for (Record& record : records) {
    record.sample_time *= unit;
    record.start_time = unit * record.start_time - 1e6;
  }
  const OutputErrorCorrection after = ByOutputError(model, records);
  EXPECT_EQ(after.aged, before.aged);
  for (int j = 0; j < 2; ++j) {
    const ElementEstimate& a = before.corrected.element(0, j);
    const ElementEstimate& b = after.corrected.element(0, j);
    ExpectSame(a.gain, b.gain, 1.0);
    ExpectSame(a.time_scale, b.time_scale, unit);
    ExpectSame(a.delay, b.delay, unit);
  }
}

TEST(MetamorphicOutputErrorTest, TheOrderOfInputsAndRecordsDoesNotMatter) {
  const OutputErrorCorrection before =
      ByOutputError(TwoElements(), AgedRecords());
  ProcessModel model = MakeModel(1, 2);
  model.element(0, 0) = TwoElements().element(0, 1);
  model.element(0, 1) = TwoElements().element(0, 0);
  std::vector<Record> records = AgedRecords();
  std::swap(records[0], records[1]);
  for (Record& record : records) {
    record.inputs = record.inputs.colwise().reverse().eval();
  }
  const OutputErrorCorrection after = ByOutputError(model, records);
  EXPECT_NEAR(after.statistic, before.statistic, 1e-3);
  for (int j = 0; j < 2; ++j) {
    EXPECT_EQ(after.aged(0, 1 - j), before.aged(0, j));
    const ElementEstimate& a = before.corrected.element(0, j);
    const ElementEstimate& b = after.corrected.element(0, 1 - j);
    ExpectSame(a.gain, b.gain, 1.0);
    ExpectSame(a.time_scale, b.time_scale, 1.0);
    ExpectSame(a.delay, b.delay, 1.0);
  }
}

TEST(MetamorphicOutputErrorTest, AChannelWithoutAnElementChangesNothing) {
  const OutputErrorCorrection before =
      ByOutputError(TwoElements(), AgedRecords());
  ProcessModel model = MakeModel(1, 3);
  for (int j = 0; j < 2; ++j) {
    model.element(0, j) = TwoElements().element(0, j);
  }
  const OutputErrorCorrection after =
      ByOutputError(model, WithAnotherInput(AgedRecords(), /*constant=*/false));
  EXPECT_EQ(after.corrected.element(0, 2).state, ElementState::kAbsent);
  EXPECT_NEAR(after.statistic, before.statistic, 1e-6);
  for (int j = 0; j < 2; ++j) {
    ExpectSame(before.corrected.element(0, j).gain,
               after.corrected.element(0, j).gain, 1.0);
    ExpectSame(before.corrected.element(0, j).delay,
               after.corrected.element(0, j).delay, 1.0);
  }
}

// Each part brings an offset and a beginning of its own, so that something is
// lost: the answer moves within its error, and the error grows.
TEST(MetamorphicOutputErrorTest, ASplitRecordSaysTheSameWithinItsError) {
  const OutputErrorCorrection before =
      ByOutputError(TwoElements(), AgedRecords());
  std::vector<Record> parts;
  for (const Record& record : AgedRecords()) {
    for (const int first : {0, 250}) {
      Record part = record;
      part.start_time = record.time(first);
      part.outputs = record.outputs.middleCols(first, 250);
      part.inputs = record.inputs.middleCols(first, 250);
      parts.push_back(part);
    }
  }
  const OutputErrorCorrection after = ByOutputError(TwoElements(), parts);
  EXPECT_EQ(after.aged, before.aged);
  const ElementEstimate& a = before.corrected.element(0, 0);
  const ElementEstimate& b = after.corrected.element(0, 0);
  EXPECT_GE(b.gain.standard_error, 0.99 * a.gain.standard_error);
  EXPECT_NEAR(b.gain.value, a.gain.value, 3.0 * b.gain.standard_error);
  EXPECT_NEAR(b.delay.value, a.delay.value, 3.0 * b.delay.standard_error);
}

}  // namespace
}  // namespace mle

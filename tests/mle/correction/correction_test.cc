#include "mle/correction/correction.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "Eigen/QR"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/correction/arx_data.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(MakeLambdaGridTest, HoldsThePapersValues) {
  const auto grid = MakeLambdaGrid(1e-2, 1e-6);
  ASSERT_TRUE(grid.ok());
  ASSERT_EQ(grid->size(), 10001);
  EXPECT_EQ((*grid)(0), 0.0);
  EXPECT_EQ((*grid)(10000), 1e-2);
  for (int i = 1; i <= 10000; ++i) {
    EXPECT_LT((*grid)(i - 1), (*grid)(i));
    EXPECT_DOUBLE_EQ((*grid)(i), i * 1e-6);
  }
}

TEST(MakeLambdaGridTest, EndsAtTheLastMultiple) {
  EXPECT_TRUE(MakeLambdaGrid(1.0, 0.3)->isApprox(
      Eigen::Vector4d(0.0, 0.3, 0.6, 0.9), 1e-15));
  EXPECT_EQ(*MakeLambdaGrid(0.25, 0.25), Eigen::Vector2d(0.0, 0.25));
}

TEST(MakeLambdaGridTest, RefusesBadInput) {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::nan("");
  const struct {
    double max;
    double step;
  } bad[] = {{0.0, 0.1},      {-1.0, 0.1}, {1.0, 0.0}, {1.0, -0.1}, {0.1, 0.2},
             {infinity, 0.1}, {nan, 0.1},  {1.0, nan}, {1.0, 1e-9}};
  for (const auto& [max, step] : bad) {
    EXPECT_EQ(MakeLambdaGrid(max, step).status().code(),
              absl::StatusCode::kInvalidArgument)
        << max << ", " << step;
  }
  EXPECT_THAT(std::string(MakeLambdaGrid(1.0, 1e-9).status().message()),
              HasSubstr("at most 1e7"));
  EXPECT_THAT(std::string(MakeLambdaGrid(1e308, 1e-9).status().message()),
              Not(HasSubstr("inf")));
}

// The model believes in another gain of the first input.
ArxModel Believed() {
  ArxModel model = SparseArx();
  model.R(0, 2) = 0.6;
  return model;
}

std::vector<Record> Windows(int samples = 800) {
  return {SimulateArx(SparseArx(), samples, 0.05, 1, 20.0, 3.0),
          SimulateArx(SparseArx(), samples, 0.05, 2, 20.0, 3.0)};
}

CorrectionOptions Options() {
  CorrectionOptions options;
  options.lambdas = *MakeLambdaGrid(0.1, 1e-4);
  return options;
}

Correction Correct(const ArxModel& initial, const std::vector<Record>& windows,
                   const CorrectionOptions& options = Options()) {
  auto correction = CorrectModel(initial, windows, options);
  EXPECT_TRUE(correction.ok()) << correction.status();
  return *std::move(correction);
}

TEST(CorrectModelTest, FindsTheCoefficientThatChanged) {
  for (const auto rule : {SelectionOptions::Rule::kLeaveChangeOut,
                          SelectionOptions::Rule::kBlocks}) {
    CorrectionOptions options = Options();
    options.selection.rule = rule;
    const Correction correction = Correct(Believed(), Windows(), options);
    EXPECT_LE(correction.MaxRelativeGap(), 1e-9);
    EXPECT_GT(correction.selection().lambda_star.minCoeff(), 0.0);
    const Eigen::MatrixXd change = correction.Model().R - Believed().R;
    // A standard error of a coefficient is σ/√N = 0.05/√1592 ≈ 1.3e-3 (inputs
    // of variance 1); the penalty takes λ, a few of them, off.
    EXPECT_NEAR(change(0, 2), 0.4, 0.02);
    Eigen::MatrixXd others = change;
    others(0, 2) = 0.0;
    EXPECT_LE(others.cwiseAbs().maxCoeff(), 0.02);
  }
}

// With an intercept for each window the records may lie at operating points of
// their own.
TEST(CorrectModelTest, WindowInterceptsTakeUpOffsets) {
  for (const auto rule : {SelectionOptions::Rule::kLeaveChangeOut,
                          SelectionOptions::Rule::kBlocks}) {
    CorrectionOptions options = Options();
    options.window_intercepts = true;
    options.selection.rule = rule;
    const Correction at_rest = Correct(Believed(), Windows(), options);
    std::vector<Record> moved = Windows();
    moved[0].outputs.array() += 4.0;
    moved[1].inputs.array() -= 7.0;
    const Correction correction = Correct(Believed(), moved, options);
    EXPECT_NEAR(correction.selection().lambda_star(0),
                at_rest.selection().lambda_star(0), 1e-6);
    EXPECT_TRUE(correction.Model(1e-3).R.isApprox(at_rest.Model(1e-3).R, 1e-9));
    options.window_intercepts = false;
    const Correction common = Correct(Believed(), moved, options);
    EXPECT_FALSE(common.Model(1e-3).R.isApprox(at_rest.Model(1e-3).R, 1e-3));
  }
}

TEST(CorrectModelTest, ChangesNothingFromLambdaMaxOn) {
  const Correction correction = Correct(Believed(), Windows());
  EXPECT_EQ(correction.Model(1e3).R, Believed().R);
}

TEST(CorrectModelTest, AtZeroIsLeastSquaresWithAnIntercept) {
  const std::vector<Record> windows = Windows();
  const Correction correction = Correct(Believed(), windows);
  const int rows = 2 * 796;
  Eigen::MatrixXd X(rows, 17);
  Eigen::MatrixXd y(rows, 2);
  int row = 0;
  for (const Record& window : windows) {
    for (int k = 4; k < window.samples(); ++k, ++row) {
      for (int lag = 1; lag <= 4; ++lag) {
        X.block(row, 4 * lag - 4, 1, 2) =
            window.outputs.col(k - lag).transpose();
        X.block(row, 4 * lag - 2, 1, 2) =
            window.inputs.col(k - lag).transpose();
      }
      X(row, 16) = 1.0;
      y.row(row) = window.outputs.col(k).transpose();
    }
  }
  const Eigen::MatrixXd expected =
      X.colPivHouseholderQr().solve(y).topRows(16).transpose();
  // The lags of the outputs make cond(G) some 1e2, more about the offsets.
  EXPECT_TRUE(correction.Model(0.0).R.isApprox(expected, 1e-10));
}

TEST(CorrectModelTest, ModelIsThePathInTheRecordsUnits) {
  const Correction correction = Correct(Believed(), Windows());
  ArxModel model = Believed();
  for (const double lambda : {0.0, 1e-3, 0.05, 10.0}) {
    correction.Model(Eigen::Vector2d::Constant(lambda), model);
    EXPECT_EQ(model.R, correction.Model(lambda).R);
    for (int i = 0; i < 2; ++i) {
      const Eigen::VectorXd beta =
          correction.fits()[i].path.Coefficients(lambda);
      for (int j = 0; j < 16; ++j) {
        const double change = model.R(i, j) - Believed().R(i, j);
        EXPECT_EQ(change == 0.0, beta(j) == 0.0);
        EXPECT_GE(change * beta(j), 0.0);
      }
    }
  }
}

// The outputs separate: what is believed of one does not touch the other's fit.
TEST(CorrectModelTest, OutputsAreDecoupled) {
  const std::vector<Record> windows = Windows();
  ArxModel other = Believed();
  other.R.row(1).setConstant(0.01);
  const Correction a = Correct(Believed(), windows);
  const Correction b = Correct(other, windows);
  bool second_differs = false;
  for (const double lambda : {0.0, 1e-3, 0.05}) {
    EXPECT_EQ(a.fits()[0].path.Coefficients(lambda),
              b.fits()[0].path.Coefficients(lambda));
    second_differs |= a.fits()[1].path.Coefficients(lambda) !=
                      b.fits()[1].path.Coefficients(lambda);
  }
  EXPECT_TRUE(second_differs);
}

// Another unit of an input changes its coefficients' unit and nothing else;
// another unit of an output that of its row and of its λ besides.
TEST(CorrectModelTest, UnitsDoNotMatter) {
  const std::vector<Record> windows = Windows();
  const Correction correction = Correct(Believed(), windows);
  for (const double unit : {1024.0, 1000.0}) {
    // A power of two changes no rounding. Others do, which the condition of
    // the lags makes no larger than this.
    const double tolerance = unit == 1024.0 ? 0.0 : 1e-9;

    std::vector<Record> scaled = windows;
    for (Record& window : scaled) window.inputs.row(1) *= unit;
    const auto input_unit = [&](Eigen::MatrixXd R) {
      for (int lag = 0; lag < 4; ++lag) R.col(4 * lag + 3) /= unit;
      return R;
    };
    ArxModel initial = Believed();
    initial.R = input_unit(initial.R);
    Correction other = Correct(initial, scaled);
    EXPECT_TRUE(other.selection().lambda_star.isApprox(
        correction.selection().lambda_star, tolerance));
    for (const double lambda : {0.0, 1e-3, 0.05}) {
      EXPECT_TRUE(other.Model(lambda).R.isApprox(
          input_unit(correction.Model(lambda).R), tolerance));
    }

    scaled = windows;
    for (Record& window : scaled) window.outputs.row(0) *= unit;
    const auto output_unit = [&](Eigen::MatrixXd R) {
      for (int lag = 0; lag < 4; ++lag) R.col(4 * lag) /= unit;
      R.row(0) *= unit;
      return R;
    };
    initial.R = output_unit(Believed().R);
    other = Correct(initial, scaled);
    for (const double lambda : {0.0, 1e-3, 0.05}) {
      EXPECT_TRUE(other.Model(unit * lambda)
                      .R.row(0)
                      .isApprox(output_unit(correction.Model(lambda).R).row(0),
                                tolerance));
      EXPECT_TRUE(other.Model(lambda).R.row(1).isApprox(
          output_unit(correction.Model(lambda).R).row(1), tolerance));
    }
  }
}

// A manual valve, held at another value in each of the windows, says nothing
// within one of them and is left out of its fit.
TEST(CorrectModelTest, AHeldInputKeepsItsCoefficients) {
  std::vector<Record> windows = Windows(2000);
  for (Record& window : windows) window.inputs.row(1).setConstant(96.1);
  Correction correction = Correct(Believed(), windows);
  EXPECT_LE(correction.MaxRelativeGap(), 1e-9);
  for (const double lambda : {0.0, 1e-3, 0.05}) {
    const Eigen::MatrixXd R = correction.Model(lambda).R;
    ASSERT_TRUE(R.allFinite());
    for (int lag = 0; lag < 4; ++lag) {
      EXPECT_EQ(R.col(4 * lag + 3), Believed().R.col(4 * lag + 3));
    }
  }
  windows[1].inputs.row(1).setConstant(1.0 / 3.0);
  CorrectionOptions options = Options();
  options.selection.rule = SelectionOptions::Rule::kLeaveChangeOut;
  correction = Correct(Believed(), windows, options);
  EXPECT_LE(correction.MaxRelativeGap(), 1e-9);
  EXPECT_TRUE(correction.selection().loss.allFinite());
  EXPECT_TRUE(correction.Model(0.0).R.allFinite());
}

// A λ for each output takes each from its own place of the path.
TEST(CorrectModelTest, OutputsMayHaveTheirOwnLambda) {
  const Correction correction = Correct(Believed(), Windows());
  const ArxModel model = correction.Model(Eigen::Vector2d(1e-3, 0.02));
  EXPECT_EQ(model.R.row(0), correction.Model(1e-3).R.row(0));
  EXPECT_EQ(model.R.row(1), correction.Model(0.02).R.row(1));
}

TEST(CorrectModelTest, RefusesBadInput) {
  const auto message = [](const std::vector<Record>& windows,
                          const CorrectionOptions& options) {
    const auto correction = CorrectModel(Believed(), windows, options);
    EXPECT_EQ(correction.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(correction.status().message());
  };
  EXPECT_THAT(message(Windows(), CorrectionOptions()),
              HasSubstr("grid of λ is empty"));
  CorrectionOptions options = Options();
  options.lambdas(3) = options.lambdas(2);
  EXPECT_THAT(message(Windows(), options), HasSubstr("value 4"));
  options.lambdas(3) = std::nan("");
  EXPECT_THAT(message(Windows(), options), HasSubstr("nan"));
  options = Options();
  options.selection.folds = 0;
  EXPECT_THAT(message(Windows(), options), HasSubstr("folds is 0"));
  EXPECT_THAT(message({}, Options()), HasSubstr("no window"));
  // Nothing moves.
  std::vector<Record> still = Windows();
  for (Record& window : still) {
    window.outputs.setConstant(20.0);
    window.inputs.setConstant(3.0);
  }
  EXPECT_THAT(message(still, Options()), HasSubstr("nothing to estimate"));
}

}  // namespace
}  // namespace mle

#include "mle/correction/robust_correction.h"

#include <cmath>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/correction/arx_data.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kLambda = 0.01;

Correction CorrectThat(bool outliers, Scaling scaling = Scaling::kStandardise,
                       bool window_intercepts = false) {
  ArxModel model = SparseArx();
  model.R(0, 2) = 0.6;
  std::vector<Record> records = {
      SimulateArx(SparseArx(), 300, 0.3, 5, 2.0, 1.0),
      SimulateArx(SparseArx(), 250, 0.3, 6, 2.0, 1.0)};
  if (outliers) {
    for (Record& record : records) {
      for (int k = 25; k < record.samples(); k += 40) {
        record.outputs(0, k) += k % 3 == 0 ? 9.0 : -7.0;
      }
    }
  }
  CorrectionOptions options;
  options.scaling = scaling;
  options.window_intercepts = window_intercepts;
  options.lambdas = Eigen::VectorXd::LinSpaced(101, 0.0, 0.5);
  auto correction = CorrectModel(model, records, options);
  EXPECT_TRUE(correction.ok()) << correction.status();
  return *std::move(correction);
}

RobustCorrection Robust(const Correction& correction, RobustLoss loss) {
  RobustCorrectionOptions options;
  options.loss = loss;
  options.weight_tolerance = 1e-9;
  auto robust =
      CorrectRobustly(correction, Eigen::Vector2d::Constant(kLambda), options);
  EXPECT_TRUE(robust.ok()) << robust.status();
  return *std::move(robust);
}

class RobustCorrectionTest : public ::testing::TestWithParam<RobustLoss> {};

TEST_P(RobustCorrectionTest, IsCertified) {
  for (const Scaling scaling : {Scaling::kStandardise, Scaling::kRaw}) {
    const RobustCorrection robust =
        Robust(CorrectThat(true, scaling), GetParam());
    for (const RobustFit& fit : robust.fits) {
      EXPECT_TRUE(fit.converged) << fit.rounds;
      EXPECT_LE(fit.relative_gap, 1e-7);
    }
    // Every outlier is down-weighted.
    EXPECT_GE(robust.fits[0].down_weighted_rows, 12);
  }
}

TEST_P(RobustCorrectionTest, SparesOutliers) {
  const ArxModel truth = SparseArx();
  const Correction clean = CorrectThat(false);
  const Correction spoilt = CorrectThat(true);
  const auto error = [&](const ArxModel& model) {
    return (model.R.row(0) - truth.R.row(0)).norm();
  };
  EXPECT_GT(error(spoilt.Model(kLambda)), 2.0 * error(clean.Model(kLambda)));
  EXPECT_LT(error(Robust(spoilt, GetParam()).model),
            0.8 * error(spoilt.Model(kLambda)));
}

TEST_P(RobustCorrectionTest, WindowInterceptsAreRobustToo) {
  const RobustCorrection robust =
      Robust(CorrectThat(true, Scaling::kStandardise, true), GetParam());
  EXPECT_LE(robust.MaxRelativeGap(), 1e-7);
}

INSTANTIATE_TEST_SUITE_P(
    Losses, RobustCorrectionTest,
    ::testing::Values(RobustLoss::kHuber, RobustLoss::kCauchy),
    [](const auto& test) {
      return std::string(test.param == RobustLoss::kHuber ? "Huber" : "Cauchy");
    });

// Huber's loss is convex: no change of one coefficient lowers the objective.
TEST(RobustCorrectionTest, HubersMinimumIsOne) {
  const Correction correction = CorrectThat(true, Scaling::kRaw);
  RobustCorrectionOptions options;
  options.weight_tolerance = 1e-10;
  const auto robust =
      CorrectRobustly(correction, Eigen::Vector2d::Constant(kLambda), options);
  ASSERT_TRUE(robust.ok()) << robust.status();
  const Eigen::VectorXd b =
      (robust->model.R - correction.initial().R).row(0).transpose();
  // Raw: no intercept.
  const auto at = [&](const Eigen::VectorXd& point) {
    double sum = 0.0;
    double rows = 0.0;
    for (int i = 0; i < correction.data().num_windows(); ++i) {
      for (const RegressionRows& part : correction.data().window(i)) {
        const Eigen::VectorXd r =
            part.responses.row(0).transpose() -
            part.series->Regressors(part.rows).transpose() * point;
        for (const double value : r) {
          const double x = std::abs(value / robust->fits[0].scale);
          sum += x > 1.345 ? 1.345 * (x - 0.5 * 1.345) : 0.5 * x * x;
        }
        rows += static_cast<double>(r.size());
      }
    }
    return robust->fits[0].scale * robust->fits[0].scale * sum / rows +
           kLambda * point.cwiseAbs().sum();
  };
  const double minimum = at(b);
  for (Eigen::Index j = 0; j < b.size(); ++j) {
    for (const double step : {-1e-2, -1e-4, 1e-4, 1e-2}) {
      Eigen::VectorXd moved = b;
      moved(j) += step;
      EXPECT_GE(at(moved), minimum * (1.0 - 1e-9)) << j << " " << step;
    }
  }
}

TEST(RobustCorrectionTest, WithoutALossItIsTheCorrection) {
  const Correction correction = CorrectThat(true);
  const RobustCorrection robust = Robust(correction, RobustLoss::kNone);
  EXPECT_LT((robust.model.R - correction.Model(kLambda).R).norm(), 1e-7);
}

TEST(RobustCorrectionTest, NamesWhatIsInvalid) {
  const Correction correction = CorrectThat(false);
  EXPECT_THAT(
      std::string(CorrectRobustly(correction, Eigen::VectorXd::Ones(3), {})
                      .status()
                      .message()),
      HasSubstr("3 values of λ are given for 2 outputs"));
  RobustCorrectionOptions options;
  options.weight_tolerance = 0.0;
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("weight_tolerance is 0"));
  options = {};
  options.max_rounds = 0;
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("max_rounds is 0"));
}

}  // namespace
}  // namespace mle

#include "mle/correction/conversion.h"

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/correction/arx_data.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ConvertToArxTest, RecoversAnArxModel) {
  const double noise = 0.1;
  const Record record = SimulateArx(SparseArx(), 20000, noise, 1);
  for (const Scaling scaling : {Scaling::kStandardise, Scaling::kRaw}) {
    ConversionOptions options;
    options.order = 4;
    options.scaling = scaling;
    const auto summary = ConvertToArx(record, options);
    ASSERT_TRUE(summary.ok()) << summary.status();
    const ArxModel& model = summary->model;
    EXPECT_TRUE(model.Validate().ok());
    EXPECT_EQ(model.sample_time, 0.5);
    EXPECT_EQ(model.order, 4);
    EXPECT_EQ(model.num_outputs, 2);
    EXPECT_EQ(model.num_inputs, 2);
    // Standard errors are at most σ/√N over the deviation of a column given the
    // others, which for an output's lag is about that noise: 1/√N = 7e-3. Five
    // of them.
    EXPECT_LE((model.R - SparseArx().R).cwiseAbs().maxCoeff(), 0.035);
    EXPECT_LE(summary->max_relative_gap, 1e-9);
    for (const double variance : summary->residual_variance) {
      EXPECT_NEAR(variance, noise * noise, 0.05 * noise * noise);
    }
  }
}

// The residual's variance is that of y − R x.
TEST(ConvertToArxTest, ResidualVarianceIsThatOfTheRows) {
  const Record record = SimulateArx(SparseArx(), 300, 0.2, 2);
  ConversionOptions options;
  options.order = 2;
  options.penalty = 0.05;
  options.scaling = Scaling::kRaw;
  const auto summary = ConvertToArx(record, options);
  ASSERT_TRUE(summary.ok()) << summary.status();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int k = 2; k < 300; ++k) {
    Eigen::VectorXd x(8);
    x << record.outputs.col(k - 1), record.inputs.col(k - 1),
        record.outputs.col(k - 2), record.inputs.col(k - 2);
    sum += (record.outputs.col(k) - summary->model.R * x).cwiseAbs2();
  }
  EXPECT_TRUE(summary->residual_variance.isApprox(sum / 298.0, 1e-12));
}

// Without noise the fit is exact; a variance is not negative for all that.
TEST(ConvertToArxTest, ANoiseFreeRecordLeavesNothing) {
  for (int seed = 1; seed <= 10; ++seed) {
    const Record record = SimulateArx(SparseArx(), 500, 0.0, seed);
    ConversionOptions options;
    options.order = 6;
    options.penalty = 0.0;
    const auto summary = ConvertToArx(record, options);
    ASSERT_TRUE(summary.ok()) << summary.status();
    for (const double variance : summary->residual_variance) {
      EXPECT_GE(variance, 0.0);
      EXPECT_LE(variance, 1e-13);
    }
  }
}

TEST(ConvertToArxTest, RefusesBadInput) {
  const Record record = SimulateArx(SparseArx(), 100, 0.1, 3);
  const auto message = [&](int order, double penalty) {
    ConversionOptions options;
    options.order = order;
    options.penalty = penalty;
    const auto summary = ConvertToArx(record, options);
    EXPECT_EQ(summary.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(summary.status().message());
  };
  EXPECT_THAT(message(0, 1e-6), HasSubstr("order is 0"));
  EXPECT_THAT(message(4, -1.0), HasSubstr("penalty is -1"));
  EXPECT_THAT(message(4, std::nan("")), HasSubstr("penalty is nan"));
  EXPECT_THAT(message(100, 1e-6),
              AllOf(HasSubstr("100 samples"), HasSubstr("order 100")));
  Record bad = record;
  bad.sample_time = 0.0;
  EXPECT_FALSE(ConvertToArx(bad, {}).ok());
}

}  // namespace
}  // namespace mle

#include "mle/correction/excitation.h"

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using ::testing::HasSubstr;
using testing::MixedModel;

Record Excite(const ExcitationOptions& options) {
  const absl::StatusOr<Record> record =
      SimulateExcitation(MixedModel(), options);
  EXPECT_TRUE(record.ok()) << record.status();
  return *record;
}

TEST(ExcitationTest, RecordHasTheShapeOfTheExperiment) {
  const Record record = Excite({.duration = 100.0});
  EXPECT_TRUE(record.Validate().ok());
  EXPECT_EQ(record.samples(), 501);
  EXPECT_EQ(record.num_inputs(), 3);
  EXPECT_EQ(record.num_outputs(), 2);
  EXPECT_EQ(record.sample_time, 0.2);
  EXPECT_EQ(record.start_time, 0.0);
  EXPECT_EQ(record.set_points.size(), 0);
}

// Five standard errors.
TEST(ExcitationTest, InputsAreWhiteWithTheVarianceAsked) {
  const Record record = Excite({.duration = 10000.0, .input_variance = 4.0});
  const MatrixXd u = record.inputs / 2.0;
  const double N = static_cast<double>(u.cols());
  const MatrixXd covariance = u * u.transpose() / N;
  const MatrixXd lagged =
      u.rightCols(u.cols() - 1) * u.leftCols(u.cols() - 1).transpose() / N;
  EXPECT_LE((covariance - MatrixXd::Identity(3, 3)).cwiseAbs().maxCoeff(),
            5.0 * std::sqrt(2.0 / N));
  EXPECT_LE(lagged.cwiseAbs().maxCoeff(), 5.0 / std::sqrt(N));
  EXPECT_LE(u.rowwise().mean().cwiseAbs().maxCoeff(), 5.0 / std::sqrt(N));
}

// y_k = Σ φ_{k−i} (u_i − u_{i−1}): the record keeps to its own convention.
TEST(ExcitationTest, NoiseFreeOutputsAreTheResponseToTheRecordedInputs) {
  const Record record = Excite({.duration = 40.0, .noise_variance = 0.0});
  const StepResponse phi =
      MixedModel().ComputeStepResponse(0.2, record.samples());
  for (int out = 0; out < 2; ++out) {
    for (int k = 0; k < record.samples(); ++k) {
      double expected = 0.0;
      for (int i = 0; i < k; ++i) {
        for (int in = 0; in < 3; ++in) {
          const double before = i > 0 ? record.inputs(in, i - 1) : 0.0;
          expected +=
              phi.element(out, in)[k - i] * (record.inputs(in, i) - before);
        }
      }
      ASSERT_NEAR(record.outputs(out, k), expected, 1e-8) << out << ", " << k;
    }
  }
}

TEST(ExcitationTest, NoiseDoesNotTouchTheInputsAndIsWhite) {
  const double variance = 0.01;
  const Record noisy = Excite({.duration = 4000.0, .noise_variance = variance});
  const Record clean = Excite({.duration = 4000.0, .noise_variance = 0.0});
  EXPECT_EQ(noisy.inputs, clean.inputs);
  const MatrixXd v = (noisy.outputs - clean.outputs) / std::sqrt(variance);
  const double N = static_cast<double>(v.cols());
  EXPECT_LE(
      (v * v.transpose() / N - MatrixXd::Identity(2, 2)).cwiseAbs().maxCoeff(),
      5.0 * std::sqrt(2.0 / N));
  EXPECT_LE((v * noisy.inputs.transpose() / N).cwiseAbs().maxCoeff(),
            5.0 / std::sqrt(N));
}

TEST(ExcitationTest, SeedAndStreamDecideTheDraws) {
  const ExcitationOptions options{.duration = 10.0, .seed = 4, .stream = 2};
  const Record one = Excite(options);
  const Record same = Excite(options);
  EXPECT_EQ(one.inputs, same.inputs);
  EXPECT_EQ(one.outputs, same.outputs);
  ExcitationOptions other = options;
  other.seed = 5;
  EXPECT_NE(one.inputs, Excite(other).inputs);
  other = options;
  other.stream = 3;
  EXPECT_NE(one.inputs, Excite(other).inputs);
}

TEST(ExcitationTest, InputsScaleTheNoiseFreeOutputs) {
  ExcitationOptions options{.duration = 20.0, .noise_variance = 0.0};
  const Record one = Excite(options);
  options.input_variance = 4.0;
  const Record two = Excite(options);
  EXPECT_EQ(two.inputs, 2.0 * one.inputs);
  EXPECT_EQ(two.outputs, 2.0 * one.outputs);
}

TEST(ExcitationTest, OptionsNameFieldAndValue) {
  const auto message = [](const ExcitationOptions& options) {
    const absl::StatusOr<Record> record =
        SimulateExcitation(MixedModel(), options);
    EXPECT_EQ(record.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(record.status().message());
  };
  EXPECT_THAT(message({.sample_time = 0.0}), HasSubstr("sample_time is 0"));
  EXPECT_THAT(message({.duration = -1.0}), HasSubstr("duration = -1"));
  EXPECT_THAT(message({.duration = 1e12}), HasSubstr("at most 1e+09"));
  EXPECT_THAT(message({.input_variance = 0.0}),
              HasSubstr("input_variance = 0"));
  EXPECT_THAT(message({.noise_variance = -2.0}),
              HasSubstr("noise_variance = -2"));
}

}  // namespace
}  // namespace mle

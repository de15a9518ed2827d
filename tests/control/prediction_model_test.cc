#include "control/prediction_model.h"

#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using testing::EmptyModel;
using ::testing::HasSubstr;
using testing::MixedModel;
using testing::SingleLoop;

// y_{k+1} = Σ_a a_a y_{k+1−a} + b u_k.
ArxModel SingleArx(const std::vector<double>& a, double b) {
  ArxModel model;
  model.sample_time = 0.5;
  model.order = static_cast<int>(a.size());
  model.num_outputs = model.num_inputs = 1;
  model.R = MatrixXd::Zero(1, 2 * model.order);
  for (int lag = 0; lag < model.order; ++lag) model.R(0, 2 * lag) = a[lag];
  model.R(0, 1) = b;
  return model;
}

TEST(PredictionModelTest, HoldsTheStepResponsesOfAProcess) {
  const auto prediction = PredictFromProcess(MixedModel(), 0.7);
  ASSERT_TRUE(prediction.ok()) << prediction.status();
  EXPECT_EQ(prediction->num_outputs, 2);
  EXPECT_EQ(prediction->num_inputs(), 3);
  const int n = prediction->periods();
  const StepResponse expected = MixedModel().ComputeStepResponse(0.7, n + 1);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k <= n; ++k) {
        EXPECT_EQ(prediction->responses(2 * k + i, j),
                  expected.element(i, j)[k]);
      }
      EXPECT_NEAR(prediction->responses(2 * n + i, j),
                  MixedModel().element(i, j).StaticGain(), 1e-9);
    }
  }
}

TEST(PredictionModelTest, TakesEveryFewSamplesOfAStepResponse) {
  const StepResponse fine = MixedModel().ComputeStepResponse(0.1, 302);
  const auto prediction = PredictFromStepResponse(fine, {}, 0.7);
  ASSERT_TRUE(prediction.ok()) << prediction.status();
  EXPECT_EQ(prediction->periods(), 43);
  EXPECT_EQ(prediction->responses(2 * 10 + 1, 0), fine.element(1, 0)[70]);
  EXPECT_EQ(prediction->responses(2 * 43, 1), fine.element(0, 1)[301]);
}

// A first-order element sampled exactly is an ARX model of order 1.
TEST(PredictionModelTest, RampsOfAStepResponseGoOn) {
  ProcessModel model = EmptyModel(2, 1);
  model.element(0, 0) = TransferFunction::Integrator(0.3, 2.0, 1.1);
  model.element(1, 0) = TransferFunction::FirstOrder(2.0, 3.0, 0.4);
  // 202 samples: the last instant, every fifth, lies beyond the last of them.
  auto sampled =
      PredictFromStepResponse(model.ComputeStepResponse(0.4, 202), {}, 2.0);
  ASSERT_TRUE(sampled.ok()) << sampled.status();
  EXPECT_TRUE(sampled->IsIntegrating());
  EXPECT_NEAR(sampled->slopes(0, 0), 0.6, 1e-9);
  EXPECT_EQ(sampled->slopes(1, 0), 0.0);
  sampled->ReachTo(100);
  auto exact = PredictFromProcess(model, 2.0);
  ASSERT_TRUE(exact.ok());
  exact->ReachTo(100);
  const Eigen::Index rows = 2 * 101;
  EXPECT_LE((sampled->responses.topRows(rows) - exact->responses.topRows(rows))
                .cwiseAbs()
                .maxCoeff(),
            1e-7);
  // Cut off before it is straight.
  const auto early =
      PredictFromStepResponse(model.ComputeStepResponse(0.4, 12), {}, 2.0);
  EXPECT_TRUE(absl::IsFailedPrecondition(early.status()));
  EXPECT_THAT(std::string(early.status().message()),
              HasSubstr("is no ramp yet"));
}

TEST(PredictionModelTest, ArxAndProcessAgree) {
  const double pole = std::exp(-0.5 / 6.0);
  const auto from_arx =
      PredictFromArx(SingleArx({pole}, 3.0 * (1.0 - pole)), {}, 1.0);
  ASSERT_TRUE(from_arx.ok()) << from_arx.status();
  const auto from_process = PredictFromProcess(
      SingleLoop(TransferFunction::FirstOrder(3.0, 6.0, 0.0)), 1.0);
  ASSERT_TRUE(from_process.ok());
  for (int k = 0; k <= from_process->periods(); ++k) {
    const int held = std::min(k, from_arx->periods());
    // What the shorter one holds of the rest, 3e-8 of the gain.
    EXPECT_NEAR(from_arx->responses(held, 0), from_process->responses(k, 0),
                1e-6);
  }
}

TEST(PredictionModelTest, KeepsTheRolesOfInputs) {
  ProcessModel model(
      "test", "min",
      {{.name = "a", .unit = "1"},
       {.name = "d", .unit = "1", .role = InputRole::kDisturbance}},
      {{.name = "y", .unit = "1"}});
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 2.0, 0.0);
  const auto prediction = PredictFromProcess(model, 1.0);
  ASSERT_TRUE(prediction.ok());
  EXPECT_EQ(prediction->InputsOf(InputRole::kManipulated), std::vector<int>{0});
  EXPECT_EQ(prediction->InputsOf(InputRole::kDisturbance), std::vector<int>{1});
}

std::string ArxError(const ArxModel& model) {
  const auto prediction = PredictFromArx(model, {}, 1.0);
  EXPECT_EQ(prediction.status().code(), absl::StatusCode::kFailedPrecondition);
  return std::string(prediction.status().message());
}

TEST(PredictionModelTest, RefusesIntegratingAndUnstableArxModels) {
  EXPECT_THAT(ArxError(SingleArx({1.0}, 0.1)), HasSubstr("has not settled"));
  EXPECT_THAT(ArxError(SingleArx({1.2}, 0.1)), HasSubstr("unstable"));
  EXPECT_THAT(ArxError(SingleArx({-1.0}, 0.1)), HasSubstr("has not settled"));
  EXPECT_THAT(ArxError(SingleArx({0.0, -1.3}, 0.1)), HasSubstr("unstable"));
}

TEST(PredictionModelTest, RefusesAResponseThatIsCutOff) {
  const ProcessModel slow =
      SingleLoop(TransferFunction::FirstOrder(2.0, 50.0, 0.0));
  const auto cut =
      PredictFromStepResponse(slow.ComputeStepResponse(1.0, 101), {}, 1.0);
  EXPECT_EQ(cut.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(cut.status().message()),
              HasSubstr("output 1 to input 1"));
  EXPECT_TRUE(
      PredictFromStepResponse(slow.ComputeStepResponse(1.0, 301), {}, 1.0)
          .ok());
  // Or to whoever asks for it.
  EXPECT_TRUE(
      PredictFromStepResponse(slow.ComputeStepResponse(1.0, 101), {}, 1.0, 0.1)
          .ok());
}

TEST(PredictionModelTest, RefusesAResponseThatIsNotFinite) {
  StepResponse response = MixedModel().ComputeStepResponse(0.2, 501);
  response.values(7, 0) = std::numeric_limits<double>::quiet_NaN();
  const auto prediction = PredictFromStepResponse(response, {}, 1.0);
  EXPECT_EQ(prediction.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(prediction.status().message()),
              HasSubstr("not finite"));
}

TEST(PredictionModelTest, RefusesArgumentsThatDoNotFit) {
  const StepResponse response = MixedModel().ComputeStepResponse(0.2, 501);
  const auto message = [](const auto& result) {
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(result.status().message());
  };
  EXPECT_THAT(message(PredictFromStepResponse(response, {}, 0.5)),
              HasSubstr("whole multiple"));
  EXPECT_THAT(message(PredictFromStepResponse(response, {}, 0.0)),
              HasSubstr("control_period = 0"));
  EXPECT_THAT(message(PredictFromStepResponse(response,
                                              {InputRole::kManipulated}, 0.4)),
              HasSubstr("1 roles are given for 3 inputs"));
  EXPECT_THAT(message(PredictFromStepResponse(StepResponse(), {}, 0.4)),
              HasSubstr("0 outputs"));
  StepResponse late = response;
  late.values(0, 0) = 0.1;
  EXPECT_THAT(message(PredictFromStepResponse(late, {}, 0.4)),
              HasSubstr("must start at zero"));
  StepResponse broken = response;
  broken.values(7, 1) = std::nan("");
  EXPECT_THAT(message(PredictFromStepResponse(broken, {}, 0.2)),
              HasSubstr("not finite"));
}

}  // namespace
}  // namespace mle::control

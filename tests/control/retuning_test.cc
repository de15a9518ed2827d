#include "control/retuning.h"

#include <algorithm>
#include <string>

#include "control/first_order.h"
#include "control/mpc.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using testing::EmptyModel;
using ::testing::HasSubstr;
using testing::SingleLoop;

ProcessModel WoodBerry(double more_delay) {
  ProcessModel model = EmptyModel(2, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(12.8, 16.7, 1.0);
  model.element(0, 1) =
      TransferFunction::FirstOrder(-18.9, 21.0, 3.0 + more_delay);
  model.element(1, 0) = TransferFunction::FirstOrder(6.6, 10.9, 7.0);
  model.element(1, 1) =
      TransferFunction::FirstOrder(-19.4, 14.4, 3.0 + more_delay);
  return model;
}

MpcOptions PaperTuning() {
  MpcOptions options;
  options.output_weight = MatrixXd::Identity(2, 2) * 0.2;
  options.move_weight = MatrixXd::Identity(2, 2) * 0.1;
  return options;
}

std::vector<FirstOrder> WoodBerryElements() {
  return {{12.8, 16.7, 1.0},
          {-18.9, 21.0, 3.0},
          {6.6, 10.9, 7.0},
          {-19.4, 14.4, 3.0}};
}

TEST(FirstOrderTest, ReadsAFirstOrderElement) {
  StepResponse response =
      WoodBerry(0.0).ComputeStepResponse(0.2, 1001);  // 200 min
  const absl::StatusOr<std::vector<FirstOrder>> elements =
      DescribeAsFirstOrder(response);
  ASSERT_TRUE(elements.ok()) << elements.status();
  const std::vector<FirstOrder> expected = WoodBerryElements();
  for (int e = 0; e < 4; ++e) {
    // Linear interpolation is off by Δt²/(8T); what is left at 200 min by e⁻⁹.
    EXPECT_NEAR((*elements)[e].gain, expected[e].gain, 3e-3);
    EXPECT_NEAR((*elements)[e].time_constant, expected[e].time_constant, 0.01);
    EXPECT_NEAR((*elements)[e].delay, expected[e].delay, 0.01);
  }
}

TEST(FirstOrderTest, TakesWhatIsSmallBesideItsRowAndColumnAsZero) {
  ProcessModel model = WoodBerry(0.0);
  model.element(0, 1) = TransferFunction::FirstOrder(0.01, 20.0, 1.0);
  const auto elements =
      DescribeAsFirstOrder(model.ComputeStepResponse(0.2, 1001));
  ASSERT_TRUE(elements.ok());
  EXPECT_EQ((*elements)[1].gain, 0.0);
  EXPECT_NE((*elements)[0].gain, 0.0);
}

TEST(FirstOrderTest, ReadsALevel) {
  ProcessModel model = EmptyModel(2, 2);
  model.element(0, 0) = TransferFunction::Integrator(-0.4, 2.0, 1.3);
  model.element(0, 1) = TransferFunction::Integrator(0.3, 0.0, 0.7);
  model.element(1, 1) = TransferFunction::FirstOrder(1.5, 4.0, 2.0);
  const auto elements =
      DescribeAsFirstOrder(model.ComputeStepResponse(0.1, 601));
  ASSERT_TRUE(elements.ok()) << elements.status();
  const FirstOrder& lag = (*elements)[0];
  EXPECT_TRUE(lag.integrating);
  EXPECT_NEAR(lag.gain, -0.4, 1e-6);
  EXPECT_NEAR(lag.time_constant, 2.0, 0.01);
  EXPECT_NEAR(lag.delay, 1.3, 0.01);
  const FirstOrder& pure = (*elements)[1];
  EXPECT_TRUE(pure.integrating);
  EXPECT_NEAR(pure.gain, 0.3, 1e-9);
  EXPECT_NEAR(pure.time_constant, 0.0, 1e-9);
  EXPECT_NEAR(pure.delay, 0.7, 1e-9);
  EXPECT_EQ((*elements)[2].gain, 0.0);
  EXPECT_FALSE((*elements)[3].integrating);
  EXPECT_NEAR((*elements)[3].time_constant, 4.0, 0.01);
}

// By hand for the Wood–Berry column. 0.1 T: 1.67, 2.1, 1.09, 1.44; 0.5 L: 0.5,
// 1.5, 3.5, 1.5; the larger ones 1.67, 2.1, 3.5, 1.5: 1.5, 7 samples of 0.2,
// which is 1.4. 5 T/1.4 + L/1.4 + 2: 62.357, 79.143, 45.929, 55.571: 80.
// T/1.4 + L/1.4 + 2: 14.643, 19.143, 14.786, 14.429: 20.
TEST(RetuningTest, HorizonsByHand) {
  std::vector<std::string> reasons;
  const absl::StatusOr<MpcOptions> tuning = TuneByRules(
      WoodBerryElements(), {InputRole::kManipulated, InputRole::kManipulated},
      0.2, PaperTuning(), {.time_unit = "min"}, reasons);
  ASSERT_TRUE(tuning.ok()) << tuning.status();
  EXPECT_NEAR(tuning->control_period, 1.4, 1e-12);
  EXPECT_EQ(tuning->prediction_horizon, 80);
  EXPECT_EQ(tuning->control_horizon, 20);
  // Q_u,11 = 20/500 · 0.2 · (12.8² (80 − 2.7143 − 17.893 + 2 − 9.5) + 6.6² (80
  // − 7 − 11.679 + 2 − 9.5)) = 0.008 · (163.84 · 51.893 + 43.56 · 53.821).
  EXPECT_NEAR(tuning->move_weight(0, 0),
              0.008 * (163.84 * 51.892857 + 43.56 * 53.821429), 1e-5);
  EXPECT_EQ(tuning->move_weight(0, 1), 0.0);
  ASSERT_EQ(reasons.size(), 5u);
  EXPECT_THAT(reasons[0], HasSubstr("1 min → 1.4 min"));
  EXPECT_THAT(reasons[0], HasSubstr("output 2 ← input 2"));
  EXPECT_THAT(reasons[1], HasSubstr("30 → 80 periods, 112 min"));
  EXPECT_THAT(reasons[2], HasSubstr("5 → 20 moves"));
}

TEST(RetuningTest, KeepsThePeriodOfARunningLoop) {
  std::vector<std::string> reasons;
  const auto tuning = TuneByRules(
      WoodBerryElements(), {InputRole::kManipulated, InputRole::kManipulated},
      0.2, PaperTuning(), {.keep_control_period = true}, reasons);
  ASSERT_TRUE(tuning.ok());
  EXPECT_EQ(tuning->control_period, 1.0);
  // 5 · 21 + 3 + 2.
  EXPECT_EQ(tuning->prediction_horizon, 110);
}

// The rule's sum approximates the mean diagonal of the dynamic matrix's Gram
// matrix, which is what it was derived from. The continuous formula is off by
// about a period of some 40.
TEST(RetuningTest, MoveWeightMatchesTheHessianItStandsFor) {
  const TransferFunction element = TransferFunction::FirstOrder(2.0, 20.0, 5.0);
  MpcOptions old;
  old.output_weight = MatrixXd::Constant(1, 1, 0.7);
  old.move_weight = MatrixXd::Constant(1, 1, 1.0);
  std::vector<std::string> reasons;
  const auto tuning =
      TuneByRules({{2.0, 20.0, 5.0}}, {InputRole::kManipulated}, 0.0, old,
                  {.condition_number = 100.0}, reasons);
  ASSERT_TRUE(tuning.ok());
  const int H_p = tuning->prediction_horizon;
  const int H_c = tuning->control_horizon;
  const Eigen::VectorXd s =
      element.StepResponse(tuning->control_period, H_p + 1);
  double trace = 0.0;
  for (int j = 1; j <= H_c; ++j) {
    for (int i = j; i <= H_p; ++i) trace += 0.7 * s[i - j] * s[i - j];
  }
  EXPECT_NEAR(tuning->move_weight(0, 0), trace / 100.0, 0.05 * trace / 100.0);
}

// The Hessian of a level's control problem, whose first H_c moves act from
// instants 1 … H_c on, made up from its ramp.
TEST(RetuningTest, MoveWeightOfALevelMatchesTheHessianItStandsFor) {
  const double K = 0.3;
  const std::vector<FirstOrder> level = {{K, 0.0, 6.0, true}};
  RetuningOptions options;
  std::vector<std::string> reasons;
  MpcOptions old;
  old.output_weight = MatrixXd::Identity(1, 1) * 2.0;
  old.move_weight = MatrixXd::Identity(1, 1);
  const auto tuning =
      TuneByRules(level, {InputRole::kManipulated}, 0.5, old, options, reasons);
  ASSERT_TRUE(tuning.ok()) << tuning.status();
  EXPECT_EQ(tuning->control_period, 3.0);
  EXPECT_EQ(tuning->prediction_horizon, 24);  // 10 · 6/3 + 6/3 + 2
  EXPECT_EQ(tuning->control_horizon, 4);      // 6/3 + 2
  const int H_p = tuning->prediction_horizon;
  const int H_c = tuning->control_horizon;
  const double slope = 3.0 * K;
  const double end = H_p * (H_p + 1.0) * (2.0 * H_p + 1.0) / 6.0;
  double trace = 0.0;
  for (int move = 1; move <= H_c; ++move) {
    for (int i = 1; i <= H_p; ++i) {
      // S_{i−move}, 2 periods of dead time: a ramp from there on.
      const double S = slope * std::max(i - move - 2, 0);
      trace += 2.0 * S * S;
    }
    trace += 2.0 * end * slope * slope;
  }
  EXPECT_NEAR(tuning->move_weight(0, 0), trace / options.condition_number,
              1e-9 * trace);
  EXPECT_THAT(reasons[1], HasSubstr("what a loop on a level takes"));
}

TEST(RetuningTest, LevelsAreTunedToStableAndCalmLoops) {
  for (const double T : {0.0, 1.0, 10.0}) {
    for (const double L : {0.5, 4.0}) {
      for (const double factor : {0.6, 1.5}) {
        SCOPED_TRACE(::testing::Message() << T << " " << L << " " << factor);
        ProcessModel model = EmptyModel(2, 2);
        model.element(0, 0) = TransferFunction::Integrator(0.2, T, L);
        model.element(0, 1) = TransferFunction::Integrator(-0.1, 0.0, 1.0);
        model.element(1, 1) = TransferFunction::FirstOrder(1.5, 6.0, 2.0);
        ProcessModel aged = model;
        aged.element(0, 0) = TransferFunction::Integrator(0.2 * factor, T, L);
        MpcOptions old = PaperTuning();
        const auto advice = AdviseRetuning(
            *PredictFromProcess(model, 1.0), old,
            aged.ComputeStepResponse(
                0.5, static_cast<int>(6.0 * SettlingTime(aged)) + 1),
            {});
        ASSERT_TRUE(advice.ok()) << advice.status();
        EXPECT_TRUE(advice->retuned.stable);
        EXPECT_LE(advice->retuned.sensitivity_peak, 2.0);
        EXPECT_TRUE(advice->elements[0].integrating);
        EXPECT_NEAR(advice->elements[0].gain, 0.2 * factor, 1e-6);
      }
    }
  }
}

TEST(RetuningTest, SaysWhatTheOldTuningWouldDo) {
  const auto old_model = PredictFromProcess(WoodBerry(0.0), 1.0);
  ASSERT_TRUE(old_model.ok());
  MpcOptions old = PaperTuning();
  old.disturbance_variance_ratio = 10.0;  // too nervous for 4 min more
  const StepResponse corrected = WoodBerry(4.0).ComputeStepResponse(0.2, 1001);
  const absl::StatusOr<RetuningAdvice> advice =
      AdviseRetuning(*old_model, old, corrected, {.time_unit = "min"});
  ASSERT_TRUE(advice.ok()) << advice.status();
  EXPECT_FALSE(advice->running.stable);
  EXPECT_TRUE(advice->exchanged.stable);
  EXPECT_TRUE(advice->retuned.stable);
  EXPECT_LE(advice->retuned.sensitivity_peak, 2.0);
  EXPECT_THAT(advice->reasons[advice->reasons.size() - 3],
              HasSubstr("unstable"));
  // Whatever the number of threads.
  const auto beside = AdviseRetuning(*old_model, old, corrected,
                                     {.threads = 2, .time_unit = "min"});
  ASSERT_TRUE(beside.ok()) << beside.status();
  EXPECT_EQ(beside->reasons, advice->reasons);
  EXPECT_EQ(beside->tuning.move_weight, advice->tuning.move_weight);
  // The advice is usable as it is.
  const auto model =
      PredictFromStepResponse(corrected, {}, advice->tuning.control_period);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_TRUE(Mpc::Create(*model, advice->tuning).ok());
}

TEST(RetuningTest, DoublesMoveWeightsUntilTheLoopIsRobust) {
  const ProcessModel process =
      SingleLoop(TransferFunction::FirstOrder(1.0, 10.0, 6.0));
  const auto old_model = PredictFromProcess(process, 1.0);
  ASSERT_TRUE(old_model.ok());
  MpcOptions old;
  old.output_weight = old.move_weight = MatrixXd::Identity(1, 1);
  const auto advice = AdviseRetuning(
      *old_model, old, process.ComputeStepResponse(0.5, 201),
      {.condition_number = 1e9, .largest_sensitivity_peak = 1.3});
  ASSERT_TRUE(advice.ok()) << advice.status();
  EXPECT_LE(advice->retuned.sensitivity_peak, 1.3);
  bool told = false;
  for (const std::string& reason : advice->reasons) {
    told = told || reason.find("doubled") != std::string::npos;
  }
  EXPECT_TRUE(told);
}

TEST(RetuningTest, RefusesWhatCannotBeTuned) {
  std::vector<std::string> reasons;
  MpcOptions old;
  old.output_weight = old.move_weight = MatrixXd::Identity(1, 1);
  EXPECT_THAT(
      std::string(TuneByRules({{0.0, 0.0, 0.0}}, {InputRole::kManipulated}, 0.1,
                              old, {}, reasons)
                      .status()
                      .message()),
      HasSubstr("nothing to tune"));
  EXPECT_THAT(
      std::string(TuneByRules({{1.0, 1.0, 0.0}}, {InputRole::kManipulated}, 0.1,
                              old, {.condition_number = 1.0}, reasons)
                      .status()
                      .message()),
      HasSubstr("condition_number = 1"));
  // Cut off long before it settles.
  const ProcessModel slow =
      SingleLoop(TransferFunction::FirstOrder(1.0, 100.0, 0.0));
  const auto old_model = PredictFromProcess(slow, 1.0);
  ASSERT_TRUE(old_model.ok());
  EXPECT_EQ(
      AdviseRetuning(*old_model, old, slow.ComputeStepResponse(1.0, 101), {})
          .status()
          .code(),
      absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace mle::control

#include "mle/correction/judgement.h"

#include <string>

#include "gtest/gtest.h"
#include "mle/model/process_model.h"

namespace mle {
namespace {

StepResponse Response(const std::string& name) {
  const auto model = ReadProcessModel(std::string(MLE_CONFIGS_DIR "/") + name);
  EXPECT_TRUE(model.ok()) << model.status();
  return model->ComputeStepResponse(0.2, 501);
}

TEST(JudgeTest, AModelIsItself) {
  const StepResponse truth = Response("wood_berry.json");
  const auto judgement = Judge(truth, truth);
  ASSERT_TRUE(judgement.ok()) << judgement.status();
  EXPECT_EQ(judgement->squared_distance, 0.0);
  EXPECT_TRUE(judgement->static_gain_error.isZero(0.0));
  ASSERT_EQ(judgement->fopdt.size(), 4U);
  // The fit of a response that is first order with dead time is exact to its
  // own tolerance.
  EXPECT_NEAR(judgement->fopdt[0].gain, 12.8, 1e-4);
  EXPECT_NEAR(judgement->fopdt[1].delay, 3.0, 1e-3);
  EXPECT_NEAR(judgement->fopdt[2].delay, 7.0, 1e-3);
  EXPECT_NEAR(judgement->fopdt[3].time_constant, 14.4, 1e-3);
  // Steepest in the first whole sample after the dead time, read at its end.
  EXPECT_NEAR(judgement->delay_impulse_peak(0, 0), 1.2, 1e-9);
  EXPECT_NEAR(judgement->delay_impulse_peak(1, 0), 7.2, 1e-9);
}

TEST(JudgeTest, MeasuresAgainstTheTruth) {
  const StepResponse truth = Response("wood_berry_gain.json");
  const StepResponse model = Response("wood_berry.json");
  const auto judgement = Judge(truth, model);
  ASSERT_TRUE(judgement.ok()) << judgement.status();
  EXPECT_NEAR(judgement->squared_distance,
              (truth.values - model.values).squaredNorm(),
              1e-9 * judgement->squared_distance);
  // What the initial model is worth in this case.
  EXPECT_NEAR(judgement->squared_distance, 19363.0, 1.0);
  // The gains' difference, but for e^{-99/16.7} and e^{-93/10.9} of it.
  EXPECT_NEAR(judgement->static_gain_error(0, 0), 6.4, 6.4 * 3e-3);
  EXPECT_NEAR(judgement->static_gain_error(1, 0), 3.3, 3.3 * 3e-4);
  EXPECT_EQ(judgement->static_gain_error(0, 1), 0.0);
}

}  // namespace
}  // namespace mle

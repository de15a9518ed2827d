// The paper's experiments: the aged Wood–Berry column under a controller that
// still believes in the initial model.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "control/mpc.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "sim/closed_loop.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

ProcessModel ReadWoodBerry(const std::string& name) {
  absl::StatusOr<ProcessModel> model =
      ReadProcessModel(std::string(MLE_CONFIG_DIR "/") + name);
  EXPECT_TRUE(model.ok()) << model.status();
  return *std::move(model);
}

// Run 1: (step, 0); run 2: (1, step).
sim::SetPointProfile SetPoints(int run) {
  if (run == 1) return {.steps = {{.output = 0, .time = 500.0, .value = 1.0}}};
  return {.steps = {{.output = 0, .time = 0.0, .value = 1.0},
                    {.output = 1, .time = 500.0, .value = 1.0}}};
}

absl::StatusOr<Record> RunExperiment(const std::string& plant, int run,
                                     double noise_variance,
                                     double variance_ratio = 0.1) {
  control::MpcOptions options;
  options.output_weight = MatrixXd::Identity(2, 2) * 0.2;
  options.move_weight = MatrixXd::Identity(2, 2) * 0.1;
  options.disturbance_variance_ratio = variance_ratio;
  absl::StatusOr<control::Mpc> mpc =
      control::Mpc::Create(ReadWoodBerry("wood_berry.json"), options);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  return sim::SimulateClosedLoop(
      ReadWoodBerry(plant),
      [&mpc](const Ref<const VectorXd>& y, const Ref<const VectorXd>& r,
             Ref<VectorXd> next) { mpc->Step(y, r, next); },
      SetPoints(run),
      {.noise_variance = noise_variance,
       .stream = static_cast<std::uint64_t>(run)});
}

// The greatest |y − r| of the samples from `begin` to `end`.
double WorstError(const Record& record, double begin, double end) {
  double worst = 0.0;
  for (int k = 0; k < record.samples(); ++k) {
    if (record.time(k) < begin - 1e-6 || record.time(k) > end + 1e-6) continue;
    const VectorXd error = record.outputs.col(k) - record.set_points.col(k);
    worst = std::max(worst, error.cwiseAbs().maxCoeff());
  }
  return worst;
}

class WoodBerryTest : public ::testing::TestWithParam<const char*> {};

// The slowest mode of the worst loop (delay) loses a decade in 65 min, from an
// error of about 0.1 at 50 min: under 1e-3 after 200 min, the length of the
// windows the records are cut to, and under 1e-6 after 400 min.
TEST_P(WoodBerryTest, SettlesAtTheSetPointBeforeAndAfterTheStep) {
  for (const int run : {1, 2}) {
    const absl::StatusOr<Record> record = RunExperiment(GetParam(), run, 0.0);
    ASSERT_TRUE(record.ok()) << record.status();
    EXPECT_EQ(record->samples(), 5001);
    for (const double start : {0.0, 500.0}) {
      EXPECT_LE(WorstError(*record, start + 200.0, start + 499.9), 1e-3);
      EXPECT_LE(WorstError(*record, start + 400.0, start + 499.9), 1e-6);
    }
    // There was something to settle from.
    EXPECT_GE(WorstError(*record, 500.0, 1000.0), 0.99);
  }
}

// In the steady part the loop adds little to the noise that is measured, and
// cannot take any away. Five standard errors of 1000 samples are 0.22 below it;
// a factor of two bounds what the moves add.
TEST_P(WoodBerryTest, KeepsTheSetPointUnderNoise) {
  const double variance = 0.001;
  for (const int run : {1, 2}) {
    const absl::StatusOr<Record> record =
        RunExperiment(GetParam(), run, variance);
    ASSERT_TRUE(record.ok()) << record.status();
    const MatrixXd error =
        (record->outputs - record->set_points).rightCols(1000);
    for (int i = 0; i < 2; ++i) {
      const double mean_square = error.row(i).squaredNorm() / 1000.0;
      EXPECT_GE(mean_square, 0.75 * variance);
      EXPECT_LE(mean_square, 2.0 * variance);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Plants, WoodBerryTest,
                         ::testing::Values("wood_berry.json",
                                           "wood_berry_gain.json",
                                           "wood_berry_delay.json"));

// Why the observer is not a plain bias update: with steam dead times 4 min
// longer than believed, the loop bears a gain of 0.27 but not of 1.
TEST(WoodBerryObserverTest, PlainBiasUpdateLosesTheDelayedPlant) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(RunExperiment("wood_berry_delay.json", 1, 0.0, 0.1).ok());
  EXPECT_EQ(
      RunExperiment("wood_berry_delay.json", 1, 0.0, infinity).status().code(),
      absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(RunExperiment("wood_berry.json", 1, 0.0, infinity).ok());
}

}  // namespace
}  // namespace mle

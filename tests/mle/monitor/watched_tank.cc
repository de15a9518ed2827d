#include "tests/mle/monitor/watched_tank.h"

#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

constexpr int kSamplesOfDay = 288;

}  // namespace

ProcessModel TankModel() {
  const absl::StatusOr<ProcessModel> model = ParseProcessModel(
      R"({"name": "tank", "time_unit": "min",
          "inputs": [{"name": "steam", "unit": ""}, {"name": "feed", "unit": ""}],
          "outputs": [{"name": "level", "unit": ""}, {"name": "heat", "unit": ""}],
          "elements": [
            {"output": "level", "input": "steam",
             "gain": 2, "time_constant": 20, "delay": 10},
            {"output": "level", "input": "feed",
             "gain": -1, "time_constant": 30, "delay": 15},
            {"output": "heat", "input": "feed",
             "gain": 0.5, "time_constant": 40, "delay": 5}]})",
      "tank");
  EXPECT_TRUE(model.ok()) << model.status();
  return *model;
}

WatchBatch SimulateTankDay(const ProcessModel& truth, const TankDay& day,
                           int lead) {
  const int samples = lead + kSamplesOfDay;
  Record record;
  record.sample_time = kTankSampleTime;
  record.inputs.setZero(2, samples);
  if (day.moves) {
    const double sign = day.seed % 2 == 0 ? 1.0 : -1.0;
    record.inputs.row(0).segment(lead + 30, 100).setConstant(sign);
    record.inputs.row(1).tail(samples - lead - 170).setConstant(-sign);
  }
  const absl::StatusOr<Eigen::MatrixXd> response =
      SimulateResponse(truth, kTankSampleTime, record.inputs);
  EXPECT_TRUE(response.ok()) << response.status();
  GaussianNoise noise(day.seed, kRunStream);
  record.outputs = *response + noise.DrawMatrix(2, samples, kTankNoise);
  record.outputs.array() += day.level;
  return {.record = std::move(record), .first = lead};
}

}  // namespace mle

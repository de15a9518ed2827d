#include "benchmarks/tuned_plant.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "control/first_order.h"
#include "control/retuning.h"
#include "glog/logging.h"

namespace mle::benchmarks {
namespace {

constexpr int kLongestHorizon = 60;

}  // namespace

TunedPlant TunePlant(ProcessModel model) {
  TunedPlant plant{.model = std::move(model)};
  const int p = plant.model.num_outputs();
  const int m = plant.model.num_inputs();
  control::MpcOptions before;
  before.output_weight = Eigen::MatrixXd::Identity(p, p);
  before.move_weight = Eigen::MatrixXd::Identity(m, m);
  const absl::StatusOr<std::vector<control::FirstOrder>> elements =
      control::DescribeAsFirstOrder(plant.model.ComputeStepResponse(
          SettlingTime(plant.model) / 1000.0, 3001));
  CHECK(elements.ok()) << elements.status();
  std::vector<std::string> unused;
  const absl::StatusOr<control::MpcOptions> tuning = control::TuneByRules(
      *elements, InputRoles(plant.model), 0.0, before, {}, unused);
  CHECK(tuning.ok()) << tuning.status();
  plant.tuning = *tuning;
  plant.tuning.prediction_horizon =
      std::min(plant.tuning.prediction_horizon, kLongestHorizon);
  plant.tuning.control_horizon =
      std::min(plant.tuning.control_horizon, plant.tuning.prediction_horizon);
  plant.sample_time = plant.tuning.control_period / plant.samples_of_period;
  std::vector<double> lags;
  for (const control::FirstOrder& element : *elements) {
    if (element.gain != 0.0) lags.push_back(element.time_constant);
  }
  std::sort(lags.begin(), lags.end());
  plant.lag = lags[lags.size() / 2] / plant.sample_time;
  absl::StatusOr<control::PredictionModel> prediction =
      control::PredictFromProcess(plant.model, plant.tuning.control_period);
  CHECK(prediction.ok()) << prediction.status();
  plant.prediction = *std::move(prediction);
  return plant;
}

TunedPlant ReadTunedPlant(const std::string& path) {
  absl::StatusOr<ProcessModel> model = ReadProcessModel(path);
  CHECK(model.ok()) << model.status();
  return TunePlant(*std::move(model));
}

}  // namespace mle::benchmarks

// Puts a corrected model into a running predictive controller, without a bump:
// corrected_model_in_mpc MODEL.json RECORD.csv CONTROL_PERIOD

#include <cstdio>
#include <cstdlib>

#include "control/mpc.h"
#include "mle/mle.h"

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const auto model = mle::ReadProcessModel(argv[1]);
  if (!model.ok()) return 2;
  mle::control::MpcOptions tuning;
  tuning.control_period = std::atof(argv[3]);
  tuning.output_weight =
      Eigen::MatrixXd::Identity(model->num_outputs(), model->num_outputs());
  tuning.move_weight =
      0.1 * Eigen::MatrixXd::Identity(model->num_inputs(), model->num_inputs());
  auto mpc = mle::control::Mpc::Create(*model, tuning);
  const auto result = mle::CorrectFromRecords(argv[1], {argv[2]}, {}, {});
  if (!mpc.ok() || !result.ok()) {
    std::fprintf(stderr, "%s%s\n", mpc.status().ToString().c_str(),
                 result.status().ToString().c_str());
    return 2;
  }
  if (!result->accepted()) return 1;
  const auto corrected = mle::control::PredictFromProcess(
      result->fopdt_model, tuning.control_period);
  if (!corrected.ok()) return 2;
  const absl::Status exchanged = mpc->ExchangeModel(*corrected, tuning);
  std::printf("%s\n", exchanged.ToString().c_str());
  return exchanged.ok() ? 0 : 2;
}

// Records of a tank whose set point changes at known times, with a known
// controller's moves as steps of the input.

#ifndef TESTS_MLE_MAINTAIN_TANK_RECORDS_H_
#define TESTS_MLE_MAINTAIN_TANK_RECORDS_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "mle/base/random.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/process_simulator.h"

namespace mle::testing {

inline ProcessModel Tank(double gain, double delay = 1.5) {
  ProcessModel model("tank", "min", {InputChannel{"valve", "%"}},
                     {OutputChannel{"level", "m"}});
  model.element(0, 0) = TransferFunction::FirstOrder(gain, 5.0, delay);
  return model;
}

// 900 samples of 0.5 min: the set point goes up at 100 min and down at 300 min,
// and the valve with it.
inline Record TankRecord(const ProcessModel& plant, double noise,
                         std::uint64_t seed) {
  Record record;
  record.sample_time = 0.5;
  record.inputs = Eigen::MatrixXd::Zero(1, 900);
  record.inputs.middleCols(200, 20).setConstant(1.5);
  record.inputs.middleCols(220, 380).setOnes();
  record.inputs.middleCols(600, 20).setConstant(-0.5);
  record.set_points = Eigen::MatrixXd::Zero(1, 900);
  record.set_points.middleCols(200, 400).setOnes();
  record.outputs = *SimulateResponse(plant, 0.5, record.inputs);
  record.outputs +=
      GaussianNoise(seed, 0, kMeasurementNoise).DrawMatrix(1, 900, noise);
  return record;
}

}  // namespace mle::testing

#endif  // TESTS_MLE_MAINTAIN_TANK_RECORDS_H_

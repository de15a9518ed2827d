// A plant of 15 outputs and 40 inputs, of whose pairs a tenth exist, whose
// inputs are moved by hand.

#ifndef TESTS_MLE_MAINTAIN_LARGE_PLANT_H_
#define TESTS_MLE_MAINTAIN_LARGE_PLANT_H_

#include <random>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/process_simulator.h"

namespace mle::testing {

// Without elements; times in minutes.
inline ProcessModel NumberedChannels(int num_outputs, int num_inputs) {
  std::vector<InputChannel> inputs;
  std::vector<OutputChannel> outputs;
  for (int j = 0; j < num_inputs; ++j) {
    inputs.push_back({"u" + std::to_string(j), ""});
  }
  for (int i = 0; i < num_outputs; ++i) {
    outputs.push_back({"y" + std::to_string(i), ""});
  }
  return ProcessModel("plant", "min", inputs, outputs);
}

inline ProcessModel LargeModel() {
  constexpr int kOutputs = 15;
  constexpr int kInputs = 40;
  ProcessModel model = NumberedChannels(kOutputs, kInputs);
  for (int e = 0; e < 4 * kOutputs; ++e) {
    const int i = e % kOutputs;
    model.element(i, 11 * e % kInputs) = TransferFunction::FirstOrder(
        (e % 2 == 0 ? 1.0 : -1.0) * (1.0 + 0.1 * (e % 7)), 4.0 + e % 5,
        1.0 + e % 4);
  }
  return model;
}

// 1,500 min.
inline Record LargeRecord() {
  const ProcessModel model = LargeModel();
  constexpr int kSamples = 1500;
  std::mt19937_64 source(5);
  std::normal_distribution<double> normal;
  Record record;
  record.sample_time = 1.0;
  record.inputs.setZero(model.num_inputs(), kSamples);
  for (int j = 0; j < model.num_inputs(); ++j) {
    for (int k = 1; k < kSamples; ++k) {
      const bool moves = source() % 25 == 0;
      record.inputs(j, k) = moves ? normal(source) : record.inputs(j, k - 1);
    }
  }
  absl::StatusOr<Eigen::MatrixXd> outputs =
      SimulateResponse(model, record.sample_time, record.inputs);
  EXPECT_TRUE(outputs.ok()) << outputs.status();
  record.outputs = *std::move(outputs);
  for (double& y : record.outputs.reshaped()) y += 0.05 * normal(source);
  return record;
}

}  // namespace mle::testing

#endif  // TESTS_MLE_MAINTAIN_LARGE_PLANT_H_

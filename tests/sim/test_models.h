// Process models for the tests of the simulation and of the controller.

#ifndef TESTS_SIM_TEST_MODELS_H_
#define TESTS_SIM_TEST_MODELS_H_

#include <string>
#include <utility>
#include <vector>

#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"

namespace mle::testing {

// All elements zero; inputs u1 … um, outputs y1 … yp.
inline ProcessModel EmptyModel(int num_outputs, int num_inputs) {
  std::vector<InputChannel> inputs;
  std::vector<OutputChannel> outputs;
  for (int j = 1; j <= num_inputs; ++j) {
    inputs.push_back(
        {.name = std::string("u").append(std::to_string(j)), .unit = "1"});
  }
  for (int i = 1; i <= num_outputs; ++i) {
    outputs.push_back(
        {.name = std::string("y").append(std::to_string(i)), .unit = "1"});
  }
  return ProcessModel("test", "min", std::move(inputs), std::move(outputs));
}

inline ProcessModel SingleLoop(const TransferFunction& element) {
  ProcessModel model = EmptyModel(1, 1);
  model.element(0, 0) = element;
  return model;
}

// K (τs + 1) / ((T₁s + 1)(T₂s + 1)) e^{-Ls}.
inline TransferFunction SecondOrder(double gain, double lead, double T1,
                                    double T2, double delay) {
  return TransferFunction({gain * lead, gain}, {T1 * T2, T1 + T2, 1.0}, delay);
}

// Two outputs, three inputs: a first-order element, an inverse response, an
// underdamped one, feedthrough, a static gain and an absent pair; dead times on
// and off the grid of Δt = 0.2.
inline ProcessModel MixedModel() {
  ProcessModel model = EmptyModel(2, 3);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 3.0, 0.6);
  model.element(0, 1) = SecondOrder(-1.5, -0.8, 2.0, 0.7, 0.33);
  model.element(0, 2) = TransferFunction({0.5}, {1.0}, 0.25);
  model.element(1, 0) = TransferFunction({0.9}, {1.0, 0.4, 1.0}, 1.07);
  model.element(1, 1) = TransferFunction({1.2, 0.4}, {2.5, 1.0}, 0.0);
  return model;
}

}  // namespace mle::testing

#endif  // TESTS_SIM_TEST_MODELS_H_

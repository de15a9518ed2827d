// A model of one output and two inputs of different speed, settled after 47
// min.

#ifndef TESTS_MLE_MAINTAIN_TWO_INPUT_MODEL_H_
#define TESTS_MLE_MAINTAIN_TWO_INPUT_MODEL_H_

#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"

namespace mle::testing {

inline ProcessModel TwoInputModel() {
  ProcessModel model("two inputs", "min", {{"a", ""}, {"b", ""}}, {{"y", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 6.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-1.0, 9.0, 2.0);
  return model;
}

}  // namespace mle::testing

#endif  // TESTS_MLE_MAINTAIN_TWO_INPUT_MODEL_H_

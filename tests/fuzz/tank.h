// A process with two inputs and two outputs, for records of any content.

#ifndef TESTS_FUZZ_TANK_H_
#define TESTS_FUZZ_TANK_H_

#include "mle/model/process_model.h"

namespace mle::fuzz {

inline const ProcessModel& Tank() {
  static const ProcessModel* const tank = [] {
    auto* model =
        new ProcessModel("tank", "min", {{"steam", "kg/h"}, {"inflow", "m3/h"}},
                         {{"level", "m"}, {"temperature", "degC"}});
    model->element(0, 1) = TransferFunction::FirstOrder(1.0, 5.0, 0.0);
    model->element(1, 0) = TransferFunction::FirstOrder(0.8, 3.0, 1.5);
    model->element(1, 1) = TransferFunction::FirstOrder(-2.0, 4.0, 0.5);
    return model;
  }();
  return *tank;
}

}  // namespace mle::fuzz

#endif  // TESTS_FUZZ_TANK_H_

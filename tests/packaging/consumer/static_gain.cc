// Uses the model alone: exits with 0 if a first-order element read from JSON
// settles at its gain.

#include <cmath>
#include <cstdio>

#include "mle/model/process_model.h"

int main() {
  const auto model = mle::ParseProcessModel(R"({
    "name": "tank",
    "time_unit": "min",
    "inputs": [{"name": "valve", "unit": "%"}],
    "outputs": [{"name": "level", "unit": "m"}],
    "elements": [{"output": "level", "input": "valve",
                  "gain": 2.5, "time_constant": 4.0, "delay": 1.0}]
  })",
                                            "static_gain.cc");
  if (!model.ok()) {
    std::fprintf(stderr, "%s\n", model.status().ToString().c_str());
    return 1;
  }
  // exp(−100) of the way is left after 100 time constants.
  const mle::StepResponse response = model->ComputeStepResponse(1.0, 402);
  const double end = mle::FinalValues(response)(0, 0);
  std::printf("static gain %.17g\n", end);
  return std::abs(end - 2.5) < 1e-9 ? 0 : 1;
}

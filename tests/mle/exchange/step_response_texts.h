// A step-response model of a heated tank: two inputs, one output, twelve
// coefficients at an interval of 2 min.

#ifndef TESTS_MLE_EXCHANGE_STEP_RESPONSE_TEXTS_H_
#define TESTS_MLE_EXCHANGE_STEP_RESPONSE_TEXTS_H_

#include <string>

namespace mle {

inline constexpr char kTankCsv[] =
    "name,Heated tank\n"
    "time unit,min\n"
    "interval,2\n"
    "input,steam,t/h\n"
    "input,inflow,m3/h,disturbance\n"
    "output,temperature,degC\n"
    "time,temperature/steam,temperature/inflow\n"
    "2,0,-0.1\n"
    "4,1.5,-0.2\n"
    "6,2.5,-0.27\n"
    "8,3.25,-0.32\n"
    "10,3.8,-0.36\n"
    "12,4.15,-0.39\n"
    "14,4.4,-0.41\n"
    "16,4.6,-0.43\n"
    "18,4.75,-0.44\n"
    "20,4.85,-0.45\n"
    "22,4.9,-0.455\n"
    "24,4.93,-0.46\n";

inline constexpr char kTankJson[] = R"({
  "name": "Heated tank", "time_unit": "min",
  "inputs": [{"name": "steam", "unit": "t/h"},
             {"name": "inflow", "unit": "m3/h", "role": "disturbance"}],
  "outputs": [{"name": "temperature", "unit": "degC"}],
  "interval": 2,
  "step_responses": [
    {"output": "temperature", "input": "steam", "coefficients":
     [0, 1.5, 2.5, 3.25, 3.8, 4.15, 4.4, 4.6, 4.75, 4.85, 4.9, 4.93]},
    {"output": "temperature", "input": "inflow", "end": "ramp", "coefficients":
     [-0.1, -0.2, -0.27, -0.32, -0.36, -0.39, -0.41, -0.43, -0.44, -0.45, -0.455,
      -0.46]}
  ]
})";

}  // namespace mle

#endif  // TESTS_MLE_EXCHANGE_STEP_RESPONSE_TEXTS_H_

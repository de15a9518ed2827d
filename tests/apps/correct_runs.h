// Records for mle_correct, made by mle_simulate, and the command run on them.

#ifndef TESTS_APPS_CORRECT_RUNS_H_
#define TESTS_APPS_CORRECT_RUNS_H_

#include <string>
#include <vector>

#include "apps/report/process.h"
#include "nlohmann/json.hpp"
#include "tests/apps/command_runner.h"

namespace mle {

// A small plant of two inputs and outputs that settles within 35 min.
struct HeaterElement {
  double gain;
  double time_constant;
  double delay;
};
struct Heater {
  HeaterElement first = {2.0, 5.0, 1.0};    // of input u1 on output y1
  HeaterElement second = {-0.8, 6.0, 2.0};  // of u2 on y1
  HeaterElement third = {0.7, 4.0, 1.5};    // of u1 on y2
  HeaterElement fourth = {1.5, 5.0, 2.5};   // of u2 on y2
};

// As a process model file. Times are `time_factor` times those above.
std::string HeaterJson(const Heater& heater,
                       const std::string& time_unit = "min",
                       double time_factor = 1.0);

// A run of the plant with a set-point change of each output: a record of 250
// min every 0.25 min. Further flags are those of mle_simulate.
std::string SimulateHeater(const ScratchFolder& scratch,
                           const std::string& name, const std::string& model,
                           const std::string& plant,
                           const std::vector<std::string>& more = {});

// Flags for a run that draws nothing and writes to `folder`.
std::vector<std::string> CorrectionFlags(
    const std::string& model, const std::string& data,
    const std::string& folder, const std::vector<std::string>& more = {});

// Runs mle_correct, which must end with `exit_code`, and gives its result.
nlohmann::json Correct(const std::vector<std::string>& flags,
                       const std::string& folder, int exit_code = 0);

// The plant once the gain of its first pair has halved.
Heater WithHalvedGain();

// A model, an aged plant, and a record of it.
struct HeaterExample {
  explicit HeaterExample(const Heater& aged,
                         const std::vector<std::string>& more = {})
      : model(scratch.Write("model.json", HeaterJson(Heater()))),
        plant(scratch.Write("plant.json", HeaterJson(aged))),
        data(SimulateHeater(scratch, "run.csv", model, plant, more)),
        out(scratch / "out") {}

  nlohmann::json Run(std::vector<std::string> more = {},
                     int exit_code = 0) const {
    more.push_back("--truth=" + plant);
    return Correct(CorrectionFlags(model, data, out, more), out, exit_code);
  }

  const ScratchFolder scratch;
  std::string model, plant, data, out;
};

// The entry of a pair in result.json.
nlohmann::json ElementOf(const nlohmann::json& result,
                         const std::string& output, const std::string& input);

}  // namespace mle

#endif  // TESTS_APPS_CORRECT_RUNS_H_

#include "tests/apps/correct_runs.h"

#include "absl/strings/str_format.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

std::string ElementJson(const char* output, const char* input,
                        const HeaterElement& element, double factor) {
  return absl::StrFormat(
      R"({"output": "%s", "input": "%s", "gain": %g, "time_constant": %g, "delay": %g})",
      output, input, element.gain, factor * element.time_constant,
      factor * element.delay);
}

}  // namespace

Heater WithHalvedGain() {
  Heater aged;
  aged.first.gain = 1.0;
  return aged;
}

std::string HeaterJson(const Heater& heater, const std::string& time_unit,
                       double time_factor) {
  return absl::StrFormat(
      R"({"name": "heater", "time_unit": "%s",
"inputs": [{"name": "u1", "unit": "%%"}, {"name": "u2", "unit": "%%"}],
"outputs": [{"name": "y1", "unit": "K"}, {"name": "y2", "unit": "K"}],
"elements": [%s,
%s,
%s,
%s]})",
      time_unit, ElementJson("y1", "u1", heater.first, time_factor),
      ElementJson("y1", "u2", heater.second, time_factor),
      ElementJson("y2", "u1", heater.third, time_factor),
      ElementJson("y2", "u2", heater.fourth, time_factor));
}

std::string SimulateHeater(const ScratchFolder& scratch,
                           const std::string& name, const std::string& model,
                           const std::string& plant,
                           const std::vector<std::string>& more) {
  const std::string out = scratch / name;
  std::vector<std::string> line = {"--model=" + model,
                                   "--plant=" + plant,
                                   "--out=" + out,
                                   "--sample_time=0.25",
                                   "--control_period=0.5",
                                   "--duration=250",
                                   "--setpoints=y1:60:1,y2:170:1",
                                   "--noise_variance=1e-3"};
  line.insert(line.end(), more.begin(), more.end());
  const absl::StatusOr<report::ProcessResult> result =
      report::RunProcess(MLE_SIMULATE_COMMAND, line, "");
  EXPECT_TRUE(result.ok()) << result.status();
  if (result.ok()) {
    EXPECT_EQ(result->exit_code, 0) << result->err;
  }
  return out;
}

std::vector<std::string> CorrectionFlags(const std::string& model,
                                         const std::string& data,
                                         const std::string& folder,
                                         const std::vector<std::string>& more) {
  std::vector<std::string> flags = {"--model=" + model, "--data=" + data,
                                    "--out=" + folder, "--figures=false",
                                    "--conversion_samples=5000"};
  flags.insert(flags.end(), more.begin(), more.end());
  return flags;
}

nlohmann::json Correct(const std::vector<std::string>& flags,
                       const std::string& folder, int exit_code) {
  const report::ProcessResult run = RunTested(flags);
  EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
  return ParsedJson(folder + "/result.json");
}

nlohmann::json ElementOf(const nlohmann::json& result,
                         const std::string& output, const std::string& input) {
  for (const nlohmann::json& element : result["elements"]) {
    if (element["output"] == output && element["input"] == input) {
      return element;
    }
  }
  ADD_FAILURE() << "no element " << output << " ← " << input;
  return {};
}

}  // namespace mle

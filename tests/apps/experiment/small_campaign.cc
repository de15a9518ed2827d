#include "tests/apps/experiment/small_campaign.h"

namespace mle::experiment {

nlohmann::json SmallCampaign(int seeds) {
  nlohmann::json campaign = nlohmann::json::parse(R"({
    "version": 1,
    "name": "small",
    "models": [{"name": "column", "model": {
      "name": "column", "time_unit": "min",
      "inputs": [{"name": "reflux", "unit": "%"},
                 {"name": "steam", "unit": "%"}],
      "outputs": [{"name": "top", "unit": "K"},
                  {"name": "bottom", "unit": "K"}],
      "elements": [
        {"output": "top", "input": "reflux",
         "gain": 4, "time_constant": 6, "delay": 1},
        {"output": "top", "input": "steam",
         "gain": -2, "time_constant": 7, "delay": 2},
        {"output": "bottom", "input": "reflux",
         "gain": 2, "time_constant": 8, "delay": 2},
        {"output": "bottom", "input": "steam",
         "gain": -5, "time_constant": 5, "delay": 1}]}}],
    "mismatches": [
      {"name": "gain", "changes": [{"input": "reflux", "gain_factor": 0.6}]},
      {"name": "delay", "changes": [{"output": "top", "delay_shift": 2}]}],
    "windows": [{"name": "short", "duration": 300, "step_time": 150,
                 "window": 100}],
    "selections": ["paper"],
    "sample_time": 0.5,
    "order": 20,
    "response_horizon": 40,
    "lambda_grid": {"max": 1e-2, "step": 1e-4},
    "conversion": {"duration": 1000}
  })");
  campaign["seeds"] = {{"first", 1}, {"count", seeds}};
  return campaign;
}

}  // namespace mle::experiment

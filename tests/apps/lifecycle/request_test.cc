// Flags and files that mle_lifecycle cannot use: one line names the flag or
// file and what would be right.

#include "apps/lifecycle/request.h"

#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "tests/apps/requested.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::lifecycle {
namespace {

constexpr char kTank[] = R"({"name": "tank", "time_unit": "min",
  "inputs": [{"name": "steam", "unit": ""}],
  "outputs": [{"name": "level", "unit": ""}],
  "elements": [{"output": "level", "input": "steam",
                "gain": 2, "time_constant": 8, "delay": 3}]})";

TEST(LifecycleRequestTest, MistakesNameTheFlagAndWhatWouldBeRight) {
  const ScratchFolder scratch;
  const std::string tank = scratch.Write("tank.json", kTank);
  const std::string tiny = scratch.Write(
      "tiny.json",
      absl::StrReplaceAll(kTank, {{"\"gain\": 2", "\"gain\": 1e-308"}}));
  const std::string ageing =
      scratch.Write("fouling.json", R"({"time_factor": 1440,
    "elements": [{"output": "level", "input": "steam",
                  "gain": [[0, 1.0], [60, 0.5]]}]})");
  std::vector<RefusedFlags> mistakes = {
      {{"--model=/none.json"}, {"--model: cannot open '/none.json'"}},
      {{"--ageing="}, {"--ageing=FILE.json"}},
      {{"--change_every=30"}, {"--change_every=30: '30'"}},
      {{"--change_every=1h"},
       {"--change_every: changes follow each other after"}},
      {{"--change_every=1y"}, {"there would be no"}},
      {{"--policies=sometimes"},
       {"--policies=sometimes: 'sometimes': choose from never"}},
      {{"--ageing_rates=1,-2"}, {"--ageing_rates=1,-2: '-2'"}},
      {{"--seeds=0"}, {"--seeds=0"}},
      {{"--setpoint_range=0"}, {"--setpoint_range=0"}},
      {{"--price_movement=-1"}, {"--price_movement"}},
      {{"--currency=pounds sterling"},
       {"--currency=pounds sterling: is 15 characters long"}},
      {{"--sample_time=0.3"}, {"--control_period=1"}},
      {{"--sample_time=1e-6", "--years=1"},
       {"samples of --sample_time=1e-06; at most 1e+07"}},
      {{"--response_horizon=1e12"},
       {"--response_horizon=1000000000000: it has 1e+12"}},
      {{"--years=1000", "--change_every=1000y", "--every_sample"},
       {"--change_every"}},
      {{"--control_horizon=30000", "--prediction_horizon=30000"},
       {"prediction_horizon = 30000 with 30000 moves"}},
      {{"--solver=simplex"}, {"--solver=simplex: choose from homotopy"}},
      {{"--robust=tukey"}, {"--robust=tukey: choose from none, huber"}},
      {{"--ageing_rates=1,1"}, {"--ageing_rates: '1' is duplicated"}},
      {{"--ageing_rates="}, {"--ageing_rates: names no rate"}},
      {{"--plant=/none.json"}, {"--plant: cannot open '/none.json'"}},
      {{"--window_age=soon"}, {"--window_age=soon: 'soon'"}},
      {{"--test_move=0"}, {"--test_move=0"}},
      {{"--first_seed=18446744073709551615"},
       {"--first_seed=18446744073709551615"}},
      {{"--years=0"}, {"--years=0"}},
      {{"--windows=0"}, {"--windows=0"}},
      {{"--test_cycles=0"}, {"--test_cycles=0"}},
      {{"--validation_folds=1"}, {"--validation_folds=1"}},
      {{"--conversion_samples=1"}, {"--conversion_samples=1"}},
      {{"--watch_limit=0.5"}, {"--watch_limit=0.5"}},
      {{"--false_alarm_probability=1"}, {"--false_alarm_probability=1"}},
      {{"--test_hold=-1"}, {"--test_hold=-1"}},
      {{"--threads=-1"}, {"--threads=-1"}},
      {{"--disturbance_time=x"}, {"--disturbance_time=x: 'x'"}},
      {{"--prediction_horizon=2"}, {"--prediction_horizon"}},
      {{"--model=" + tiny, "--ageing_rates=0"},
       {"--setpoint_range are not finite"}},
  };
  // Sixty days of a tank, a change every fifth; what is wrong comes last.
  for (RefusedFlags& mistake : mistakes) {
    const std::vector<std::string> given = {
        "--model=" + tank,   "--ageing=" + ageing, "--years=0.165",
        "--change_every=5d", "--sample_time=1",    "--move_weight=2"};
    mistake.flags.insert(mistake.flags.begin(), given.begin(), given.end());
  }
  ExpectRefused<Request>(mistakes);
}

}  // namespace
}  // namespace mle::lifecycle

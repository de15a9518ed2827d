// A damaged state of mle_watch: what is read of it makes pages, or is an error.

#include "apps/watch/health.h"
#include "apps/watch/report.h"
#include "apps/watch/state.h"
#include "nlohmann/json.hpp"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/scratch_file.h"
#include "tests/fuzz/tank.h"

namespace mle::watch {
namespace {

void Show(State& state, const std::string& name) {
  const ProcessModel& tank = fuzz::Tank();
  const absl::StatusOr<Watch> watch = state.Load(name, tank.num_outputs());
  if (!watch.ok()) {
    FUZZ_EXPECT(watch.status().message().find("state: ") == 0,
                watch.status().ToString());
    return;
  }
  Controller controller;
  controller.name = name;
  const std::vector<Report> reports = {MakeReport(controller, tank, *watch)};
  FUZZ_EXPECT(!FormatControllerPage(reports[0], "/nowhere", true).empty());
  FUZZ_EXPECT(!FormatOverview(reports).empty());
  FUZZ_EXPECT(!FormatAlarmsPage(reports).empty());
  FUZZ_EXPECT(!FormatMetrics(reports, 0).empty());
  for (const std::string& json :
       {FormatReports(reports), FormatController(reports[0]),
        FormatControllers(reports), FormatAlarms(reports, true),
        FormatHistory(reports[0], 0, 30'000)}) {
    FUZZ_EXPECT(nlohmann::json::accept(json), json);
  }
  Watch copy = *watch;
  state.Save(copy).IgnoreError();
}

}  // namespace
}  // namespace mle::watch

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  const std::string_view bytes = mle::fuzz::Bytes(data, size).Rest();
  const mle::fuzz::ScratchFolder folder;
  auto state = mle::watch::State::Open(folder.Write("state.sqlite", bytes));
  if (!state.ok()) {
    FUZZ_EXPECT(state.status().message().find("state: ") == 0,
                state.status().ToString());
    return 0;
  }
  mle::watch::Show(*state, "tank");
  mle::watch::Show(*state, "none");
  for (const mle::watch::Channel channel :
       {mle::watch::Channel::kCommand, mle::watch::Channel::kWebhook}) {
    state->Undelivered(channel).IgnoreError();
  }
  state->FindAlarm("0").IgnoreError();
  state->Acknowledge("0", {.who = "Ann", .at = 1}).IgnoreError();
  return 0;
}

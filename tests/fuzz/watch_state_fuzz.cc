// A damaged state of mle_watch: what is read of it makes pages, or is an error.
// The first byte says what the others are: changes of a whole state (places and
// bytes), a file, or scores, a trial or a reference as they are kept in one.

#include "apps/watch/health.h"
#include "apps/watch/report.h"
#include "apps/watch/state.h"
#include "mle/base/file.h"
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

// Two days of the tank, with an alarm, a correction and a trial.
Watch WholeWatch() {
  Watch watch = EmptyWatch("tank", fuzz::Tank().num_outputs());
  watch.basis = "basis";
  watch.begin = watch.first = 20'500;
  watch.sample_time = 1.0;
  watch.reference = WatchReference{};
  watch.reference->outputs.resize(watch.outputs.size());
  watch.reference->low = watch.reference->high = Eigen::VectorXd::Ones(2);
  watch.files["day.csv"] = {.bytes = 10, .changed = 1, .first = 1, .last = 2};
  for (int day = 0; day < 2; ++day) {
    watch.days[watch.first + day] = {"x", BatchState::kUsed, ""};
    for (std::size_t i = 0; i < watch.outputs.size(); ++i) {
      const auto n = static_cast<Eigen::Index>(3 + 3 * i);  // per element 3
      StoredBatch& stored = watch.outputs[i][day];
      stored.batch.number = stored.evidence.number = day;
      stored.batch.score = Eigen::VectorXd::Ones(n);
      stored.batch.information = Eigen::MatrixXd::Identity(n, n);
      stored.evidence.log_output = 4.0 * day;
      stored.evidence.log_elements.assign(i + 1, 0.0);
    }
  }
  watch.alarms.push_back({.id = AlarmId("tank"),
                          .day = watch.first + 1,
                          .began = watch.first,
                          .text = "The model of level has aged."});
  watch.proposals.push_back({.day = watch.first + 1,
                             .folder = "proposals/tank",
                             .decision = "corrected",
                             .conclusion = "Its gain has fallen."});
  Trial& trial = watch.trials.emplace_back();
  trial.day = trial.last_day = watch.first + 1;
  trial.sample_time = 1.0;
  trial.in_use = trial.proposed = FormatProcessModel(fuzz::Tank());
  trial.state.responses.push_back({.gains = {1.0},
                                   .sizes = {1.0},
                                   .deviations = {1.0},
                                   .in_use = {2.0},
                                   .proposed = {1.0}});
  return watch;
}

// The bytes of its file.
const std::string& WholeState() {
  static const auto* const bytes = [] {
    const fuzz::ScratchFolder folder;
    const std::string path = folder.path() + "/state.sqlite";
    {
      absl::StatusOr<State> state = State::Open(path);
      FUZZ_EXPECT(state.ok(), state.status().ToString());
      Watch watch = WholeWatch();
      const absl::Status saved = state->Save(watch);
      FUZZ_EXPECT(saved.ok(), saved.ToString());
    }
    auto* const file = new std::string(*ReadFile(path));
    auto copy = State::Open(folder.Write("copy.sqlite", *file));
    FUZZ_EXPECT(copy.ok(), copy.status().ToString());
    const auto loaded = copy->Load("tank", fuzz::Tank().num_outputs());
    FUZZ_EXPECT(loaded.ok(), loaded.status().ToString());
    return file;
  }();
  return *bytes;
}

std::string Changed(std::string file, fuzz::Bytes bytes) {
  while (!bytes.empty()) {
    std::size_t place = 0;
    for (int i = 0; i < 3; ++i) place = 256 * place + bytes.Next();
    file[place % file.size()] = static_cast<char>(bytes.Next());
  }
  return file;
}

void TryFile(std::string_view bytes) {
  const fuzz::ScratchFolder folder;
  auto state = State::Open(folder.Write("state.sqlite", bytes));
  if (!state.ok()) {
    FUZZ_EXPECT(state.status().message().find("state: ") == 0,
                state.status().ToString());
    return;
  }
  Show(*state, "tank");
  Show(*state, "none");
  for (const Channel channel : {Channel::kCommand, Channel::kWebhook}) {
    state->Undelivered(channel).IgnoreError();
  }
  state->FindAlarm("0").IgnoreError();
  state->Acknowledge("0", {.who = "Ann", .at = 1}).IgnoreError();
}

// What is read of the values of a state is written so that it can be read.
void TryValues(std::string_view bytes) {
  if (const auto batch = DecodeBatch(bytes, 0, 1); batch.ok()) {
    FUZZ_EXPECT(DecodeBatch(EncodeBatch(*batch), 0, 1).ok());
  }
  if (const auto trial = DecodeTrial(bytes); trial.ok()) {
    FUZZ_EXPECT(DecodeTrial(EncodeTrial(*trial)).ok());
  }
  if (const auto reference = DecodeReference(std::string(bytes));
      reference.ok()) {
    FUZZ_EXPECT(DecodeReference(EncodeReference(*reference)).ok());
  }
}

}  // namespace
}  // namespace mle::watch

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  switch (bytes.Next() % 3) {
    case 0:
      mle::watch::TryFile(mle::watch::Changed(mle::watch::WholeState(), bytes));
      break;
    case 1:
      mle::watch::TryFile(bytes.Rest());
      break;
    default:
      mle::watch::TryValues(bytes.Rest());
  }
  return 0;
}

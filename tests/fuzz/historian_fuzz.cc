// The import of historians' files, with options from the first bytes, and what
// looks at the records it makes: channel health, changes, windows.

#include <cmath>
#include <utility>

#include "mle/data/channel_health.h"
#include "mle/data/historian.h"
#include "mle/data/set_point_windows.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/tank.h"

namespace mle {
namespace {

constexpr std::int64_t kMaxSamples = 5000;

HistorianOptions OptionsFrom(fuzz::Bytes& bytes) {
  HistorianOptions options;
  const int flags = bytes.Next();
  options.columns.ignore_other_columns = (flags & 1) != 0;
  options.skip_repeated_times = (flags & 2) != 0;
  options.skip_backward_times = (flags & 4) != 0;
  if ((flags & 16) != 0) {
    options.columns.tags = {{"TI 101.PV", "temperature", 0.5, -32.0}};
  }
  if ((flags & 32) != 0) options.bad_values = {"-9999", "BAD"};
  const int more = bytes.Next();
  options.separator = "\0\0,;\t"[more % 5];
  options.decimal = "\0\0.,"[more / 5 % 4];
  options.sample_time = more % 3 == 0 ? 0.0 : more % 3 * 0.5;
  options.max_gap = more % 7 - 1.0;
  const int text = bytes.Next();
  options.lines_above_header = text % 3;
  options.rows_below_header = text / 3 % 2;
  options.clock.format =
      static_cast<TimeFormat>(text / 6 % 5 + (flags & 64) / 64 * 5);
  if (text / 30 % 2 == 1) options.clock.time_zone = "Europe/Berlin";
  options.separate_files = (flags & 128) != 0;
  options.empty_fields = static_cast<EmptyFields>(more / 20 % 3);
  options.any_word_is_bad = more / 60 % 2 == 1;
  options.max_samples = kMaxSamples;
  return options;
}

void CheckRecords(const std::vector<Record>& records) {
  std::int64_t samples = 0;
  for (const Record& record : records) {
    FUZZ_EXPECT(record.Validate().ok(), record.Validate().ToString());
    FUZZ_EXPECT(!record.outputs.array().isInf().any());
    FUZZ_EXPECT(!record.inputs.array().isInf().any());
    samples += record.samples();
  }
  FUZZ_EXPECT(samples <= kMaxSamples);
}

void LookAt(std::vector<Record> records) {
  const ProcessModel& tank = fuzz::Tank();
  const HealthReport health = CheckHealth(records, tank, HealthOptions());
  FUZZ_EXPECT(!health.Report(records).empty());
  MarkBad(health, MarkOptions(), records);
  WindowOptions options;
  options.before = 2.0;
  options.after = 4.0;
  const auto windows = FindWindows(records, tank, options);
  if (!windows.ok()) return;
  for (const SetPointWindow& window : windows->windows) {
    FUZZ_EXPECT(window.record.Validate().ok());
    FUZZ_EXPECT(!window.changes.empty());
  }
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const mle::HistorianOptions options = mle::OptionsFrom(bytes);
  std::vector<mle::HistorianSource> sources;
  // Two files, if the mark is there.
  sources.push_back(
      mle::TextSource("a.csv", std::string(bytes.Until("\n====\n"))));
  if (!bytes.empty()) {
    sources.push_back(mle::TextSource("b.csv", std::string(bytes.Rest())));
  }
  const mle::ProcessModel& tank = mle::fuzz::Tank();
  auto import = mle::ImportHistorianSources(sources, tank, options);
  if (!import.ok()) {
    FUZZ_EXPECT(!import.status().message().empty());
    return 0;
  }
  FUZZ_EXPECT(!import->report.FullReport("min").empty());
  mle::CheckRecords(import->records);
  mle::LookAt(std::move(import->records));
  return 0;
}
